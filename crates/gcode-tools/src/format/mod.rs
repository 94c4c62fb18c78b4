//! Programs in one style, without any change of what they do: blanks, case, indentation, line
//! numbers.
//!
//! Comments, numbers and the order of the words stay as they are. A line that the parser does not
//! understand, or that would mean anything else afterwards, is left alone byte for byte.

use crate::document::{RawLine, read_line};
use lostmotion_gcode::limits::Limits;
use lostmotion_gcode::syntax::{Block, Keyword, Label, Value};
use std::io::{self, BufRead, Write};

mod line;

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
const KEPT_CHANGES: usize = 20;
const MARK: &[u8] = b"\xef\xbb\xbf";

/// Formats a program line by line, in memory that does not grow with its length. Line ends stay as
/// they are.
///
/// ```
/// use lostmotion_gcode_tools::format::{FormatOptions, format};
///
/// let mut out = Vec::new();
/// let summary = format(&b"g1x10y5(rough)\n"[..], &FormatOptions::default(), &mut out)?;
/// assert_eq!(out, b"G1 X10 Y5 (rough)\n");
/// assert_eq!(summary.changed, 1);
/// # Ok::<(), std::io::Error>(())
/// ```
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
        // A byte order mark is no part of the first line and is written back as it was.
        let mark = if summary.lines == 1 && line.text.starts_with(MARK) {
            MARK
        } else {
            b""
        };
        let text = line.text.get(mark.len()..).unwrap_or_default();
        // A line that the formatter refuses is written back unchanged.
        let formatted = formatter.line(text);
        summary.left_alone += u64::from(formatted.is_none());
        let formatted = formatted.as_deref().unwrap_or(text);
        if formatted != text {
            summary.changed += 1;
            if summary.changes.len() < KEPT_CHANGES {
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

/// What is open.
#[derive(Clone, Debug, Default)]
struct Indent {
    open: Vec<(String, bool)>,
}

/// Deeper levels are not shown.
const DEEPEST_INDENT: usize = 40;

impl Indent {
    /// The level of a line; what it opens counts for the next.
    fn level(&mut self, block: &Block) -> usize {
        let Some((label, keyword)) = block.flow else {
            return self.shown();
        };
        let name = match label {
            Label::Name(text) => String::from_utf8_lossy(block.name(text)).into_owned(),
            Label::Number(Value::Number(number)) => format!("{number}"),
            Label::Number(Value::Ops(..)) => String::new(),
        };
        // `while` ends a `do` of the same label; otherwise it opens a loop.
        let ends_do = keyword == Keyword::While
            && self
                .open
                .last()
                .is_some_and(|(open, is_do)| *is_do && *open == name);
        match keyword {
            Keyword::EndSub | Keyword::EndIf | Keyword::EndWhile | Keyword::EndRepeat => {
                self.open.pop();
                self.shown()
            }
            Keyword::While if ends_do => {
                self.open.pop();
                self.shown()
            }
            // Branches stand at the level of their `if`.
            Keyword::Else | Keyword::ElseIf => self.shown().saturating_sub(1),
            Keyword::Sub | Keyword::If | Keyword::While | Keyword::Do | Keyword::Repeat => {
                let level = self.shown();
                self.open.push((name, keyword == Keyword::Do));
                level
            }
            _ => self.shown(),
        }
    }

    fn shown(&self) -> usize {
        self.open.len().min(DEEPEST_INDENT)
    }
}

/// The first line, from 1, that refers to line numbers: GOTO, M99 P, or the contours of G70 to G73
/// by P and Q. Renumbering such a program, or removing its numbers, changes what it does.
///
/// # Errors
/// Those of the reader.
pub fn refers_to_line_numbers(mut source: impl BufRead) -> io::Result<Option<u64>> {
    let mut line = RawLine::default();
    let mut number = 0;
    while read_line(&mut source, &mut line)? {
        number += 1;
        let text = without_comments(&line.text);
        let has = |what: &str| text.contains(what);
        // Text search: a false alarm only keeps the old numbers, a miss would break the program.
        let contour = ["G70", "G71", "G72", "G73"].into_iter().any(has) && has("P") && has("Q");
        if has("GOTO") || (has("M99") && has("P")) || contour {
            return Ok(Some(number));
        }
    }
    Ok(None)
}

/// Upper case, without blanks, comments and names.
fn without_comments(line: &[u8]) -> String {
    let mut text = String::new();
    let mut closing = None;
    for &byte in line {
        // Inside a comment or name bytes are dropped up to the closing one.
        match (closing, byte) {
            (Some(end), _) if byte == end => closing = None,
            (Some(_), _) | (None, b' ' | b'\t') => {}
            (None, b'(') => closing = Some(b')'),
            (None, b'<') => closing = Some(b'>'),
            (None, b';') => break,
            (None, _) => text.push(char::from(byte.to_ascii_uppercase())),
        }
    }
    text
}
