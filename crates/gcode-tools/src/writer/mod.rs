//! From canonical operations back to a program: straight moves and arcs with coordinates, nothing
//! that is computed.
//!
//! [`Resolver`] brings operations into one frame: offsets, rotations and everything that sets what
//! is set already are gone. [`Writer`] writes resolved operations as blocks. It interprets what it
//! writes and holds the result against what was to be written, bit for bit, so that reading the new
//! program gives the same resolved operations, or writing fails.

mod line;
mod resolve;

use line::Line;
use lostmotion_base::span::BlockRef;
use lostmotion_gcode::Feeder;
use lostmotion_gcode::config::InterpreterConfig;
use lostmotion_gcode::ops::{CanonicalOp, SourcedOp};
use lostmotion_gcode::problem::Problem;
use lostmotion_gcode::program::Program;
pub use resolve::{Frame, Resolver};
use std::collections::VecDeque;
use std::io::{BufRead, Write};

/// Operations that are looked at together.
const WINDOW_OPERATIONS: usize = 16;

/// Writes resolved operations as blocks.
#[derive(Debug)]
pub struct Writer {
    /// Reads what is written.
    reader: Feeder,
    resolver: Resolver,
    window: VecDeque<SourcedOp>,
    /// What has been written and not been read back yet.
    expected: VecDeque<SourcedOp>,
    /// What has been read back and was not expected yet.
    got: VecDeque<CanonicalOp>,
    sync: Option<f64>,
}

impl Writer {
    /// A writer for a frame, and the head of the program: it sets every mode that the blocks rely
    /// on.
    ///
    /// # Errors
    /// The head cannot be read back: see [`WriterError`].
    pub fn new(
        config: &InterpreterConfig,
        frame: Frame,
        out: &mut String,
    ) -> Result<Writer, WriterError> {
        // The reader must not refuse what the original interpreter has resolved: no tool table, no
        // block delete.
        let config = InterpreterConfig {
            tool_table: None,
            block_delete: false,
            ..config.clone()
        };
        let resolver = Resolver::new(&config, frame);
        let reader = Feeder::new(config);
        let (window, expected, got) = (VecDeque::new(), VecDeque::new(), VecDeque::new());
        let mut writer = Writer {
            reader,
            resolver,
            window,
            expected,
            got,
            sync: None,
        };
        for line in line::head(&frame) {
            writer.put(&line, out)?;
        }
        // The head says what is so anyway.
        writer.got.clear();
        Ok(writer)
    }

    /// Takes the next resolved operation; blocks that are certain are appended to `out`.
    ///
    /// # Errors
    /// The operations have no blocks that mean the same.
    pub fn push(&mut self, op: SourcedOp, out: &mut String) -> Result<(), WriterError> {
        self.window.push_back(op);
        // One block may stand for several operations, so that a window is looked at.
        while self.window.len() > WINDOW_OPERATIONS {
            self.next(out)?;
        }
        Ok(())
    }

    /// Writes what is left.
    ///
    /// # Errors
    /// As [`Writer::push`].
    pub fn finish(mut self, out: &mut String) -> Result<(), WriterError> {
        while !self.window.is_empty() {
            self.next(out)?;
        }
        // The reader's side holds one operation back, too.
        self.got.extend(self.resolver.finish());
        self.compare("the end of the program")?;
        match (self.expected.pop_front(), self.got.pop_front()) {
            (None, None) => Ok(()),
            (expected, got) => Err(WriterError::not_writable(
                expected.as_ref(),
                got.as_ref(),
                "the end of the program",
            )),
        }
    }

