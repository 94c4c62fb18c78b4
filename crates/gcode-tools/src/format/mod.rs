//! Programs in one style, without any change of what they do: blanks, case, indentation, line
//! numbers.
//!
//! Comments, numbers and the order of the words stay as they are. A line that the parser does not
//! understand, or that would mean anything else afterwards, is left alone byte for byte.

mod expression;
mod indent;
mod line;
mod refers;

pub use refers::refers_to_line_numbers;

use crate::raw_lines::{RawLine, read_line};
use indent::Indent;
use lostmotion_gcode::limits::Limits;
use lostmotion_gcode::syntax::Block;
use std::io::{self, BufRead, Write};

/// Case of letters outside comments and names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Case {
    /// `G1 X10`. O-words keep their case.
    #[default]
    Upper,
    /// `g1 x10`.
    Lower,
    /// As it is.
    Keep,
}

/// What becomes of line numbers (N). References to them are not followed: see
/// [`refers_to_line_numbers`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LineNumbers {
    /// They stay.
    #[default]
    Keep,
    /// They go.
    Remove,
    /// Every line with words gets a new one.
    Renumber {
        /// The first number, and the distance to the next.
        step: u32,
    },
}

/// A style.
#[derive(Clone, Debug, PartialEq)]
pub struct FormatOptions {
    /// Case of letters.
    pub case: Case,
    /// Blanks for each level of O-words.
    pub indent: usize,
    /// Line numbers.
    pub line_numbers: LineNumbers,
    /// Bounds of lines that are understood.
    pub limits: Limits,
}

impl Default for FormatOptions {
    fn default() -> FormatOptions {
        FormatOptions {
            case: Case::default(),
            indent: 2,
            line_numbers: LineNumbers::default(),
            limits: Limits::default(),
        }
    }
}

/// A line that has been changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// Its number, from 1.
    pub line: u64,
    /// What it was.
    pub before: Vec<u8>,
    /// What it is.
    pub after: Vec<u8>,
}

/// What formatting did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FormatSummary {
    /// Lines of the program.
    pub lines: u64,
    /// Lines that were changed.
    pub changed: u64,
    /// Lines that were left alone because they could not be understood.
    pub left_alone: u64,
    /// The first changes.
    pub changes: Vec<Change>,
}

/// Changes that a summary keeps.
const CHANGES: usize = 20;
const MARK: &[u8] = b"\xef\xbb\xbf";

/// Formats a program line by line, in memory that does not grow with its length. Line ends stay as
/// they are.
///
/// # Errors
/// Those of the reader and the writer.
pub fn format(
    mut source: impl BufRead,
    options: &FormatOptions,
    out: &mut impl Write,
) -> io::Result<FormatSummary> {
    let mut formatter = Formatter {
        options,
        block: Block::default(),
        indent: Indent::default(),
        number: 0,
    };
    let mut summary = FormatSummary::default();
    let mut line = RawLine::default();
    while read_line(&mut source, &mut line)? {
        summary.lines += 1;
        let mark = if summary.lines == 1 && line.text.starts_with(MARK) {
            MARK
        } else {
            b""
        };
        let text = line.text.get(mark.len()..).unwrap_or_default();
        let formatted = formatter.line(text);
        summary.left_alone += u64::from(formatted.is_none());
        let formatted = formatted.as_deref().unwrap_or(text);
        if formatted != text {
            summary.changed += 1;
            if summary.changes.len() < CHANGES {
                summary.changes.push(Change {
                    line: summary.lines,
                    before: text.to_vec(),
                    after: formatted.to_vec(),
                });
            }
        }
        out.write_all(mark)?;
        out.write_all(formatted)?;
        out.write_all(line.end)?;
    }
    Ok(summary)
}

/// What has to be known from line to line.
struct Formatter<'a> {
    options: &'a FormatOptions,
    block: Block,
    indent: Indent,
    /// The last line number given.
    number: u64,
}
