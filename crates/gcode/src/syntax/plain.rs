//! The path of most bytes: words of a letter and a literal, read without going through the grammar.
//!
//! What is found here is what the grammar would have found; anything else is left to it from the
//! word on.

use super::block::{Block, Text, Value, Word};
use super::number::{literal, skip};
use crate::limits::Limits;

/// Whether a number goes on after blanks, or has an exponent.
#[inline(always)]
fn goes_on(tail: &[u8], next: &[u8]) -> bool {
    match next.first() {
        Some(b'0'..=b'9' | b'.') => true,
        Some(b'E' | b'e') => next.len() == tail.len(),
        _ => false,
    }
}

/// A literal at the start of the input; none if the grammar has to look at it.
pub(crate) fn number(input: &[u8]) -> Option<(&[u8], f64)> {
    literal(input).filter(|(tail, _)| !goes_on(tail, skip(tail)))
}

/// Takes plain words off `input`, the end of a line of `length` bytes, up to the first item that is
/// not one.
pub(crate) fn words<'a>(
    input: &'a [u8],
    length: usize,
    block: &mut Block,
    limits: &Limits,
) -> &'a [u8] {
    let mut rest = skip(input);
    let (mut lower, mut glued, mut touches) = (0, false, false);
    let mut room = limits
        .words
        .saturating_sub(block.words.len() + block.settings.len());
    while let [first, after @ ..] = rest {
        let letter = first & !0x20;
        if !letter.is_ascii_uppercase() || matches!(letter, b'N' | b'O') || room == 0 {
            break;
        }
        let Some((tail, value)) = literal(after) else {
            break;
        };
        let next = skip(tail);
        if goes_on(tail, next) {
            break;
        }
        let text = Text {
            start: (length - rest.len()) as u32,
            len: (rest.len() - tail.len()) as u32,
        };
        block.words.push(Word {
            letter,
            value: Value::Number(value),
            text,
        });
        room -= 1;
        lower |= first & 0x20;
        glued |= touches;
        touches = next.len() == tail.len();
        rest = next;
    }
    block.lower_case |= lower != 0;
    block.glued |= glued;
    rest
}
