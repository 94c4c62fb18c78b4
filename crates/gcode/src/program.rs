//! Programs: an iterator of canonical operations over a reader, a run that shows every block, or a
//! feeder for those that have the lines themselves (senders, editors, consoles).

use crate::config::InterpreterConfig;
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::dialect::Leniency;
use crate::interpreter::{Interpreter, Step};
use crate::limits::Limits;
use crate::ops::SourcedOp;
use crate::problem::Problem;
use crate::provenance::SubroutineLoader;
use crate::source::{LineEnd, LineKind, Lines, Place};
use crate::state::State;
use crate::syntax::Block;
use lostmotion_base::span::{BlockRef, Span};
use std::io::BufRead;
use std::sync::Arc;

/// Canonical operations of a program, read as they are asked for, in memory that does not grow with
/// its length.
///
/// The iterator goes on after errors; whether the program is accepted is known at its end, from
/// [`Program::diagnostics`].
#[derive(Debug)]
pub struct Program<R> {
    lines: Lines<R>,
    interpreter: Interpreter,
    /// Operations of the last step, in reverse order.
    pending: Vec<SourcedOp>,
    over: bool,
    /// Where the last line begins.
    last: Span,
}

impl<R: BufRead> Program<R> {
    /// A program from a reader; `&[u8]` is one.
    pub fn new(source: R, config: InterpreterConfig) -> Program<R> {
        let lines = Lines::new(source, config.limits.line_bytes);
        let interpreter = Interpreter::new(config);
        let mut pending = Vec::new();
        interpreter.begin(&mut pending);
        pending.reverse();
        Program {
            lines,
            interpreter,
            pending,
            over: false,
            last: Span::default(),
        }
    }

    /// Loads subroutines that the program does not define.
    #[must_use]
    pub fn with_loader(mut self, loader: Arc<dyn SubroutineLoader>) -> Program<R> {
        self.interpreter = self.interpreter.with_loader(loader);
        self
    }

    /// What has been found so far; complete when the iterator has ended.
    pub fn diagnostics(&self) -> &Diagnostics {
        self.interpreter.diagnostics()
    }

    /// The interpreter, for its state and parameters.
    pub fn interpreter(&self) -> &Interpreter {
        &self.interpreter
    }

    /// Tells where the controlled point is after a move that is not in the program: where it is in program coordinates and units.
    pub fn moved_to(&mut self, place: crate::ops::Position) {
        self.interpreter.moved_to(place);
    }

    /// Takes the operations that are not fetched yet; before the first block, those that tell the
    /// initial state.
    pub fn take_pending(&mut self) -> Vec<SourcedOp> {
        let mut ops = std::mem::take(&mut self.pending);
        ops.reverse();
        ops
    }

    /// Runs the next block, appending its operations to `out`; false at the end of the program. Not
    /// to be mixed with the iterator while that has operations pending.
    pub fn run_block(&mut self, out: &mut Vec<SourcedOp>) -> bool {
        while !self.over {
            match self.interpreter.step(out) {
                Step::Ran => return true,
                Step::NeedsLine => self.read(),
                Step::Ended => {
                    self.over = true;
                    return true;
                }
            }
        }
        false
    }

    /// The interpreter's state without what may be large.
    pub(crate) fn light_state(&mut self) -> State {
        self.interpreter.light_state()
    }

    /// A line that the interpreter has not been given, because the program ended before it.
    pub fn next_line(&mut self) -> Option<(&[u8], Span)> {
        let (_, line, start) = self.lines.next().ok()??;
        let text = self.lines.line();
        Some((
            text,
            Span {
                file: 0,
                line,
                column: 1,
                start,
                len: text.len() as u32,
            },
        ))
    }

    /// Runs to the end and gives all findings.
    pub fn finish(mut self) -> Diagnostics {
        for _ in self.by_ref() {}
        self.interpreter.into_diagnostics()
    }

    /// Reads one line into the interpreter.
    fn read(&mut self) {
        let next = self.lines.next();
        // How the line before ended is known once the next one is asked for.
        if let Some(end) = self.lines.end {
            self.interpreter.habit_at(
                if end == LineEnd::Cr {
                    Leniency::BareReturns
                } else {
                    Leniency::CrLf
                },
                self.last,
            );
        }
        match next {
            Ok(Some((kind, number, start))) => self.take_line(kind, number, start),
            Ok(None) => self.interpreter.end_of_source(),
            Err(error) => {
                self.interpreter.report_at(
                    Problem::Unreadable {
                        message: error.to_string(),
                    },
                    Span::default(),
                );
                self.over = true;
            }
        }
    }

