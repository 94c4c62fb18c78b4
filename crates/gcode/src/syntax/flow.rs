//! O-lines: a label, a keyword and its arguments.

use super::block::{Block, Keyword, Label};
use super::block::{Parsed, fail};
use super::expression::{PostfixCode, bracket_value, name, word_value};
use super::number::skip;
use crate::problem::Problem;

/// Longest first, so that none hides another.
const KEYWORDS: [(&[u8], Keyword); 15] = [
    (b"endrepeat", Keyword::EndRepeat),
    (b"endwhile", Keyword::EndWhile),
    (b"continue", Keyword::Continue),
    (b"elseif", Keyword::ElseIf),
    (b"endsub", Keyword::EndSub),
    (b"return", Keyword::Return),
    (b"repeat", Keyword::Repeat),
    (b"endif", Keyword::EndIf),
    (b"while", Keyword::While),
    (b"break", Keyword::Break),
    (b"call", Keyword::Call),
    (b"else", Keyword::Else),
    (b"sub", Keyword::Sub),
    (b"do", Keyword::Do),
    (b"if", Keyword::If),
];

/// The rest of an O-line after its O; `line` is the whole line, for the places of names.
pub(crate) fn flow_line<'a>(input: &'a [u8], block: &mut Block, limit: usize) -> Parsed<'a, ()> {
    let (rest, label) = label(skip(input), block, limit)?;
    let (mut rest, keyword) = keyword(skip(rest))?;
    block.flow = Some((label, keyword));
    while let [b'[', ..] = skip(rest) {
        // A call may set #1 to #30.
        if block.arguments.len() >= limit.max(30) {
            return fail(rest, Problem::TooManyWords { limit });
        }
        let Block {
            ops,
            names,
            arguments,
            ..
        } = block;
        let (after, value) = bracket_value(
            rest,
            &mut PostfixCode {
                ops,
                names,
                depth: limit,
            },
        )?;
        arguments.push(value);
        rest = after;
    }
    Ok((rest, ()))
}

fn label<'a>(input: &'a [u8], block: &mut Block, limit: usize) -> Parsed<'a, Label> {
    if input.first() == Some(&b'<') {
        let (rest, text) = name(input, &mut block.names)?;
        return Ok((rest, Label::Name(text)));
    }
    let Block { ops, names, .. } = block;
    let (rest, value) = word_value(
        input,
        &mut PostfixCode {
            ops,
            names,
            depth: limit,
        },
    )?;
    Ok((rest, Label::Number(value)))
}

/// The keyword, in any case and with blanks inside; a line that ends after its label has none.
fn keyword(input: &[u8]) -> Parsed<'_, Keyword> {
    // A label alone is a subroutine that ends with M99, or the program's own number.
    if matches!(input.first(), None | Some(b'(' | b';')) {
        return Ok((input, Keyword::Bare));
    }
    for (text, keyword) in KEYWORDS {
        if let Some(rest) = starts_with(input, text) {
            return Ok((rest, keyword));
        }
    }
    fail(
        input,
        Problem::Flow {
            message: "an O-word keyword (sub, call, if, while, ...) expected after the label"
                .to_owned(),
        },
    )
}

fn starts_with<'a>(input: &'a [u8], text: &[u8]) -> Option<&'a [u8]> {
    let mut rest = input;
    for &letter in text {
        // RS274/NGC allows blanks anywhere outside names and comments.
        let (first, after) = skip(rest).split_first()?;
        if first.to_ascii_lowercase() != letter {
            return None;
        }
        rest = after;
    }
    Some(rest)
}
