//! One line at a time, for programs that have the lines themselves: senders, editors, consoles.

use crate::config::InterpreterConfig;
use crate::diagnostics::Diagnostic;
use crate::dialect::Leniency;
use crate::interpreter::{Interpreter, Place, Step};
use crate::limits::Limits;
use crate::ops::SourcedOp;
use crate::problem::Problem;
use crate::provenance::SubroutineLoader;
use lostmotion_base::span::Span;
use std::sync::Arc;

/// The result of one line.
#[derive(Clone, Debug, PartialEq)]
pub struct Fed {
    /// Operations to carry out now. A line that closes a loop yields those of all its rounds.
    pub ops: Vec<SourcedOp>,
    /// Findings about the line, and about the blocks that it makes run.
    pub diagnostics: Vec<Diagnostic>,
    /// Nothing has run yet: the line belongs to a subroutine's definition, to a branch that
    /// is not taken, or more lines are needed before it can run.
    pub waits: bool,
    /// The program is over; further lines have no effect.
    pub ended: bool,
}

/// An interpreter that takes one line at a time.
///
/// ```
/// use lostmotion_gcode::{Feeder, InterpreterConfig};
///
/// let mut feeder = Feeder::new(InterpreterConfig::default());
/// let fed = feeder.feed(b"G21 G1 X10 F200");
/// assert_eq!(fed.ops.last().unwrap().op.to_string(), "STRAIGHT_FEED(10.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000)");
/// let fed = feeder.feed(b"G2 X20 I4");
/// assert_eq!(fed.diagnostics[0].code(), "arc-radii");
/// assert_eq!(feeder.interpreter().state().current[0], 20.0);
/// ```
#[derive(Debug)]
pub struct Feeder {
    interpreter: Interpreter,
    limits: Limits,
    line: u32,
    offset: u64,
}

impl Feeder {
    /// A feeder before its first line.
    pub fn new(config: InterpreterConfig) -> Feeder {
        Feeder {
            limits: config.limits.clone(),
            interpreter: Interpreter::new(config),
            line: 0,
            offset: 0,
        }
    }

    /// Loads subroutines that the lines do not define.
    #[must_use]
    pub fn with_loader(mut self, loader: Arc<dyn SubroutineLoader>) -> Feeder {
        self.interpreter = self.interpreter.with_loader(loader);
        self
    }

    /// Takes the next line, with or without its terminator. Lines are counted from 1, offsets with
    /// the terminator.
    pub fn feed(&mut self, line: &[u8]) -> Fed {
        let start = self.offset;
        // Places count as if the lines stood in one file.
        self.line = self.line.saturating_add(1);
        self.offset += line.len() as u64;
        let content = line.strip_suffix(b"\n").unwrap_or(line);
        let span = Span {
            file: 0,
            line: self.line,
            column: 1,
            start,
            len: 0,
        };
        let content = content.strip_suffix(b"\r").unwrap_or(content);
        if line.ends_with(b"\r\n") {
            self.interpreter.habit_at(Leniency::CrLf, span);
        }
        // A line that is too long is reported and skipped: the lines after it are still read.
        if content.len() > self.limits.line_bytes {
            let problem = Problem::LineTooLong {
                bytes: content.len(),
                limit: self.limits.line_bytes,
            };
            self.interpreter.report_at(problem, span);
        } else if !self.interpreter.state().ended {
            self.interpreter.push_line(
                content,
                Place {
                    file: 0,
                    line: self.line,
                    start,
                },
            );
        }
        self.run()
    }

    /// Ends the program: reports structures that are still open and emits the moves that cutter
    /// compensation holds.
    pub fn finish(&mut self) -> Fed {
        self.interpreter.end_of_source();
        self.run()
    }

    /// The interpreter, for its state, parameters and call stacks.
    pub fn interpreter(&self) -> &Interpreter {
        &self.interpreter
    }

    fn run(&mut self) -> Fed {
        let mut ops = Vec::new();
        while self.interpreter.step(&mut ops) == Step::Ran {}
        Fed {
            ops,
            diagnostics: self.interpreter.take_diagnostics(),
            waits: self.interpreter.passes_over(),
            ended: self.interpreter.state().ended,
        }
    }
}
