//! Whether a program refers to its own line numbers.

use crate::raw_lines::{RawLine, read_line};
use std::io::{self, BufRead};

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
