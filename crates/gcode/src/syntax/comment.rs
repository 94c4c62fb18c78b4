//! Comments in parentheses and after a semicolon.

use super::fault::{Parsed, fail};
use crate::problem::Problem;
use nom::bytes::complete::take_till;

/// What the opening parenthesis of the input encloses.
pub(crate) fn parenthesis(input: &[u8]) -> Parsed<'_, &[u8]> {
    let inside = input.get(1..).unwrap_or_default();
    let (rest, text) = take_till(|byte| matches!(byte, b'(' | b')' | 0))(inside)?;
    match rest.first() {
        Some(b')') => Ok((rest.get(1..).unwrap_or_default(), text)),
        Some(b'(') => fail(rest, Problem::NestedComment),
        Some(_) => fail(rest, Problem::Nul),
        None => fail(input, Problem::UnclosedComment),
    }
}

/// What stands after the semicolon of the input.
pub(crate) fn semicolon(input: &[u8]) -> Parsed<'_, &[u8]> {
    let inside = input.get(1..).unwrap_or_default();
    let (rest, text) = take_till(|byte| byte == 0)(inside)?;
    if rest.is_empty() {
        Ok((rest, text))
    } else {
        fail(rest, Problem::Nul)
    }
}
