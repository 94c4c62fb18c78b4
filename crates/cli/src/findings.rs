//! Findings about a part program: with the lines they are about for people, as documents for
//! programs.

use crate::output::{Failure, remark, stderr_has_color};
use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use clap::ValueEnum;
use lostmotion::base::Span;
use lostmotion::gcode::{Diagnostics, Provenance, Severity};
use lostmotion::report::findings::{
    BlockRecorder, Counts, Finding, Origin, write_json, write_sarif,
};
use lostmotion::sim::results::MethodResult;
use lostmotion::sim::{Program, SimError};
use std::io::BufRead;

/// Form of findings about a part program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Form {
    /// With the lines they are about
    #[default]
    Text,
    /// Versioned JSON
    Json,
    /// SARIF 2.1.0
    Sarif,
}

/// How much a command says on stderr, and how.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Voice {
    /// No progress and no warnings.
    pub(crate) quiet: bool,
    /// Form of findings.
    pub(crate) diagnostics: Form,
}

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
        // The program is read once for all its findings, files of subroutines are in memory.
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
        // Own lines were fetched in the order of the findings: each of them takes the next one.
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
        // The findings kept are bounded, their counts are not.
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

    /// Adds what a run was refused for; false for an error that is about no block.
    pub(crate) fn add_error(&mut self, error: &SimError, severity: Severity) -> bool {
        // The lines are fetched when all findings are shown, in one pass over the source.
        let found = Finding::from_error(error, self.source.name());
        let count = match severity {
            Severity::Error => &mut self.counts.errors,
            Severity::Warning => &mut self.counts.warnings,
            Severity::Note => &mut self.counts.notes,
        };
        *count += found.len() as u64;
        let is_told = !found.is_empty();
        let found = found.into_iter();
        self.list.extend(found.map(|finding| Finding {
            severity,
            ..finding
        }));
        is_told
    }

    /// Adds what a run found with one of its methods: blocks outside the tolerance, and where the
    /// machine stops.
    pub(crate) fn add_run(&mut self, blocks: &BlockRecorder, method: usize, result: &MethodResult) {
        let origin = Origin {
            program: self.source.name(),
            provenance: &self.provenance,
        };
        let found = blocks.findings(method, result, &origin);
        self.counts.errors += found.len() as u64;
        self.list.extend(found);
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
        // Frames in ASCII: the same in a log file, and on a terminal without Unicode.
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
        // Counts go on when no more findings are kept.
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
    // Where the line cannot be shown the place is told in words; line 0 is the file as a whole.
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
    // Innermost first, as a stack trace is read.
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

/// Longest piece of a line that is shown, bytes. A choice: two lines of a terminal.
const EXCERPT_BYTES: usize = 160;

/// A line, or the part of a long one around a span.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Excerpt {
    /// Printable text, one byte of it for each byte of the source.
    pub(crate) text: String,
    /// Where the span lies in it.
    pub(crate) range: std::ops::Range<usize>,
}

/// Fetches the lines of spans in one pass over the source. Spans that lie beyond its end get an
/// empty text. The answer is in the order of the spans.
pub(crate) fn excerpts(source: &mut dyn BufRead, spans: &[Span]) -> std::io::Result<Vec<Excerpt>> {
    let mut order: Vec<usize> = (0..spans.len()).collect();
    // In the order of the source, whatever that of the findings: one pass suffices.
    order.sort_by_key(|index| window_start(&spans[*index]));
    let mut found = vec![Excerpt::default(); spans.len()];
    let mut window: Vec<u8> = Vec::new();
    let mut window_at = 0_u64;
    for index in order {
        let span = &spans[index];
        let start = window_start(span);
        // What the window already holds is kept; the rest up to the next place is read past.
        let skip = start - window_at;
        if skip <= window.len() as u64 {
            window.drain(..skip as usize);
        } else {
            let missing = skip - window.len() as u64;
            window.clear();
            std::io::copy(
                &mut std::io::Read::take(&mut *source, missing),
                &mut std::io::sink(),
            )?;
        }
        window_at = start;
        // Only as much of a line as is shown: a line may be as long as the file.
        let wanted = (EXCERPT_BYTES - window.len().min(EXCERPT_BYTES)) as u64;
        std::io::Read::read_to_end(&mut std::io::Read::take(&mut *source, wanted), &mut window)?;
        found[index] = excerpt(&window, (span.start - start) as usize, span.len as usize);
    }
    Ok(found)
}

/// Where the shown part of a span's line begins: at the line's start, or a third of the width
/// before the span.
fn window_start(span: &Span) -> u64 {
    // A place in the first two thirds of the width is seen from the line's start, too.
    let before = u64::from(span.column.saturating_sub(1)).min(span.start);
    let shown = if before as usize > EXCERPT_BYTES * 2 / 3 {
        (EXCERPT_BYTES / 3) as u64
    } else {
        before
    };
    span.start - shown
}

fn excerpt(window: &[u8], offset: usize, length: usize) -> Excerpt {
    let window = &window[..window.len().min(EXCERPT_BYTES)];
    // The window may reach into the next line.
    let end = window
        .iter()
        .position(|b| matches!(b, b'\n' | b'\r'))
        .unwrap_or(window.len());
    // One column a byte, so that the mark stands below its place: tabs, control characters and what
    // lies beyond ASCII become blanks.
    let text: String = window[..end]
        .iter()
        .map(|b| {
            if matches!(b, b' '..=b'~') {
                char::from(*b)
            } else {
                ' '
            }
        })
        .collect();
    // A place behind the end of the line, where a word is missing, is marked at the end.
    let from = offset.min(text.len());
    Excerpt {
        range: from..(from + length).min(text.len()),
        text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(line: u32, column: u32, start: u64, len: u32) -> Span {
        Span {
            file: 0,
            line,
            column,
            start,
            len,
        }
    }

    #[test]
    fn lines_are_found_in_any_order() {
        let text = b"G0 X1\r\nG1 Y2 F3\nM2";
        let spans = [
            span(2, 4, 10, 2),
            span(1, 1, 0, 2),
            span(3, 1, 16, 2),
            span(2, 7, 13, 2),
            span(9, 1, 99, 2),
        ];
        let found = excerpts(&mut &text[..], &spans).unwrap();
        let seen: Vec<(&str, &str)> = found
            .iter()
            .map(|e| (e.text.as_str(), &e.text[e.range.clone()]))
            .collect();
        assert_eq!(
            seen,
            [
                ("G1 Y2 F3", "Y2"),
                ("G0 X1", "G0"),
                ("M2", "M2"),
                ("G1 Y2 F3", "F3"),
                ("", "")
            ]
        );
    }

    #[test]
    fn of_a_long_line_only_the_neighbourhood_is_shown() {
        let mut text = vec![b'('; 5_000_000];
        text[4_000_000] = b'G';
        let found = excerpts(&mut text.as_slice(), &[span(1, 4_000_001, 4_000_000, 1)]).unwrap();
        assert_eq!(found[0].text.len(), EXCERPT_BYTES);
        assert_eq!(&found[0].text[found[0].range.clone()], "G");
    }

    #[test]
    fn bytes_that_are_no_text_become_blanks() {
        let found = excerpts(&mut &b"G1\0\xff X1"[..], &[span(1, 6, 5, 2)]).unwrap();
        assert_eq!(found[0].text, "G1   X1");
        assert_eq!(&found[0].text[found[0].range.clone()], "X1");
    }
}
