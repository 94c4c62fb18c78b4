//! Names of operators and functions.

use super::block::{Binary, Unary};
use nom::branch::alt;
use nom::bytes::complete::{tag, tag_no_case};
use nom::combinator::value;
use nom::{IResult, Parser};

/// An alternative that was tried: why it is none is not asked for, and costs nothing.
pub(super) type Tried<'a, T> = IResult<&'a [u8], T, ()>;

/// The first byte decides between symbols and words, which keeps what is not an operator cheap.
pub(super) fn binary(input: &[u8]) -> Tried<'_, Binary> {
    match input.first() {
        Some(b'*' | b'/' | b'+' | b'-') => alt((
            value(Binary::Power, tag(&b"**"[..])),
            value(Binary::Times, tag(&b"*"[..])),
            value(Binary::Divide, tag(&b"/"[..])),
            value(Binary::Plus, tag(&b"+"[..])),
            value(Binary::Minus, tag(&b"-"[..])),
        ))
        .parse(input),
        Some(first) if first.is_ascii_alphabetic() => alt((
            value(Binary::Modulo, tag_no_case(&b"mod"[..])),
            value(Binary::And, tag_no_case(&b"and"[..])),
            value(Binary::Xor, tag_no_case(&b"xor"[..])),
            value(Binary::Or, tag_no_case(&b"or"[..])),
            value(Binary::Equal, tag_no_case(&b"eq"[..])),
            value(Binary::NotEqual, tag_no_case(&b"ne"[..])),
            value(Binary::GreaterEqual, tag_no_case(&b"ge"[..])),
            value(Binary::Greater, tag_no_case(&b"gt"[..])),
            value(Binary::LessEqual, tag_no_case(&b"le"[..])),
            value(Binary::Less, tag_no_case(&b"lt"[..])),
        ))
        .parse(input),
        _ => Err(nom::Err::Error(())),
    }
}

pub(super) fn function(input: &[u8]) -> Tried<'_, Unary> {
    alt((
        alt((
            value(Unary::Abs, tag_no_case(&b"abs"[..])),
            value(Unary::Acos, tag_no_case(&b"acos"[..])),
            value(Unary::Asin, tag_no_case(&b"asin"[..])),
            value(Unary::Cos, tag_no_case(&b"cos"[..])),
            value(Unary::Exp, tag_no_case(&b"exp"[..])),
            value(Unary::Fix, tag_no_case(&b"fix"[..])),
        )),
        alt((
            value(Unary::Fup, tag_no_case(&b"fup"[..])),
            value(Unary::Ln, tag_no_case(&b"ln"[..])),
            value(Unary::Round, tag_no_case(&b"round"[..])),
            value(Unary::Sin, tag_no_case(&b"sin"[..])),
            value(Unary::Sqrt, tag_no_case(&b"sqrt"[..])),
            value(Unary::Tan, tag_no_case(&b"tan"[..])),
        )),
    ))
    .parse(input)
}
