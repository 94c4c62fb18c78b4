//! A program watched block by block: what each block found, did and left behind.

use crate::interpreter::Interpreter;
use crate::ops::SourcedOp;
use crate::program::Program;
use crate::state::State;
use crate::syntax::Block;
use lostmotion_base::span::BlockRef;
use std::io::BufRead;

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
    /// The operations it gave out. Under cutter compensation those of the block before may come
    /// with it.
    pub ops: &'a [SourcedOp],
    /// Errors that it has.
    pub errors: u64,
    /// It was only looked at: a branch not taken, or the definition of a subroutine.
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
pub fn watch<R: BufRead>(program: &mut Program<R>, mut see: impl FnMut(&Event<'_>)) {
    program.take_pending();
    let mut ops = Vec::new();
    let mut before = program.light_state();
    loop {
        let interpreter = program.interpreter();
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