    fn take_line(&mut self, kind: LineKind, line: u32, start: u64) {
        let limits = self.interpreter.limits();
        let span = Span {
            file: 0,
            line,
            column: 1,
            start,
            len: 0,
        };
        let limit = limits.source_bytes;
        let longest = limits.line_bytes;
        // The mark is reported at its own three bytes.
        if line == 1 && self.lines.marked {
            self.interpreter.report_mark(Span { len: 3, ..span });
        }
        self.last = span;
        // What lies beyond the limit is not read: the program ends here.
        if start + self.lines.line().len() as u64 > limit {
            self.interpreter
                .report_at(Problem::SourceTooLong { limit }, span);
            self.interpreter.end_of_source();
            return;
        }
        let place = Place {
            file: 0,
            line,
            start,
        };
        match kind {
            LineKind::Whole => self.interpreter.push_line(self.lines.line(), place),
            LineKind::TooLong(bytes) => self.interpreter.report_at(
                Problem::LineTooLong {
                    bytes,
                    limit: longest,
                },
                span,
            ),
        }
    }
}

impl<R: BufRead> Iterator for Program<R> {
    type Item = SourcedOp;

    fn next(&mut self) -> Option<SourcedOp> {
        loop {
            if let Some(op) = self.pending.pop() {
                return Some(op);
            }
            let mut ops = std::mem::take(&mut self.pending);
            let ran = self.run_block(&mut ops);
            self.pending = ops;
            if !ran {
                return None;
            }
            self.pending.reverse();
        }
    }
}

/// A block that has run.
#[derive(Debug)]
pub struct Event<'a> {
    /// Where it stands, and the call it ran in.
    pub place: BlockRef,
    /// The modes and the position before it, without what cutter compensation and curves hold.
    pub before: &'a State,
    /// Cutter compensation was in force before it.
    pub compensated: bool,
    /// The same after it.
    pub after: &'a State,
    /// Cutter compensation is in force after it.
    pub compensates: bool,
    /// Its operations. Under cutter compensation those of the block before may be among them.
    pub ops: &'a [SourcedOp],
    /// Errors that it has.
    pub errors: u64,
    /// It was not carried out: it stands in a branch not taken, or defines a subroutine.
    pub passed: bool,
    /// The interpreter after it.
    pub interpreter: &'a Interpreter,
}

impl Event<'_> {
    /// The block as it was parsed.
    pub fn block(&self) -> &Block {
        self.interpreter.block()
    }

    /// Whether it is a line of words that was carried out without an error.
    pub fn is_plain(&self) -> bool {
        !self.passed && self.errors == 0 && self.block().flow.is_none() && !self.block().percent
    }
}

/// Runs a program to its end and shows every block to `see`.
///
/// ```
/// use lostmotion_gcode::program::watch;
/// use lostmotion_gcode::{InterpreterConfig, Program};
///
/// let mut program = Program::new(&b"G21 G0 X5\nG91 X1\nM2\n"[..], InterpreterConfig::default());
/// let mut ends = Vec::new();
/// watch(&mut program, |event| ends.push(event.after.current[0]));
/// assert_eq!(ends[..2], [5.0, 6.0]);
/// ```
pub fn watch<R: BufRead>(program: &mut Program<R>, mut see: impl FnMut(&Event<'_>)) {
    program.take_pending();
    let mut ops = Vec::new();
    let mut before = program.light_state();
    loop {
        let interpreter = program.interpreter();
        // Noted before the block runs: it may itself end the compensation or return from the call.
        let compensated = interpreter.state().compensation.is_some();
        let (passed, call_stack) = (interpreter.passes_over(), interpreter.place().call_stack);
        let errors = interpreter.diagnostics().errors();
        ops.clear();
        if !program.run_block(&mut ops) {
            return;
        }
        let after = program.light_state();
        let interpreter = program.interpreter();
        see(&Event {
            place: BlockRef {
                call_stack,
                ..interpreter.place()
            },
            before: &before,
            compensated,
            after: &after,
            compensates: interpreter.state().compensation.is_some(),
            ops: &ops,
            errors: interpreter.diagnostics().errors() - errors,
            passed,
            interpreter,
        });
        before = after;
    }
}

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
