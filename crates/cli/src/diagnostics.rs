//! Findings about a part program: with the lines they are about for people, as documents for
//! programs.

use crate::args::Form;
use crate::excerpt::{Excerpt, excerpts};
use crate::failure::Failure;
use crate::output::{remark, stderr_has_color};
use crate::voice::Voice;
use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use lostmotion::base::{BlockRef, Span};
use lostmotion::gcode::{Diagnostics, Provenance, Severity};
use lostmotion::report::findings::{Counts, Finding, Origin, write_json, write_sarif};
use lostmotion::sim::Program;

/// What has been found in a program.
pub(crate) struct Findings<'a> {
    source: &'a Program,
    pub(crate) list: Vec<Finding>,
    pub(crate) counts: Counts,
    /// Files of subroutines that findings may be about, and the calls that led there.
    provenance: Provenance,
}

impl<'a> Findings<'a> {
    /// Nothing yet.
    pub(crate) fn none(source: &'a Program) -> Findings<'a> {
        Findings {
            source,
            list: Vec::new(),
            counts: Counts::default(),
            provenance: Provenance::default(),
        }
    }

    /// The same with what the places of findings point into.
    pub(crate) fn with_provenance(self, provenance: &Provenance) -> Findings<'a> {
        Findings {
            provenance: provenance.clone(),
            ..self
        }
    }

    /// The lines that the findings are about, in their order; empty where they cannot be read.
    fn lines(&self) -> Vec<Excerpt> {
        let own: Vec<Span> = self
            .list
            .iter()
            .map(|finding| finding.span)
            .filter(|span| span.file == 0)
            .collect();
        let mut own = self
            .source
            .open()
            .and_then(|mut reader| excerpts(&mut *reader, &own))
            .unwrap_or_default()
            .into_iter();
        let of_file = |span: Span| {
            excerpts(
                &mut self.provenance.file(span.file)?.text.as_slice(),
                &[span],
            )
            .ok()?
            .pop()
        };
        let line = |finding: &Finding| {
            if finding.span.file == 0 {
                own.next()
            } else {
                of_file(finding.span)
            }
        };
        self.list
            .iter()
            .map(line)
            .map(Option::unwrap_or_default)
            .collect()
    }

