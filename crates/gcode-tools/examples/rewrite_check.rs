//! Checks that programs survive formatting and writing: `rewrite_check FILE...`.
//!
//! Formatted, a program gives the same canonical operations, and formatting again changes nothing.
//! Written anew from its resolved operations, it gives the same resolved operations.

use lostmotion_gcode::{CanonicalOp, InterpreterConfig, Program};
use lostmotion_gcode_tools::format::{FormatOptions, format};
use lostmotion_gcode_tools::writer::{Frame, Resolver, write_program};
use std::error::Error;
use std::process::ExitCode;

fn operations(text: &[u8], config: &InterpreterConfig) -> (Vec<CanonicalOp>, u64) {
    let mut program = Program::new(text, config.clone());
    let ops = program.by_ref().map(|sourced| sourced.op).collect();
    (ops, program.diagnostics().errors())
}

fn resolved(
    text: &[u8],
    config: &InterpreterConfig,
    comments: usize,
) -> Result<Vec<CanonicalOp>, Box<dyn Error>> {
    let mut resolver = Resolver::new(config, Frame::of(config, 1)?);
    let mut all = Vec::new();
    for sourced in Program::new(text, config.clone()) {
        all.extend(
            resolver
                .push(&sourced)?
                .into_iter()
                .map(|sourced| sourced.op),
        );
    }
    all.extend(resolver.finish());
    // The head of a written program begins with a comment.
    Ok(all.into_iter().skip(comments).collect())
}

fn check(name: &str) -> Result<&'static str, Box<dyn Error>> {
    let text = std::fs::read(name)?;
    let config = InterpreterConfig::like_rs274();
    let (ops, errors) = operations(&text, &config);
    let (mut once, mut twice) = (Vec::new(), Vec::new());
    format(&text[..], &FormatOptions::default(), &mut once)?;
    format(&once[..], &FormatOptions::default(), &mut twice)?;
    if once != twice {
        return Err("formatting twice is not formatting once".into());
    }
    if operations(&once, &config) != (ops.clone(), errors) {
        return Err("the formatted program does something else".into());
    }
    if errors > 0 {
        return Ok("refused");
    }
    let mut written = Vec::new();
    write_program(
        &mut Program::new(&text[..], config.clone()),
        &config,
        1,
        &mut written,
    )?;
    let (_, errors) = operations(&written, &config);
    let (expected, got) = (
        resolved(&text, &config, 0)?,
        resolved(&written, &config, 1)?,
    );
    if errors > 0 || expected != got {
        let at = expected
            .iter()
            .zip(&got)
            .position(|(a, b)| a != b)
            .unwrap_or(expected.len().min(got.len()));
        return Err(format!(
            "the written program does something else at {at}: {:?}, {:?}",
            expected.get(at),
            got.get(at)
        )
        .into());
    }
    Ok("same")
}

fn main() -> ExitCode {
    let (mut same, mut refused, mut failed) = (0, 0, 0);
    for name in std::env::args().skip(1) {
        match check(&name) {
            Ok("same") => same += 1,
            Ok(_) => refused += 1,
            Err(error) => {
                failed += 1;
                println!("{name}: {error}");
            }
        }
    }
    println!(
        "{same} the same formatted and written, {refused} refused and the same formatted, {failed} failed"
    );
    if failed == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
