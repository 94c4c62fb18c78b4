//! Ends programs that run too long.

use super::Interpreter;
use crate::ops::{CanonicalOp, SourcedOp};
use crate::problem::Problem;

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
        self.looped += 1;
        self.made += ops.len() as u64;
        self.idle = if ops.iter().any(acts) {
            0
        } else {
            self.idle + 1
        };
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
