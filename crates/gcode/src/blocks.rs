//! Blocks as they stand in the source, parsed and not carried out.

use crate::interpreter::Place;
use crate::limits::Limits;
use crate::problem::Problem;
use crate::source::{LineKind, Lines};
use crate::syntax::{Block, Fault, Text, Tokens, parse_block};
use lostmotion_base::span::Span;
use std::io::{self, BufRead};

/// Reads a source block by block, in memory that does not grow with its length. Lines end with LF,
/// CR LF or CR.
///
/// ```
/// use lostmotion_gcode::{Blocks, Limits};
///
/// let mut blocks = Blocks::new(&b"G1 X10\nY5\n"[..], Limits::default());
/// let mut words = 0;
/// while let Some(parsed) = blocks.read()? {
///     words += parsed.block.words.len();
/// }
/// assert_eq!(words, 3);
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct Blocks<R> {
    lines: Lines<R>,
    block: Block,
    limits: Limits,
}

/// A line and what it was parsed to.
#[derive(Debug)]
pub struct ParsedBlock<'a> {
    /// Where the line stands.
    pub place: Place,
    /// The line without its terminator; its beginning if it is too long.
    pub line: &'a [u8],
    /// Its words; those before the fault if it has one.
    pub block: &'a Block,
    /// Why it could not be parsed.
    pub fault: Option<Fault>,
}

impl<'a> ParsedBlock<'a> {
    /// The line in tokens that lie side by side.
    pub fn tokens(&self) -> Tokens<'a> {
        Tokens::new(self.line, self.block)
    }

    /// The place of a word, setting or comment of the block in the source.
    pub fn span(&self, text: Text) -> Span {
        self.place.span(text)
    }
}

impl<R: BufRead> Blocks<R> {
    /// Blocks of a reader; `&[u8]` is one.
    pub fn new(source: R, limits: Limits) -> Blocks<R> {
        Blocks {
            lines: Lines::new(source, limits.line_bytes),
            block: Block::default(),
            limits,
        }
    }

    /// The next block, none at the end of the source.
    ///
    /// # Errors
    /// Those of the reader.
    pub fn read(&mut self) -> io::Result<Option<ParsedBlock<'_>>> {
        let Some((kind, line, start)) = self.lines.next()? else {
            return Ok(None);
        };
        let line_bytes = self.lines.line();
        let fault = match kind {
            LineKind::Whole => parse_block(line_bytes, &mut self.block, &self.limits).err(),
            LineKind::TooLong(bytes) => {
                self.block.clear();
                Some(Fault {
                    rest: bytes,
                    problem: Box::new(Problem::LineTooLong {
                        bytes,
                        limit: self.limits.line_bytes,
                    }),
                })
            }
        };
        Ok(Some(ParsedBlock {
            place: Place {
                file: 0,
                line,
                start,
            },
            line: line_bytes,
            block: &self.block,
            fault,
        }))
    }
}
