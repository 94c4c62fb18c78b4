//! Where blocks come from: the files of subroutines, and the calls that led to them.

use lostmotion_base::span::Span;
use std::collections::BTreeMap;
use std::fmt::Debug;
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
    /// The files of subroutines that were read; a span's file 1 is the first of them.
    pub fn files(&self) -> &SourceFiles {
        &self.files
    }

    /// The file of a span's index; `None` for the program itself, which is 0.
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

/// The text that spans point into: the program's own bytes, and the files of subroutines.
///
/// ```
/// use lostmotion_gcode::{InterpreterConfig, Program, SourceText};
///
/// let text = b"G21 F200\nG2 X20 I4\nM2\n";
/// let found = Program::new(&text[..], InterpreterConfig::default()).finish();
/// let source = SourceText::new(text, found.provenance());
/// let span = found.kept()[0].place.span;
/// assert_eq!(source.text(span), Some(&b"G2"[..]));
/// assert_eq!(source.line(span), Some(&b"G2 X20 I4"[..]));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct SourceText<'a> {
    program: &'a [u8],
    provenance: &'a Provenance,
}

impl<'a> SourceText<'a> {
    /// The text of a reading: the bytes of the program, and what the reading knows of files.
    pub fn new(program: &'a [u8], provenance: &'a Provenance) -> SourceText<'a> {
        SourceText {
            program,
            provenance,
        }
    }

    /// The bytes of a span; `None` if it does not lie within its file.
    pub fn text(&self, span: Span) -> Option<&'a [u8]> {
        let start = usize::try_from(span.start).ok()?;
        self.file(span)?
            .get(start..start.checked_add(span.len as usize)?)
    }

    /// The whole line that a span begins on, without its terminator; `None` if the span does not
    /// begin within its file.
    pub fn line(&self, span: Span) -> Option<&'a [u8]> {
        let file = self.file(span)?;
        let (before, after) = file.split_at_checked(usize::try_from(span.start).ok()?)?;
        let is_end = |byte: &u8| matches!(byte, b'\n' | b'\r');
        let from = before.iter().rposition(is_end).map_or(0, |at| at + 1);
        let to = before.len() + after.iter().position(is_end).unwrap_or(after.len());
        file.get(from..to)
    }

    fn file(&self, span: Span) -> Option<&'a [u8]> {
        if span.file == 0 {
            Some(self.program)
        } else {
            self.provenance.file(span.file).map(|file| &*file.text)
        }
    }
}

/// Most distinct calls that are told apart; further ones count as made from the main program. Bounds
/// the memory of the tree.
const MOST_CALLS: usize = 100_000;

/// A call of a subroutine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CallSite {
    /// The subroutine.
    pub name: String,
    /// The block that called it.
    pub call: Span,
    /// Index of the call that this one was made in; 0 is the main program.
    pub within: u32,
}

/// All calls made so far, each kept once; index 0 is the main program and has no entry.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CallStacks {
    sites: Vec<CallSite>,
    known: BTreeMap<(u32, Span), u32>,
}

impl CallStacks {
    /// The call of an index, as [`lostmotion_base::span::BlockRef`] has it; `None` for the main
    /// program.
    pub fn get(&self, index: u32) -> Option<&CallSite> {
        self.sites.get((index as usize).checked_sub(1)?)
    }

    /// The calls that lead to an index, innermost first.
    pub fn trace(&self, index: u32) -> impl Iterator<Item = &CallSite> {
        std::iter::successors(self.get(index), |site| self.get(site.within))
    }

    /// The index of a call.
    pub(crate) fn enter(&mut self, name: &str, call: Span, within: u32) -> u32 {
        if let Some(&index) = self.known.get(&(within, call)) {
            // A label that is computed may name another subroutine at the same place.
            if self.get(index).is_some_and(|site| site.name == name) {
                return index;
            }
        }
        // A full tree counts further calls as the main program's: places stay right, traces end
        // early.
        if self.sites.len() >= MOST_CALLS {
            return 0;
        }
        self.sites.push(CallSite {
            name: name.to_owned(),
            call,
            within,
        });
        let index = self.sites.len() as u32;
        self.known.insert((within, call), index);
        index
    }
}

/// Gives the text of a file that holds a subroutine. All access to files is behind this trait.
pub trait SubroutineLoader: Debug + Send + Sync {
    /// The file of subroutine `name` (lower case, as in `o<name> call`, or the number of an M98),
    /// with the name to show for it; `None` if there is no such file.
    ///
    /// # Errors
    /// Why the file cannot be read.
    fn load(&self, name: &str) -> Result<Option<LoadedFile>, String>;
}

/// A file with subroutines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadedFile {
    /// Its name, for messages.
    pub name: String,
    /// What it contains.
    pub text: Vec<u8>,
}

/// The files of a run: index 0 of the list is file 1 of spans, file 0 being the program itself.
pub type SourceFiles = Vec<Arc<LoadedFile>>;

/// Files held in memory, by the name of their subroutine.
impl SubroutineLoader for BTreeMap<String, Vec<u8>> {
    fn load(&self, name: &str) -> Result<Option<LoadedFile>, String> {
        Ok(self.get(name).map(|text| LoadedFile {
            name: format!("{name}.ngc"),
            text: text.clone(),
        }))
    }
}
