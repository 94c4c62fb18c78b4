//! A program that is edited: what is not touched stays as it is, byte for byte.

mod block_text;

pub use block_text::block_text;
use lostmotion_gcode::limits::Limits;
use lostmotion_gcode::syntax::{Block, Fault, Word, parse_block};
use std::io::{self, BufRead};

/// A program as lines that can be changed. It is held in memory.
///
/// ```
/// use lostmotion_gcode_tools::document::Document;
///
/// let mut document = Document::parse(b"g1  x10 (rough)  f200\r\nM2\r\n");
/// document.set_word(1, 'F', 150.5)?;
/// assert_eq!(document.to_bytes(), b"g1  x10 (rough)  f150.5\r\nM2\r\n");
/// # Ok::<(), lostmotion_gcode_tools::document::EditError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Document {
    lines: Vec<RawLine>,
}

/// Why an edit is not possible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EditError {
    /// The program does not have the line.
    #[error("the program has {lines} lines, no line {line}")]
    NoSuchLine {
        /// The line asked for, from 1.
        line: usize,
        /// How many there are.
        lines: usize,
    },
    /// The line cannot be parsed.
    #[error("line {line}: {}", fault.problem)]
    Unreadable {
        /// The line.
        line: usize,
        /// What is wrong with it.
        fault: Fault,
    },
    /// The line does not have the word.
    #[error("line {line} has no word {letter}")]
    NoSuchWord {
        /// The line.
        line: usize,
        /// The letter asked for.
        letter: char,
    },
    /// The value is not finite.
    #[error("{value} cannot be written as a number")]
    NotANumber {
        /// The value.
        value: f64,
    },
    /// A text that is more than one line.
    #[error("a line cannot contain a line end")]
    SeveralLines,
}

impl Document {
    /// Takes a program apart into lines. Any bytes are a program.
    pub fn parse(mut bytes: &[u8]) -> Document {
        let mut document = Document::default();
        let mut line = RawLine::default();
        // Reading from memory does not fail.
        while read_line(&mut bytes, &mut line).unwrap_or(false) {
            document.lines.push(std::mem::take(&mut line));
        }
        document
    }

    /// The program as bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for line in &self.lines {
            bytes.extend_from_slice(&line.text);
            bytes.extend_from_slice(line.end);
        }
        bytes
    }

    /// How many lines there are.
    pub fn len(&self) -> usize {
        self.lines.len()
    }

    /// Whether there is no line.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// The text of a line, from 1, without its terminator.
    ///
    /// # Errors
    /// There is no such line.
    pub fn line(&self, line: usize) -> Result<&[u8], EditError> {
        let lines = self.len();
        let found = line.checked_sub(1).and_then(|index| self.lines.get(index));
        found
            .map(|raw| raw.text.as_slice())
            .ok_or(EditError::NoSuchLine { line, lines })
    }

    /// A line as a block.
    ///
    /// # Errors
    /// There is no such line, or it cannot be parsed.
    pub fn block(&self, line: usize) -> Result<Block, EditError> {
        let mut block = Block::default();
        parse_block(self.line(line)?, &mut block, &Limits::default())
            .map_err(|fault| EditError::Unreadable { line, fault })?;
        Ok(block)
    }

    /// Gives a line another text. Its terminator stays.
    ///
    /// # Errors
    /// There is no such line, or the text is more than one.
    pub fn set_line(&mut self, line: usize, text: &[u8]) -> Result<(), EditError> {
        one_line(text)?;
        self.line(line)?;
        if let Some(raw) = self.lines.get_mut(line - 1) {
            raw.text = text.to_vec();
        }
        Ok(())
    }

    /// Puts a new line before a line; one more than the last line appends. It ends as its neighbour
    /// does.
    ///
    /// # Errors
    /// There is no such place, or the text is more than one line.
    pub fn insert_line(&mut self, line: usize, text: &[u8]) -> Result<(), EditError> {
        one_line(text)?;
        let lines = self.len();
        if line == 0 || line > lines + 1 {
            return Err(EditError::NoSuchLine { line, lines });
        }
        // The terminator of the first line that has one: files mix them rarely.
        let end = self
            .lines
            .iter()
            .map(|raw| raw.end)
            .find(|end| !end.is_empty())
            .unwrap_or(b"\n");
        // The last line of a file may lack its terminator; a line after it needs one.
        if line == lines + 1
            && let Some(last) = self.lines.last_mut().filter(|last| last.end.is_empty())
        {
            last.end = end;
        }
        self.lines.insert(
            line - 1,
            RawLine {
                text: text.to_vec(),
                end,
            },
        );
        Ok(())
    }

    /// Takes a line out.
    ///
    /// # Errors
    /// There is no such line.
    pub fn remove_line(&mut self, line: usize) -> Result<(), EditError> {
        self.line(line)?;
        self.lines.remove(line - 1);
        Ok(())
    }

    /// Gives the first word of a letter another value; everything else on the line stays as it is.
    ///
    /// # Errors
    /// There is no such line or word, the line cannot be parsed, the value is not finite.
    pub fn set_word(&mut self, line: usize, letter: char, value: f64) -> Result<(), EditError> {
        if !value.is_finite() {
            return Err(EditError::NotANumber { value });
        }
        // Letters are stored in upper case, whatever the line has.
        let is_it = |word: &&Word| char::from(word.letter) == letter.to_ascii_uppercase();
        let text = self
            .block(line)?
            .words
            .iter()
            .find(is_it)
            .map(|word| word.text);
        let text = text.ok_or(EditError::NoSuchWord { line, letter })?;
        // The value's bytes: the word without its letter.
        let (from, to) = (text.start as usize + 1, (text.start + text.len) as usize);
        if let Some(raw) = self.lines.get_mut(line - 1) {
            raw.text.splice(from..to, value.to_string().into_bytes());
        }
        Ok(())
    }
}

fn one_line(text: &[u8]) -> Result<(), EditError> {
    if text.iter().any(|byte| matches!(byte, b'\n' | b'\r')) {
        Err(EditError::SeveralLines)
    } else {
        Ok(())
    }
}

/// A line and what ended it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct RawLine {
    pub(crate) text: Vec<u8>,
    /// LF, CR LF, CR, or nothing at the end of the file.
    pub(crate) end: &'static [u8],
}

/// Reads the next line into `line`, whose buffer is reused; false at the end.
///
/// # Errors
/// Those of the reader.
pub(crate) fn read_line(reader: &mut impl BufRead, line: &mut RawLine) -> io::Result<bool> {
    line.text.clear();
    line.end = b"";
    loop {
        let buffer = reader.fill_buf()?;
        if buffer.is_empty() {
            return Ok(!line.text.is_empty());
        }
        // A line may span several fills of the buffer.
        let at = buffer.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        let piece = buffer.get(..at.unwrap_or(buffer.len())).unwrap_or_default();
        line.text.extend_from_slice(piece);
        let terminator = at.and_then(|at| buffer.get(at)).copied();
        let used = piece.len() + usize::from(terminator.is_some());
        reader.consume(used);
        match terminator {
            None => {}
            Some(b'\n') => {
                line.end = b"\n";
                return Ok(true);
            }
            Some(_) => {
                // CR LF may be cut by the buffer's end: refill before looking at the next byte.
                let pair = reader.fill_buf()?.first() == Some(&b'\n');
                if pair {
                    reader.consume(1);
                }
                line.end = if pair { b"\r\n" } else { b"\r" };
                return Ok(true);
            }
        }
    }
}
