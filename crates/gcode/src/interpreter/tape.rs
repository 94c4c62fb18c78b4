//! Source lines that are held because they may run again.

use crate::problem::Problem;
use crate::syntax::Text;
use lostmotion_base::span::Span;

/// Where a line stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Index of the file; 0 is the program itself.
    pub file: u32,
    /// Line number from 1.
    pub line: u32,
    /// Offset of the line's first byte in the file.
    pub start: u64,
}

impl Place {
    /// The place of a part of the line.
    pub fn span(self, text: Text) -> Span {
        Span {
            file: self.file,
            line: self.line,
            column: text.start + 1,
            start: self.start + u64::from(text.start),
            len: text.len,
        }
    }
}

/// What a line takes beside its bytes.
const LINE_OVERHEAD_BYTES: usize = 32;

/// Lines of source in one buffer.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tape {
    bytes: Vec<u8>,
    lines: Vec<(Place, usize, usize)>,
}

impl Tape {
    pub(crate) fn push(&mut self, line: &[u8], place: Place, limit: usize) -> Result<(), Problem> {
        if self.size() + line.len() > limit {
            return Err(Problem::TooMuchHeld { limit });
        }
        let from = self.bytes.len();
        self.bytes.extend_from_slice(line);
        self.lines.push((place, from, self.bytes.len()));
        Ok(())
    }

    /// Bytes held, with what it takes to find the lines.
    pub(crate) fn size(&self) -> usize {
        self.bytes.len() + LINE_OVERHEAD_BYTES * self.lines.len()
    }

    pub(crate) fn clear(&mut self) {
        self.bytes.clear();
        self.lines.clear();
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.bytes.len()
    }

    pub(crate) fn len(&self) -> usize {
        self.lines.len()
    }

    pub(crate) fn get(&self, index: usize) -> Option<(Place, &[u8])> {
        let (place, from, to) = *self.lines.get(index)?;
        Some((place, self.bytes.get(from..to)?))
    }
}