    /// Everything the front end has found.
    pub(crate) fn of(source: &'a Program, diagnostics: &Diagnostics) -> Findings<'a> {
        let origin = Origin {
            program: source.name(),
            provenance: diagnostics.provenance(),
        };
        let list = diagnostics
            .kept()
            .iter()
            .map(|diagnostic| Finding::from_diagnostic(diagnostic, &origin))
            .collect();
        let counts = Counts {
            errors: diagnostics.errors(),
            warnings: diagnostics.warnings(),
            notes: diagnostics.notes(),
        };
        Findings {
            source,
            list,
            counts,
            provenance: diagnostics.provenance().clone(),
        }
    }

    /// Adds a finding at a place.
    pub(crate) fn add(
        &mut self,
        severity: Severity,
        code: &str,
        block: BlockRef,
        message: String,
        hint: Option<String>,
    ) {
        let origin = Origin {
            program: self.source.name(),
            provenance: &self.provenance,
        };
        let (file, calls) = (origin.file(block.span.file), origin.calls(block.call_stack));
        let (code, values, excerpt) = (code.to_owned(), serde_json::Map::new(), String::new());
        self.list.push(Finding {
            code,
            severity,
            message,
            file,
            span: block.span,
            values,
            excerpt,
            hint,
            calls,
        });
        match severity {
            Severity::Error => self.counts.errors += 1,
            Severity::Warning => self.counts.warnings += 1,
            Severity::Note => self.counts.notes += 1,
        }
    }

    /// The findings in the form asked for.
    pub(crate) fn render(&self, form: Form) -> Result<String, Failure> {
        let mut out = Vec::new();
        match form {
            Form::Text => return Ok(self.text()),
            Form::Json => write_json(&mut out, &self.with_excerpts(), self.counts),
            Form::Sarif => write_sarif(&mut out, &self.with_excerpts()),
        }
        .map_err(|error| Failure::message(format!("cannot write the findings: {error}")))?;
        Ok(String::from_utf8_lossy(&out).into_owned())
    }

    /// The findings with the lines that they are about.
    fn with_excerpts(&self) -> Vec<Finding> {
        let text = |line: Excerpt| line.text.trim_end().to_owned();
        self.list
            .iter()
            .zip(self.lines())
            .map(|(finding, line)| Finding {
                excerpt: text(line),
                ..finding.clone()
            })
            .collect()
    }

    /// The failure of a program that was refused for these.
    pub(crate) fn failure(&self, voice: Voice) -> Failure {
        self.render(voice.diagnostics)
            .map_or_else(|failure| failure, Failure::Rendered)
    }

    /// Tells what has been found in a program that was accepted. A document is written even if it
    /// is empty.
    pub(crate) fn remark(&self, voice: Voice) -> Result<(), Failure> {
        if voice.diagnostics != Form::Text || (!self.list.is_empty() && !voice.quiet) {
            remark(&self.render(voice.diagnostics)?);
        }
        Ok(())
    }

    fn text(&self) -> String {
        let lines = self.lines();
        let nothing = Excerpt::default();
        let renderer = if stderr_has_color() {
            Renderer::styled()
        } else {
            Renderer::plain()
        }
        .decor_style(DecorStyle::Ascii);
        let one = |(index, finding)| {
            one(&renderer, finding, lines.get(index).unwrap_or(&nothing)) + "\n\n"
        };
        let shown: String = self.list.iter().enumerate().map(one).collect();
        format!("{shown}{}", self.count())
    }

    fn count(&self) -> String {
        let number = |n: u64, what: &str| {
            (n > 0).then(|| format!("{n} {what}{}", if n == 1 { "" } else { "s" }))
        };
        let Counts {
            errors,
            warnings,
            notes,
        } = self.counts;
        let dropped = (errors + warnings + notes).saturating_sub(self.list.len() as u64);
        let not_shown = (dropped > 0).then(|| format!("{dropped} of them not shown"));
        let parts = [
            number(errors, "error"),
            number(warnings, "warning"),
            number(notes, "note"),
            not_shown,
        ];
        let text = parts.into_iter().flatten().collect::<Vec<_>>().join(", ");
        if text.is_empty() { text } else { text + "\n" }
    }
}

fn one(renderer: &Renderer, finding: &Finding, line: &Excerpt) -> String {
    if finding.severity == Severity::Note {
        // A habit of the file, told in a line.
        let hint = finding
            .hint
            .as_ref()
            .map(|hint| format!(" ({hint})"))
            .unwrap_or_default();
        return format!(
            "note[{}]: {}, {}: {}{hint}",
            finding.code, finding.file, finding.span, finding.message
        );
    }
    let level = match finding.severity {
        Severity::Error => Level::ERROR,
        _ => Level::WARNING,
    };
    let span = finding.span;
    let name = finding.file.as_str();
    let title = level
        .primary_title(finding.message.as_str())
        .id(finding.code.as_str());
    let mut group = if !line.text.is_empty() {
        let mark = AnnotationKind::Primary.span(line.range.clone());
        title.element(
            Snippet::source(line.text.as_str())
                .line_start(span.line as usize)
                .path(name)
                .annotation(mark),
        )
    } else if span.line > 0 {
        title.element(Level::NOTE.message(format!("{name}, {span}")))
    } else {
        title.element(Level::NOTE.message(name))
    };
    for call in &finding.calls {
        group = group.element(Level::NOTE.message(format!(
            "in {}, called from {}, line {}",
            call.sub, call.file, call.span.line
        )));
    }
    if let Some(hint) = &finding.hint {
        group = group.element(Level::HELP.message(hint.as_str()));
    }
    renderer.render(&[group])
}