    /// Writes the blocks of the next operations.
    fn next(&mut self, out: &mut String) -> Result<(), WriterError> {
        let ops: Vec<&SourcedOp> = self.window.iter().collect();
        let Some(Line { text, ops }) =
            line::line(&ops, self.reader.interpreter().state(), self.sync)
        else {
            return Err(WriterError::not_writable(self.window.front(), None, ""));
        };
        // What has been written is expected to come back from the reader.
        for sourced in self.window.drain(..ops.min(self.window.len())) {
            match sourced.op {
                CanonicalOp::StartSpeedFeedSync(pitch) => self.sync = Some(pitch),
                CanonicalOp::StopSpeedFeedSync => self.sync = None,
                _ => {}
            }
            self.expected.push_back(sourced);
        }
        for line in text.lines() {
            self.put(line, out)?;
        }
        // A move that goes nowhere is a distance; all others are places.
        if !self.reader.interpreter().state().absolute {
            self.put("G90", out)?;
        }
        self.compare(&text)
    }

    /// Appends a block and reads it back.
    fn put(&mut self, line: &str, out: &mut String) -> Result<(), WriterError> {
        // The written block is read by an interpreter of its own and resolved like the original.
        let fed = self.reader.feed(line.as_bytes());
        for sourced in &fed.ops {
            let ops = self.resolver.push(sourced)?;
            self.got.extend(ops.into_iter().map(|sourced| sourced.op));
        }
        if let Some(diagnostic) = fed
            .diagnostics
            .iter()
            .find(|diagnostic| diagnostic.severity() == lostmotion_gcode::Severity::Error)
        {
            let block = self
                .expected
                .front()
                .map(|sourced| sourced.block)
                .unwrap_or_default();
            return Err(WriterError::Refused {
                line: line.to_owned(),
                problem: Box::new(diagnostic.problem.clone()),
                block,
            });
        }
        out.push_str(line);
        out.push('\n');
        Ok(())
    }

    fn compare(&mut self, text: &str) -> Result<(), WriterError> {
        while let (Some(expected), Some(got)) = (self.expected.front(), self.got.front()) {
            if !same(&expected.op, got) {
                return Err(WriterError::not_writable(Some(expected), Some(got), text));
            }
            self.expected.pop_front();
            self.got.pop_front();
        }
        Ok(())
    }
}

/// Rates that follow from inverse time may differ by this much: they are computed from lengths.
const SAME_RATE_RELATIVE: f64 = 1e-9;

/// Equality, except for values that are computed from lengths in the frame: rates in inverse time, and
/// the place where a probing move stops.
fn same(one: &CanonicalOp, other: &CanonicalOp) -> bool {
    match (one, other) {
        // The stop is computed from the length of the move, which rounds otherwise in another
        // frame.
        (CanonicalOp::StraightProbe(one), CanonicalOp::StraightProbe(other)) => {
            (one.end, one.away, one.must) == (other.end, other.away, other.must)
        }
        (
            CanonicalOp::SetFeedRate {
                rate: one,
                inverse_time: Some(per_minute),
            },
            CanonicalOp::SetFeedRate { rate, inverse_time },
        ) => {
            *inverse_time == Some(*per_minute)
                && (one - rate).abs() <= SAME_RATE_RELATIVE * one.abs()
        }
        _ => one == other,
    }
}

/// What has been written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// Blocks, with those of the head.
    pub blocks: u64,
    /// Resolved operations.
    pub operations: u64,
}

/// Text that is held before it goes out, bytes.
const BUFFER_BYTES: usize = 1 << 16;

