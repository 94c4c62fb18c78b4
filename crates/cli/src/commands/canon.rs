//! `lostmotion canon`.

use super::DONE;
use crate::args::Canon;
use crate::failure::Failure;
use crate::{diagnostics, input, output};
use lostmotion::gcode::{InterpreterConfig, Program, ToolTable};
use std::io::Write;

/// Prints canonical operations with the settings of LinuxCNC's stand-alone interpreter, whose machine units are inches. If the
/// program has errors, the operations of the blocks without are printed, and the failure carries all that was found.
pub(crate) fn run(args: &Canon, quiet: bool) -> Result<u8, Failure> {
    let source = input::program(&args.part)?;
    let mut config = args.reading.config(InterpreterConfig::like_rs274())?;
    if let Some(path) = &args.tool_table {
        let text = input::text(path, "tool table")?;
        let table = ToolTable::parse(&text).map_err(|problem| Failure::message(format!("{}: {problem}", path.display())))?;
        config.tool_table = Some(table);
    }
    let reader = source.open().map_err(|error| Failure::message(format!("cannot read {}: {error}", source.name())))?;
    let mut program = Program::new(reader, config).with_loader(args.reading.loader(&args.part)?);
    let mut out = output::stdout();
    for sourced in program.by_ref() {
        if !output::go_on(writeln!(out, "{}", sourced.op))? {
            return Ok(DONE);
        }
    }
    output::go_on(out.flush())?;
    let found = program.diagnostics();
    if found.errors() > 0 {
        return Err(Failure::Rendered(diagnostics::render(&source, found)));
    }
    if found.warnings() > 0 && !quiet {
        output::remark(&diagnostics::render(&source, found));
    }
    Ok(DONE)
}
