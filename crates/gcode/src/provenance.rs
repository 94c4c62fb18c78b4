//! Where blocks come from: the files of subroutines, and the calls that led to them.

use crate::interpreter::CallStacks;
use crate::loader::{LoadedFile, SourceFiles};
use std::sync::Arc;

/// What a [`lostmotion_base::span::BlockRef`] points into: files by
/// [`lostmotion_base::span::Span::file`], calls by its `call_stack`.
///
/// It belongs to one reading of a program; that of another reading may count files and calls in
/// another order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provenance {
    files: SourceFiles,
    stacks: CallStacks,
}

impl Provenance {
    /// The files of subroutines that were read: what spans with a file other than 0 are about.
    pub fn files(&self) -> &SourceFiles {
        &self.files
    }

    /// The file of a span's index; none for the program itself, which is 0.
    pub fn file(&self, index: u32) -> Option<&LoadedFile> {
        self.files
            .get((index as usize).checked_sub(1)?)
            .map(|file| &**file)
    }

    /// The calls that were made.
    pub fn call_stacks(&self) -> &CallStacks {
        &self.stacks
    }

    pub(crate) fn add_file(&mut self, file: Arc<LoadedFile>) {
        self.files.push(file);
    }

    pub(crate) fn call_stacks_mut(&mut self) -> &mut CallStacks {
        &mut self.stacks
    }
}
