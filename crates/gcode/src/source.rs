//! Lines and blocks from bytes: lines end with LF, CR LF or CR alone, a byte order mark is skipped,
//! lengths are bounded.

use crate::dialect::{Dialect, Leniencies, Leniency};
use crate::limits::Limits;
use crate::problem::Problem;
use crate::syntax::reading::{is_printers_code, merge_exponents, parse_accepted};
use crate::syntax::{Block, Fault, Text, Tokens, parse_block};
use lostmotion_base::span::Span;
use memchr::memchr2;
use std::io::{self, BufRead};

/// What a line was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LineKind {
    /// A line within the limit.
    Whole,
    /// A line longer than the limit: only its beginning is kept. Its length in bytes.
    TooLong(usize),
}

/// Ends of lines other than LF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LineEnd {
    /// CR alone.
    Cr,
    /// CR LF.
    CrLf,
}

/// Splits a reader into lines. A line that lies whole in the reader's buffer stays there.
#[derive(Debug)]
pub(crate) struct Lines<R> {
    reader: R,
    /// The last line, if it is not `in_place`.
    line: Vec<u8>,
    /// Length of the last line at the beginning of the reader's buffer.
    in_place: Option<usize>,
    /// Bytes of the reader's buffer that the last line has used up.
    used: usize,
    /// Offset of the next byte.
    offset: u64,
    /// Number of the last line.
    number: u32,
    after_cr: bool,
    limit: usize,
    /// A byte order mark was skipped.
    pub(crate) marked: bool,
    /// How the line before the last one ended, where not with LF alone.
    pub(crate) end: Option<LineEnd>,
}

const MARK: &[u8] = b"\xef\xbb\xbf";

impl<R: BufRead> Lines<R> {
    pub(crate) fn new(reader: R, limit: usize) -> Lines<R> {
        Lines {
            reader,
            line: Vec::new(),
            in_place: None,
            used: 0,
            offset: 0,
            number: 0,
            after_cr: false,
            limit,
            marked: false,
            end: None,
        }
    }

    /// The next line with its number and offset, none at the end.
    pub(crate) fn next(&mut self) -> io::Result<Option<(LineKind, u32, u64)>> {
        // The line before was lent from the reader's buffer: it is consumed only now.
        self.reader.consume(std::mem::take(&mut self.used));
        self.line.clear();
        self.in_place = None;
        self.end = None;
        let mut length = 0;
        let mut start = self.offset;
        loop {
            let buffer = self.reader.fill_buf()?;
            if buffer.is_empty() {
                // A CR at the very end was no CR LF.
                if std::mem::take(&mut self.after_cr) {
                    self.end = Some(LineEnd::Cr);
                }
                return Ok(if length == 0 {
                    None
                } else {
                    Some(self.finished(length, start))
                });
            }
            // A LF right after a CR belongs to the same terminator, also across buffers.
            if self.after_cr {
                self.after_cr = false;
                if buffer.first() == Some(&b'\n') {
                    self.reader.consume(1);
                    self.offset += 1;
                    start = self.offset;
                    self.end = Some(LineEnd::CrLf);
                    continue;
                }
                self.end = Some(LineEnd::Cr);
            }
            let end = memchr2(b'\n', b'\r', buffer);
            let piece = buffer
                .get(..end.unwrap_or(buffer.len()))
                .unwrap_or_default();
            let terminator = end.and_then(|at| buffer.get(at)).copied();
            let used = piece.len() + usize::from(terminator.is_some());
            self.offset += used as u64;
            self.after_cr = terminator == Some(b'\r');
            // A line that lies whole in the buffer is not copied.
            if terminator.is_some() && length == 0 && piece.len() <= self.limit && start > 0 {
                (self.in_place, self.used) = (Some(piece.len()), used);
                self.number = self.number.saturating_add(1);
                return Ok(Some((LineKind::Whole, self.number, start)));
            }
            // Otherwise its parts are gathered, up to the limit.
            let room = self.limit.saturating_sub(self.line.len()).min(piece.len());
            self.line
                .extend_from_slice(piece.get(..room).unwrap_or_default());
            length += piece.len();
            self.reader.consume(used);
            if terminator.is_some() {
                return Ok(Some(self.finished(length, start)));
            }
        }
    }

