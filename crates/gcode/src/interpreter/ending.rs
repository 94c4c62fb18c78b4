//! The end: of a level of calls, of the source, and of programs that run too long.

use super::control::flow_error;
use super::flow::Skip;
use super::{Interpreter, Percent, Step};
use crate::dialect::Leniency;
use crate::ops::{CanonicalOp, SourcedOp};
use crate::problem::Problem;
use lostmotion_base::span::Span;

impl Interpreter {
    /// The source is at its end: what is still open, and whether the program ended.
    pub(super) fn finish(&mut self, out: &mut Vec<SourcedOp>) -> Step {
        if self.goto_failed() {
            return Step::Ran;
        }
        // A subroutine was looked for to the end: the call runs again and asks the loader.
        if let Some(seek) = self.flow.seek.take() {
            self.flow.record = None;
            self.missing_sub = Some(seek.name);
            return Step::Ran;
        }
        self.check_open();
        self.release_held(out);
        // The end has the place of the last line, without a stretch of text.
        self.span = Span {
            column: 1,
            len: 0,
            ..self.span
        };
        if self.percent == Percent::Open {
            self.forgive(Problem::NoClosingPercent, Leniency::MissingEnd);
        } else if !self.config.dialect.is_printer() {
            // Firmware of printers has no code for the end.
            self.forgive(Problem::NoProgramEnd, Leniency::MissingEnd);
        }
        self.settle_habits();
        self.state.ended = true;
        Step::Ended
    }

    /// Emits the moves that cutter compensation still holds as they are, and reports a curve that is
    /// not closed.
    pub(super) fn release_held(&mut self, out: &mut Vec<SourcedOp>) {
        // A curve without G5.3 has no end and is not run.
        if self.state.nurbs.take().is_some() {
            self.report(crate::exec::curves::unclosed());
        }
        if let Err(problem) = self.exec(out).end_compensation() {
            self.report(problem);
        }
    }

    /// Reports structures that are not closed.
    pub(super) fn check_open(&mut self) {
        if let Some(record) = self.flow.record.take() {
            self.report_at(Problem::UnclosedSub { name: record.name }, record.span);
        }
        // Of what is open only the innermost is told: the others often follow from it.
        if let Some((label, skip, span)) = self.flow.skip.take() {
            let what = if matches!(skip, Skip::Branch | Skip::EndIf) {
                "if"
            } else {
                "loop"
            };
            self.report_at(
                flow_error(format!("the {what} o{label} is not closed")),
                span,
            );
        } else if let Some(open) = self.flow.opens.pop() {
            let what = if open.kind.is_loop() { "loop" } else { "if" };
            self.report_at(
                flow_error(format!("the {what} o{} is not closed", open.label)),
                open.span,
            );
        }
    }
}

impl Interpreter {
    /// Forgets what the level that is left has saved; what M73 saved comes back before the next
    /// block.
    pub(crate) fn leave_level(&mut self) {
        // The main program's own level is never left.
        if self.saved.len() > 1
            && let Some(saved) = self.saved.pop()
            && saved.automatic
        {
            self.returning = saved.modes;
        }
    }

    /// Brings back what a level that has been left had saved.
    pub(crate) fn restore_left(&mut self, out: &mut Vec<SourcedOp>) -> Result<(), Problem> {
        match self.returning.take() {
            Some(modes) => self.exec(out).restore(&modes),
            None => Ok(()),
        }
    }
}

/// Blocks that a loop may run at a stretch once the program has an error.
const LOOPED_AFTER_ERROR: u64 = 300_000;

impl Interpreter {
    /// Ends programs that run too long.
    pub(super) fn watch(&mut self, ops: &[SourcedOp]) {
        let limits = &self.config.limits;
        let acts = |sourced: &SourcedOp| {
            use CanonicalOp as O;
            matches!(
                sourced.op,
                O::StraightTraverse(_)
                    | O::StraightFeed(_)
                    | O::ArcFeed(_)
                    | O::NurbsFeed(_)
                    | O::StraightProbe(_)
                    | O::RigidTap(_)
                    | O::Dwell(_)
                    | O::ProgramStop
                    | O::OptionalProgramStop
            )
        };
        // Blocks and operations since the last line was read, and blocks since the last motion.
        self.looped += 1;
        self.made += ops.len() as u64;
        self.idle = if ops.iter().any(acts) {
            0
        } else {
            self.idle + 1
        };
        // An idle loop comes first: that says more than a count of blocks.
        let problem = if self.idle > limits.idle_blocks {
            Problem::IdleLoop {
                limit: limits.idle_blocks,
            }
        } else if self.executed > limits.executed_blocks {
            Problem::TooManyBlocks {
                limit: limits.executed_blocks,
            }
        } else if self.looped > self.looped_limit() {
            Problem::TooManyLoopedBlocks {
                limit: self.looped_limit(),
            }
        } else if self.looped > 1 && self.made > limits.looped_operations {
            Problem::TooManyOperations {
                limit: limits.looped_operations,
            }
        } else {
            return;
        };
        self.report(problem);
        self.state.ended = true;
    }

    /// A loop of a program that is refused anyway often runs on because of its errors.
    fn looped_limit(&self) -> u64 {
        let limit = self.config.limits.looped_blocks;
        if self.diagnostics.errors() > 0 {
            limit.min(LOOPED_AFTER_ERROR)
        } else {
            limit
        }
    }
}
