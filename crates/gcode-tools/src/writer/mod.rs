//! From canonical operations back to a program: straight moves and arcs with coordinates, nothing
//! that is computed.
//!
//! [`Resolver`] brings operations into one frame: offsets, rotations and everything that sets what
//! is set already are gone. [`Writer`] writes resolved operations as blocks. It interprets what it
//! writes and holds the result against what was to be written, bit for bit, so that reading the new
//! program gives the same resolved operations, or writing fails.

mod error;
mod line;
mod motion;
mod program;
mod resolve;
mod settled;
mod word;

pub use error::WriterError;
pub use program::{Written, write_program};
pub use resolve::{Frame, Resolver};

use line::Line;
use lostmotion_gcode::config::InterpreterConfig;
use lostmotion_gcode::feeder::Feeder;
use lostmotion_gcode::ops::{CanonicalOp, SourcedOp};
use std::collections::VecDeque;

/// Operations that are looked at together.
const WINDOW: usize = 16;

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
        while self.window.len() > WINDOW {
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
        let ops: Vec<&CanonicalOp> = self.window.iter().map(|sourced| &sourced.op).collect();
        let Some(Line { text, ops }) =
            line::line(&ops, self.reader.interpreter().state(), self.sync)
        else {
            return Err(WriterError::not_writable(self.window.front(), None, ""));
        };
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
        self.compare(&text)
    }

    /// Appends a block and reads it back.
    fn put(&mut self, line: &str, out: &mut String) -> Result<(), WriterError> {
        let fed = self.reader.feed(line.as_bytes());
        for sourced in &fed.ops {
            self.got.extend(self.resolver.push(&sourced.op)?);
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
const SAME_RATE: f64 = 1e-9;

/// Equality, but for what follows from lengths in the frame: rates in inverse time, and the place
/// where a probing move is taken to stop.
fn same(one: &CanonicalOp, other: &CanonicalOp) -> bool {
    match (one, other) {
        (CanonicalOp::StraightProbe(one), CanonicalOp::StraightProbe(other)) => {
            (one.end, one.away, one.must) == (other.end, other.away, other.must)
        }
        (
            CanonicalOp::SetFeedRate {
                rate: one,
                inverse_time: Some(per_minute),
            },
            CanonicalOp::SetFeedRate { rate, inverse_time },
        ) => *inverse_time == Some(*per_minute) && (one - rate).abs() <= SAME_RATE * one.abs(),
        _ => one == other,
    }
}
