//! Modes that a subroutine has saved, brought back when it is left.

use super::Interpreter;
use crate::ops::SourcedOp;
use crate::problem::Problem;

impl Interpreter {
    /// Forgets what the level that is left has saved; what M73 saved comes back before the next
    /// block.
    pub(crate) fn leave_level(&mut self) {
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
