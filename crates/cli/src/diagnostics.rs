//! Findings about a part program, each with the line it is about.

use crate::excerpt::{Excerpt, excerpts};
use crate::output::stderr_has_color;
use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use lostmotion::base::Span;
use lostmotion::gcode::{Diagnostic, Diagnostics, LoadedFile, Severity, SourceFiles};
use lostmotion::sim::ProgramSource;

/// One thing to say about a place in a program.
#[derive(Clone, Debug)]
pub(crate) struct Finding {
    severity: Severity,
    /// Stable name of the kind of finding; empty for none.
    code: &'static str,
    text: String,
    span: Span,
    hint: Option<String>,
}

impl Finding {
    /// An error at a place.
    pub(crate) fn error(span: Span, text: String, hint: Option<String>) -> Finding {
        Finding { severity: Severity::Error, code: "", text, span, hint }
    }
}

impl From<&Diagnostic> for Finding {
    fn from(diagnostic: &Diagnostic) -> Finding {
        Finding {
            severity: diagnostic.severity(),
            code: diagnostic.code(),
            text: diagnostic.problem.to_string(),
            span: diagnostic.place.span,
            hint: diagnostic.hint(),
        }
    }
}

/// Renders what the front end found, in its order, then how many there were.
pub(crate) fn render(source: &ProgramSource, diagnostics: &Diagnostics) -> String {
    let findings: Vec<Finding> = diagnostics.kept().iter().map(Finding::from).collect();
    format!("{}{}", render_all(source, diagnostics.files(), &findings), count(diagnostics))
}

/// Renders findings in their order, a blank line after each.
pub(crate) fn render_all(source: &ProgramSource, files: &SourceFiles, findings: &[Finding]) -> String {
    let lines = lines(source, files, findings);
    let nothing = Excerpt::default();
    let renderer = if stderr_has_color() { Renderer::styled() } else { Renderer::plain() }.decor_style(DecorStyle::Ascii);
    let one = |(index, finding): (usize, &Finding)| {
        let name = file_of(files, finding.span).map_or(source.name(), |file| file.name.as_str());
        one(&renderer, name, finding, lines.get(index).unwrap_or(&nothing)) + "\n\n"
    };
    findings.iter().enumerate().map(one).collect()
}

/// The file of subroutines that a span is in; none for the program itself.
fn file_of(files: &SourceFiles, span: Span) -> Option<&LoadedFile> {
    files.get((span.file as usize).checked_sub(1)?).map(|file| &**file)
}

/// The lines that findings are about, in their order; empty where they cannot be read.
fn lines(source: &ProgramSource, files: &SourceFiles, findings: &[Finding]) -> Vec<Excerpt> {
    let own: Vec<Span> = findings.iter().map(|finding| finding.span).filter(|span| span.file == 0).collect();
    let mut own = source.open().and_then(|mut reader| excerpts(&mut *reader, &own)).unwrap_or_default().into_iter();
    let of_file = |span: Span| {
        let mut text = file_of(files, span)?.text.as_slice();
        excerpts(&mut text, &[span]).ok()?.pop()
    };
    findings.iter().map(|finding| if finding.span.file == 0 { own.next() } else { of_file(finding.span) }.unwrap_or_default()).collect()
}

fn one(renderer: &Renderer, name: &str, finding: &Finding, line: &Excerpt) -> String {
    let level = match finding.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let title = level.primary_title(finding.text.as_str());
    let title = if finding.code.is_empty() { title } else { title.id(finding.code) };
    let span = finding.span;
    let group = if !line.text.is_empty() {
        let mark = AnnotationKind::Primary.span(line.range.clone());
        title.element(Snippet::source(line.text.as_str()).line_start(span.line as usize).path(name).annotation(mark))
    } else if span.line > 0 {
        title.element(Level::NOTE.message(format!("{name}, {span}")))
    } else {
        title.element(Level::NOTE.message(name))
    };
    let group = match &finding.hint {
        Some(hint) => group.element(Level::HELP.message(hint.as_str())),
        None => group,
    };
    renderer.render(&[group])
}

fn count(diagnostics: &Diagnostics) -> String {
    let number = |n: u64, what: &str| (n > 0).then(|| format!("{n} {what}{}", if n == 1 { "" } else { "s" }));
    let parts = [
        number(diagnostics.errors(), "error"),
        number(diagnostics.warnings(), "warning"),
        (diagnostics.dropped() > 0).then(|| format!("{} of them not shown", diagnostics.dropped())),
    ];
    format!("{}\n", parts.into_iter().flatten().collect::<Vec<_>>().join(", "))
}
