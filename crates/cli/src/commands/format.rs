//! `lostmotion format`.

use super::DONE;
use crate::args::front::{FormatPart, LetterCase};
use crate::failure::Failure;
use crate::voice::Voice;
use crate::{input, output};
use lostmotion::gcode_tools::format::{
    Case, FormatOptions, FormatSummary, LineNumbers, format, refers_to_line_numbers,
};
use lostmotion::report::atomic::AtomicFile;
use lostmotion::sim::Program;
use std::io::{self, Write};

/// The program is not in the style.
const WOULD_CHANGE: u8 = 1;

/// Formats to stdout or in place, or checks.
pub(crate) fn run(args: &FormatPart, voice: Voice) -> Result<u8, Failure> {
    let source = input::program(&args.part)?;
    let failed =
        |error: io::Error| Failure::message(format!("cannot format {}: {error}", source.name()));
    let options = options(args, &source)?;
    let reader = source.open().map_err(failed)?;
    let summary = if args.check {
        let summary = format(reader, &options, &mut io::sink()).map_err(failed)?;
        output::print(&changes(&source, &summary))?;
        return Ok(if summary.changed > 0 {
            WOULD_CHANGE
        } else {
            DONE
        });
    } else if args.write {
        let mut file = AtomicFile::create(&args.part)?;
        let summary = format(reader, &options, &mut file).map_err(failed)?;
        if summary.changed > 0 {
            file.commit()?;
        }
        summary
    } else {
        let mut out = output::stdout();
        match format(reader, &options, &mut out).and_then(|summary| out.flush().map(|()| summary)) {
            Ok(summary) => summary,
            Err(error) => {
                output::go_on(Err(error))?;
                return Ok(DONE);
            }
        }
    };
    if args.write && !voice.quiet {
        output::print(&format!(
            "{}: {} of {} lines changed\n",
            source.name(),
            summary.changed,
            summary.lines
        ))?;
    }
    Ok(DONE)
}

fn options(args: &FormatPart, source: &Program) -> Result<FormatOptions, Failure> {
    let case = match args.case {
        LetterCase::Upper => Case::Upper,
        LetterCase::Lower => Case::Lower,
        LetterCase::Keep => Case::Keep,
    };
    let line_numbers = match args.line_numbers.as_str() {
        "keep" => LineNumbers::Keep,
        "remove" => LineNumbers::Remove,
        step => match step.parse() {
            Ok(step @ 1..=10_000) => LineNumbers::Renumber { step },
            _ => {
                return Err(Failure::message(format!(
                    "--line-numbers {step} is neither keep nor remove nor a step from 1 to 10000"
                )));
            }
        },
    };
    if line_numbers != LineNumbers::Keep {
        let failed =
            |error: io::Error| Failure::message(format!("cannot read {}: {error}", source.name()));
        if let Some(line) =
            refers_to_line_numbers(source.open().map_err(failed)?).map_err(failed)?
        {
            let text = format!(
                "{}, line {line}: the program refers to its line numbers",
                source.name()
            );
            return Err(Failure::with_hint(text, "leave --line-numbers at keep"));
        }
    }
    Ok(FormatOptions {
        case,
        indent: args.indent.min(16),
        line_numbers,
        ..FormatOptions::default()
    })
}

/// What would be changed, as lines that go and lines that come.
fn changes(source: &Program, summary: &FormatSummary) -> String {
    let mut text = String::new();
    for change in &summary.changes {
        let [before, after] = [&change.before, &change.after]
            .map(|bytes| String::from_utf8_lossy(bytes).into_owned());
        text.push_str(&format!(
            "{}:{}\n- {before}\n+ {after}\n",
            source.name(),
            change.line
        ));
    }
    let more = summary.changed - summary.changes.len() as u64;
    if more > 0 {
        text.push_str(&format!("and {more} more\n"));
    }
    if summary.changed > 0 {
        text.push_str(&format!(
            "{}: {} of {} lines would change\n",
            source.name(),
            summary.changed,
            summary.lines
        ));
    }
    text
}
