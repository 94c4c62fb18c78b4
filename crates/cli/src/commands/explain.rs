//! `lostmotion explain`.

use super::{DONE, interpreter, show, to_json};
use crate::args::Format;
use crate::args::front::Explain;
use crate::diagnostics::Findings;
use crate::failure::Failure;
use crate::input;
use crate::voice::Voice;
use lostmotion::gcode_tools::explain::explain;
use std::path::Path;

/// Explains a line. What is wrong with the program is only counted here.
pub(crate) fn run(args: &Explain, voice: Voice) -> Result<u8, Failure> {
    let (part, line) = place(&args.place)?;
    let source = input::program(Path::new(part))?;
    let (config, _) = interpreter::config(&args.setup)?;
    let mut program = interpreter::open(&source, config)?
        .with_loader(args.setup.reading.loader(Path::new(part))?);
    let Some(explanation) = explain(&mut program, line) else {
        return Err(Failure::message(format!("{part} has no line {line}")));
    };
    let json = if args.format == Format::Json {
        to_json(&explanation)?
    } else {
        String::new()
    };
    show(args.format, &json, &explanation.to_string())?;
    Findings::of(&source, program.diagnostics()).remark(voice)?;
    Ok(DONE)
}

fn place(text: &str) -> Result<(&str, u32), Failure> {
    let parts = text
        .rsplit_once(':')
        .and_then(|(part, line)| Some((part, line.parse().ok().filter(|line| *line > 0)?)));
    parts.ok_or_else(|| {
        Failure::with_hint(
            format!("\"{text}\" is not of the form PART:LINE"),
            "for example: part.ngc:12",
        )
    })
}
