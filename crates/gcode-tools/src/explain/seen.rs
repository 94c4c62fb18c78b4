//! An execution as it was seen, before it is put into words: a line may run millions of times.

use super::{Call, Execution, Snapshot, action};
use lostmotion_gcode::interpreter::Interpreter;
use lostmotion_gcode::ops::{CanonicalOp, Position, SourcedOp};
use lostmotion_gcode::provenance::CallSite;
use lostmotion_gcode::state::State;
use lostmotion_gcode::trace::Event;

/// Most actions that are listed for one execution.
const ACTIONS: usize = 100;

/// What one execution needs to be told.
pub(super) struct Seen {
    call_stack: u32,
    refused: bool,
    before: (State, bool),
    after: (State, bool),
    /// Operations with the places where they begin.
    ops: Vec<(Position, CanonicalOp)>,
    count: usize,
}

impl Seen {
    pub(super) fn of(event: &Event<'_>) -> Seen {
        Seen {
            call_stack: event.place.call_stack,
            refused: event.errors > 0,
            before: (event.before.clone(), event.compensated),
            after: (event.after.clone(), event.compensates),
            ops: Vec::new(),
            count: 0,
        }
    }

    /// Takes the operations of the line, which under cutter compensation come with later blocks.
    pub(super) fn take(&mut self, event: &Event<'_>, line: u32) {
        let mut at = event.before.current;
        for SourcedOp { op, block } in event.ops {
            if (block.span.file, block.span.line) == (0, line) {
                self.count += 1;
                if self.ops.len() < ACTIONS {
                    self.ops.push((at, op.clone()));
                }
            }
            action::advance(op, &mut at);
        }
    }

    pub(super) fn execution(&self, interpreter: &Interpreter) -> Execution {
        let call = |site: &CallSite| Call {
            sub: site.name.clone(),
            line: site.call.line,
            file: interpreter.file_name(site.call.file).map(str::to_owned),
        };
        Execution {
            calls: interpreter
                .call_stacks()
                .trace(self.call_stack)
                .map(call)
                .collect(),
            refused: self.refused,
            before: Snapshot::of(&self.before.0, self.before.1),
            after: Snapshot::of(&self.after.0, self.after.1),
            actions: self
                .ops
                .iter()
                .map(|(at, op)| action::describe(op, at, self.after.0.units))
                .collect(),
            action_count: self.count,
        }
    }
}
