//! What a reader of the interpreter can see of the block that has just run.

use super::Interpreter;
use crate::codes::CodeRow;
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::limits::Limits;
use crate::parameters::Parameters;
use crate::provenance::CallStacks;
use crate::state::State;
use crate::syntax::{Block, Text, Word};
use lostmotion_base::span::BlockRef;

impl Interpreter {
    /// The calls that [`BlockRef::call_stack`] points to.
    pub fn call_stacks(&self) -> &CallStacks {
        self.diagnostics.provenance().call_stacks()
    }

    /// Name of the file of an index in a span; `None` for the program itself, which is 0.
    pub fn file_name(&self, index: u32) -> Option<&str> {
        self.diagnostics.file(index).map(|file| file.name.as_str())
    }

    /// The modes, offsets and position after the blocks run so far.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// All parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The bounds it runs under.
    pub fn limits(&self) -> &Limits {
        &self.config.limits
    }

    /// What has been found so far.
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.diagnostics
    }

    /// Takes the kept findings out and goes on: as many again can be kept.
    pub fn take_diagnostics(&mut self) -> Vec<Diagnostic> {
        self.diagnostics.take_kept()
    }

    /// Takes the findings out.
    pub fn into_diagnostics(self) -> Diagnostics {
        self.diagnostics
    }

    /// The last block, as it was parsed. After a block that could not be parsed, what stood before
    /// the fault.
    pub fn block(&self) -> &Block {
        &self.block
    }

    /// The state without what may be large: the moves that cutter compensation holds, the points of
    /// an open curve.
    pub(crate) fn light_state(&mut self) -> State {
        let (compensation, nurbs) = (self.state.compensation.take(), self.state.nurbs.take());
        let light = self.state.clone();
        (self.state.compensation, self.state.nurbs) = (compensation, nurbs);
        light
    }

    /// The bytes of the last block's line.
    pub fn line(&self) -> &[u8] {
        &self.line
    }

    /// Where the last block stands, with the call that is running now.
    pub fn place(&self) -> BlockRef {
        BlockRef {
            span: self.span,
            call_stack: self.stack_index,
        }
    }

    /// Whether the next line will only be looked at: it lies in a branch that is not taken, in the
    /// definition of a subroutine, or is passed on the way to one.
    pub fn passes_over(&self) -> bool {
        self.is_passing()
    }

    /// The value that a word of the last block had, where it has been evaluated and is not a code.
    pub fn value_of(&self, word: &Word) -> Option<f64> {
        self.words
            .get(word.letter)
            .filter(|_| self.words.text(word.letter) == word.text)
    }

    /// The codes of the last block in the order in which they are carried out, with their places on
    /// the line.
    pub fn codes(&self) -> impl Iterator<Item = (&'static CodeRow, Text)> + '_ {
        self.words.codes().iter().map(|used| (used.row, used.text))
    }
}