    fn finished(&mut self, length: usize, start: u64) -> (LineKind, u32, u64) {
        self.number = self.number.saturating_add(1);
        if start == 0 && self.line.starts_with(MARK) {
            self.marked = true;
            // Blanks in its place keep every column where an editor shows it.
            if let Some(mark) = self.line.get_mut(..MARK.len()) {
                mark.fill(b' ');
            }
        }
        let kind = if length > self.limit {
            LineKind::TooLong(length)
        } else {
            LineKind::Whole
        };
        (kind, self.number, start)
    }

    /// The bytes of the last line.
    pub(crate) fn line(&mut self) -> &[u8] {
        match self.in_place {
            // The buffer still holds the line: this reads nothing.
            Some(length) => self
                .reader
                .fill_buf()
                .ok()
                .and_then(|buffer| buffer.get(..length))
                .unwrap_or_default(),
            None => &self.line,
        }
    }
}

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
    /// Whose lines they are; RS274/NGC without leniencies if `None`.
    dialect: Option<(Dialect, Leniencies)>,
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
            dialect: None,
        }
    }

    /// The same with lines as a dialect has them. What it passes over has no words: commands with text,
    /// codes that only printers have.
    ///
    /// ```
    /// use lostmotion_gcode::{Blocks, Dialect, Limits};
    ///
    /// let dialect = Dialect::Marlin;
    /// let mut blocks = Blocks::new(&b"M117 go to X5\nG1 X5 E.2\n"[..], Limits::default())
    ///     .accepting(dialect, dialect.leniencies());
    /// let mut words = Vec::new();
    /// while let Some(parsed) = blocks.read()? {
    ///     assert!(parsed.fault.is_none());
    ///     words.push(parsed.block.words.len());
    /// }
    /// assert_eq!(words, [0, 3]);
    /// # Ok::<(), std::io::Error>(())
    /// ```
    #[must_use]
    pub fn accepting(self, dialect: Dialect, leniencies: Leniencies) -> Blocks<R> {
        Blocks {
            dialect: Some((dialect, leniencies)),
            ..self
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
            LineKind::Whole => {
                parse_line(line_bytes, &mut self.block, &self.limits, self.dialect).err()
            }
            // Only its beginning was kept: parsing that could mean anything.
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

/// Parses a line as the interpreter does.
fn parse_line(
    line: &[u8],
    block: &mut Block,
    limits: &Limits,
    dialect: Option<(Dialect, Leniencies)>,
) -> Result<(), Fault> {
    let parsed = parse_block(line, block, limits);
    let Some((dialect, accepted)) = dialect else {
        return parsed;
    };
    if let Err(fault) = parsed {
        parse_accepted(line, block, limits, accepted, fault)?;
    }
    if accepted.has(Leniency::Exponents) {
        merge_exponents(line, block, dialect.is_fanuc());
    }
    if dialect.is_printer() && accepted.has(Leniency::PrinterCodes) && is_printers_code(block) {
        block.words.clear();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn split(text: &[u8], capacity: usize) -> Vec<(Vec<u8>, u32, u64)> {
        let mut lines = Lines::new(io::BufReader::with_capacity(capacity, text), 1000);
        let mut all = Vec::new();
        while let Some((_, number, start)) = lines.next().unwrap() {
            all.push((lines.line().to_vec(), number, start));
        }
        all
    }

    #[test]
    fn every_terminator_ends_a_line() {
        let lines = split(b"a\nb\r\nc\rd", 100);
        let texts: Vec<_> = lines
            .iter()
            .map(|(text, number, start)| (text.as_slice(), *number, *start))
            .collect();
        assert_eq!(
            texts,
            [(&b"a"[..], 1, 0), (b"b", 2, 2), (b"c", 3, 5), (b"d", 4, 7)]
        );
    }

    #[test]
    fn long_lines_are_cut_and_told() {
        let mut lines = Lines::new(&b"0123456789\nab\n"[..], 4);
        assert_eq!(lines.next().unwrap(), Some((LineKind::TooLong(10), 1, 0)));
        assert_eq!(lines.line(), b"0123");
        assert_eq!(lines.next().unwrap(), Some((LineKind::Whole, 2, 11)));
    }

    proptest! {
        #[test]
        fn the_size_of_the_pieces_does_not_matter(text in "[ab\r\n]{0,40}", capacity in 1usize..10) {
            prop_assert_eq!(split(text.as_bytes(), capacity), split(text.as_bytes(), 100));
        }
    }
}
