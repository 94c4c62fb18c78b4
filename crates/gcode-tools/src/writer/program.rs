//! A whole program, resolved and written.

use super::{Frame, Resolver, Writer, WriterError};
use lostmotion_gcode::config::InterpreterConfig;
use lostmotion_gcode::ops::SourcedOp;
use lostmotion_gcode::program::Program;
use std::io::{BufRead, Write};

/// What has been written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// Blocks, with those of the head.
    pub blocks: u64,
    /// Resolved operations.
    pub operations: u64,
}

/// Text that is held before it goes out, bytes.
const BUFFER: usize = 1 << 16;

/// Runs a program and writes what it does as a program without parameters, loops, calls, cycles and
/// offsets. Its coordinates are those of a work coordinate system, 1 for G54 to 9 for G59.3, as it
/// is before the program. `config` has to be that of the program. Memory does not grow with the
/// program's length.
///
/// # Errors
/// The program has errors, or something in it has no block of its own: see [`WriterError`].
pub fn write_program<R: BufRead>(
    program: &mut Program<R>,
    config: &InterpreterConfig,
    system: u8,
    out: &mut impl Write,
) -> Result<Written, WriterError> {
    let frame = Frame::of(config, system)?;
    let result = write_in(program, config, frame, out);
    if result.is_err() {
        // What is wrong with the program itself is what counts, all of it.
        for _ in program.by_ref() {}
    }
    match program.diagnostics().errors() {
        0 => result,
        errors => Err(WriterError::Program { errors }),
    }
}

fn write_in<R: BufRead>(
    program: &mut Program<R>,
    config: &InterpreterConfig,
    frame: Frame,
    out: &mut impl Write,
) -> Result<Written, WriterError> {
    let mut resolver = Resolver::new(config, frame);
    let mut text = String::new();
    let mut writer = Writer::new(config, frame, &mut text)?;
    let mut written = Written::default();
    let mut last = SourcedOp {
        op: lostmotion_gcode::CanonicalOp::ProgramEnd,
        block: lostmotion_base::span::BlockRef::default(),
    };
    for sourced in program.by_ref() {
        for op in resolver
            .push(&sourced.op)
            .map_err(|error| error.at(sourced.block))?
        {
            written.operations += 1;
            writer.push(
                SourcedOp {
                    op,
                    block: sourced.block,
                },
                &mut text,
            )?;
        }
        last = sourced;
        if text.len() > BUFFER {
            flush(&mut text, &mut written, out)?;
        }
    }
    if let Some(op) = resolver.finish() {
        writer.push(
            SourcedOp {
                op,
                block: last.block,
            },
            &mut text,
        )?;
    }
    writer.finish(&mut text)?;
    flush(&mut text, &mut written, out)?;
    out.flush()?;
    Ok(written)
}

fn flush(
    text: &mut String,
    written: &mut Written,
    out: &mut impl Write,
) -> Result<(), WriterError> {
    written.blocks += text.bytes().filter(|byte| *byte == b'\n').count() as u64;
    out.write_all(text.as_bytes())?;
    text.clear();
    Ok(())
}
