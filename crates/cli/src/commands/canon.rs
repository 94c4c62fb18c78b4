//! `lostmotion canon`.

use super::{DONE, interpreter};
use crate::args::front::Canon;
use crate::diagnostics::Findings;
use crate::failure::Failure;
use crate::voice::Voice;
use crate::{input, output};
use lostmotion::gcode::InterpreterConfig;
use std::io::Write;

/// Prints canonical operations with the settings of LinuxCNC's stand-alone interpreter, whose
/// machine units are inches. If the program has errors, the operations of the blocks without are
/// printed, and the failure carries all that was found.
pub(crate) fn run(args: &Canon, voice: Voice) -> Result<u8, Failure> {
    let source = input::program(&args.part)?;
    let tool_table = args
        .tool_table
        .as_deref()
        .map(interpreter::tools)
        .transpose()?;
    let config = args.reading.config(InterpreterConfig {
        tool_table,
        ..InterpreterConfig::like_rs274()
    })?;
    let mut program =
        interpreter::open(&source, config)?.with_loader(args.reading.loader(&args.part)?);
    let mut out = output::stdout();
    for sourced in program.by_ref() {
        if !output::go_on(writeln!(out, "{}", sourced.op))? {
            return Ok(DONE);
        }
    }
    output::go_on(out.flush())?;
    let findings = Findings::of(&source, program.diagnostics());
    if findings.counts.errors > 0 {
        return Err(findings.failure(voice));
    }
    findings.remark(voice)?;
    Ok(DONE)
}