/// Runs a program and writes what it does as a program without parameters, loops, calls, cycles and
/// offsets. Its coordinates are those of a work coordinate system, 1 for G54 to 9 for G59.3, as it
/// is before the program. `config` has to be that of the program. Memory does not grow with the
/// program's length.
///
/// ```
/// use lostmotion_gcode::{InterpreterConfig, Program};
/// use lostmotion_gcode_tools::writer::write_program;
///
/// let (text, config) = (b"G21 #1=2 F600\nG1 X[#1*5]\nM2\n", InterpreterConfig::default());
/// let mut out = Vec::new();
/// write_program(&mut Program::new(&text[..], config.clone()), &config, 1, &mut out)?;
/// let plain = String::from_utf8_lossy(&out);
/// assert!(plain.contains("X10") && !plain.contains('#'));
/// # Ok::<(), lostmotion_gcode_tools::writer::WriterError>(())
/// ```
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
    // The block that the held-back operation at the end is attributed to.
    let mut last = SourcedOp {
        op: lostmotion_gcode::CanonicalOp::ProgramEnd,
        block: lostmotion_base::span::BlockRef::default(),
        named: 0,
    };
    for sourced in program.by_ref() {
        for op in resolver
            .push(&sourced)
            .map_err(|error| error.at(sourced.block))?
        {
            written.operations += 1;
            writer.push(op, &mut text)?;
        }
        last = sourced;
        // Written out now and then: memory does not grow with the program.
        if text.len() > BUFFER_BYTES {
            flush(&mut text, &mut written, out)?;
        }
    }
    if let Some(op) = resolver.finish() {
        writer.push(
            SourcedOp {
                op,
                block: last.block,
                named: 0,
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

/// Why operations cannot be written as blocks.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriterError {
    /// No block means the same as an operation.
    #[error("{}: {op} cannot be written as a block of its own{got}", block.span)]
    NotWritable {
        /// The operation.
        op: String,
        /// What the nearest block would have meant; may be empty.
        got: String,
        /// The block that the operation came from.
        block: BlockRef,
    },
    /// Coordinates are turned, or the plane tilted: plain lines and arcs have neither.
    #[error(
        "{}: coordinates are turned or the plane is tilted from here on (G68, G68.2), which plain lines and arcs cannot say",
        block.span
    )]
    Turned {
        /// The block that turns them.
        block: BlockRef,
    },
    /// A block that was written is refused when it is read.
    #[error("{}: the block `{line}` that it would become is refused: {problem}", block.span)]
    Refused {
        /// The block.
        line: String,
        /// Why.
        problem: Box<Problem>,
        /// The block that it came from.
        block: BlockRef,
    },
    /// An arc outside the XY plane while the coordinates are rotated.
    #[error("{}: an arc in the {plane} plane cannot be rotated by {degrees} degrees about Z", block.span)]
    RotatedArc {
        /// Its plane.
        plane: &'static str,
        /// The rotation.
        degrees: f64,
        /// The block that asked for it.
        block: BlockRef,
    },
    /// The frame asked for is rotated.
    #[error(
        "work coordinate system {system} is rotated by {degrees} degrees; take one that is not"
    )]
    RotatedFrame {
        /// The system, 1 for G54.
        system: u8,
        /// Its rotation.
        degrees: f64,
    },
    /// There is no such work coordinate system.
    #[error("work coordinate system {system} does not exist; they go from 1 (G54) to 9 (G59.3)")]
    NoSuchSystem {
        /// The number asked for.
        system: u8,
    },
    /// The program has errors.
    #[error("the program has {errors} errors")]
    Program {
        /// How many.
        errors: u64,
    },
    /// The output cannot be written.
    #[error("cannot write: {0}")]
    Io(#[from] std::io::Error),
}

impl WriterError {
    /// The same at a block.
    pub(super) fn at(self, place: BlockRef) -> WriterError {
        match self {
            WriterError::RotatedArc { plane, degrees, .. } => WriterError::RotatedArc {
                plane,
                degrees,
                block: place,
            },
            other => other,
        }
    }

    pub(super) fn not_writable(
        expected: Option<&SourcedOp>,
        got: Option<&CanonicalOp>,
        text: &str,
    ) -> WriterError {
        if let Some(sourced) = expected
            && matches!(sourced.op, CanonicalOp::SetTilt(Some(_)))
        {
            return WriterError::Turned {
                block: sourced.block,
            };
        }
        WriterError::NotWritable {
            op: expected.map_or("nothing".to_owned(), |sourced| sourced.op.to_string()),
            got: got.map_or(String::new(), |got| {
                format!(": `{}` is {got}", text.trim_end())
            }),
            block: expected.map(|sourced| sourced.block).unwrap_or_default(),
        }
    }
}
