//! What only looks like a number: a decimal comma, the letter O for 0, dashes and digits of
//! typesetting; and files in UTF-16. Looked at only where a line has a fault.

use super::block::{Block, Text};
use super::parse::parse_block;
use crate::limits::Limits;
use crate::problem::Problem;

/// Most characters of an item that a message shows.
const SHOWN_CHARACTERS: usize = 40;
/// Digits between two commas that group thousands.
const GROUPED_DIGITS: usize = 3;

/// A character that stands for another one, and what it is.
fn meant(symbol: char, inside: bool) -> Option<(char, &'static str)> {
    Some(match symbol {
        ',' if inside => ('.', "a decimal comma"),
        'o' | 'O' if inside => ('0', "the letter O"),
        // Hyphens, dashes and the minus sign of mathematics.
        '\u{2010}'..='\u{2015}' | '\u{2212}' | '\u{fe58}' | '\u{fe63}' | '\u{ff0d}' => {
            ('-', "a dash of typesetting")
        }
        '\u{ff0b}' => ('+', "a full-width character"),
        '\u{ff0e}' => ('.', "a full-width character"),
        '\u{ff0c}' => ('.', "a decimal comma"),
        '\u{ff10}'..='\u{ff19}' | '\u{ff21}'..='\u{ff3a}' | '\u{ff41}'..='\u{ff5a}' => {
            // Full-width forms lie 0xfee0 above their ASCII characters.
            (
                char::from_u32(symbol as u32 - 0xfee0)?,
                "a full-width character",
            )
        }
        '\u{a0}' | '\u{2007}' | '\u{2009}' | '\u{202f}' | '\u{3000}' => {
            (' ', "a blank of typesetting")
        }
        _ => return None,
    })
}

/// Whether a byte may be part of a number as people write it.
const fn in_number(byte: u8) -> bool {
    matches!(byte, b'0'..=b'9' | b'.' | b',' | b'o' | b'O') || !byte.is_ascii()
}

/// The item about a byte of the line: a number as people write it, with the letter before it.
fn item(line: &[u8], at: usize) -> (usize, usize) {
    let before = line.get(..at).unwrap_or_default();
    let mut start = at
        - before
            .iter()
            .rev()
            .take_while(|byte| in_number(**byte))
            .count();
    for letter in [false, true] {
        // Its sign, then its letter.
        let is_part = |byte: u8| {
            if letter {
                byte.is_ascii_alphabetic()
            } else {
                matches!(byte, b'+' | b'-')
            }
        };
        if start > 0 && line.get(start - 1).is_some_and(|byte| is_part(*byte)) {
            start -= 1;
        }
    }
    let after = line.get(at..).unwrap_or_default();
    (
        start,
        at + after.iter().take_while(|byte| in_number(**byte)).count(),
    )
}

/// What is wrong with an item that only looks right, and where it stands. It is told only if the line
/// can be read further with what is meant in its place.
#[cold]
pub(crate) fn look_alike(line: &[u8], at: usize, limits: &Limits) -> Option<(Problem, Text)> {
    let (start, end) = item(line, at);
    let text = std::str::from_utf8(line.get(start..end)?).ok()?;
    let (mut mended, mut what) = (String::new(), None);
    for symbol in text.chars() {
        let (symbol, found) = match meant(symbol, !mended.is_empty()) {
            Some((symbol, found)) => (symbol, Some(found)),
            None => (symbol, None),
        };
        mended.push(symbol);
        what = what.or(found);
    }
    let what = what?;
    // The proof: with it the line has no fault any more, or one behind this item.
    let behind = line.len() - end;
    let tried = [line.get(..start)?, mended.as_bytes(), line.get(end..)?].concat();
    if let Err(fault) = parse_block(&tried, &mut Block::default(), limits)
        && fault.rest >= behind.max(1)
    {
        return None;
    }
    let mut meant = mended.trim().to_owned();
    // 1,000 may be a thousand: both are named.
    if let Some((whole, digits)) = text.split_once(',')
        && digits.len() == GROUPED_DIGITS
        && digits.bytes().all(|byte| byte.is_ascii_digit())
    {
        meant = format!("{meant}, or {whole}{digits} if the comma groups thousands");
    }
    let text = Text {
        start: start as u32,
        len: (end - start) as u32,
    };
    let shown = String::from_utf8_lossy(line.get(start..end)?);
    Some((
        Problem::LookAlike {
            what,
            text: shown.chars().take(SHOWN_CHARACTERS).collect(),
            meant,
        },
        text,
    ))
}

/// The character outside ASCII at a byte of the line.
#[cold]
pub(crate) fn symbol(line: &[u8], at: usize) -> Option<char> {
    let rest = line.get(at..)?;
    let length = match rest.first()? {
        0xc2..=0xdf => 2,
        0xe0..=0xef => 3,
        0xf0..=0xf4 => 4,
        _ => return None,
    };
    std::str::from_utf8(rest.get(..length)?)
        .ok()?
        .chars()
        .next()
}

/// Bytes of the first line that show whether a file is in UTF-16.
const SHOWING_BYTES: usize = 16;

/// Whether the first line of a file is in UTF-16: its mark and a NUL, or every second byte is NUL.
#[cold]
pub(crate) fn is_utf16(line: &[u8]) -> bool {
    let head = line
        .get(..line.len().min(SHOWING_BYTES))
        .unwrap_or_default();
    let all_nul = |from: usize| head.iter().skip(from).step_by(2).all(|byte| *byte == 0);
    let any_text = head.iter().any(|byte| *byte != 0);
    // The mark alone may be chance: the high bytes of a text in Latin letters are NUL.
    (matches!(head, [0xff, 0xfe, ..] | [0xfe, 0xff, ..]) && head.contains(&0))
        || (head.len() >= 4 && any_text && (all_nul(0) || all_nul(1)))
}
