//! Prints the canonical operations of a part program: `canon [--tool-table FILE] PART`.

use lostmotion_gcode::{InterpreterConfig, ToolTable, canon};
use std::error::Error;
use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::process::ExitCode;

fn run() -> Result<bool, Box<dyn Error>> {
    let mut config = InterpreterConfig::like_rs274();
    let mut part = None;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if argument == "--tool-table" {
            let table = std::fs::read_to_string(arguments.next().ok_or("a tool table has to be named")?)?;
            config.tool_table = Some(ToolTable::parse(&table)?);
        } else {
            part = Some(argument);
        }
    }
    let source = BufReader::new(File::open(part.ok_or("usage: canon [--tool-table FILE] PART")?)?);
    let mut out = BufWriter::new(std::io::stdout().lock());
    let diagnostics = canon::write(source, config, &mut out)?;
    out.flush()?;
    for diagnostic in diagnostics.kept() {
        eprintln!("{diagnostic}");
    }
    Ok(diagnostics.errors() == 0)
}

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(2),
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}
