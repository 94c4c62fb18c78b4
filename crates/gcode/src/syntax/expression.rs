//! Values and expressions, by nom, into postfix code.
//!
//! A sign binds tighter than any operator (`-2**2` is 4); operators of equal precedence go from
//! left to right.

use super::block::{Binary, Block, Op, Parsed, Target, Text, Unary, Value, fail};
use super::number::{number, skip};
use crate::problem::Problem;
use nom::branch::alt;
use nom::bytes::complete::{tag, tag_no_case, take_while1};
use nom::combinator::value;
use nom::{IResult, Parser};

/// Where expressions put their code and names, and how deep they may nest.
pub(crate) struct PostfixCode<'a> {
    pub(crate) ops: &'a mut Vec<Op>,
    pub(crate) names: &'a mut Vec<u8>,
    pub(crate) depth: usize,
}

impl<'a> PostfixCode<'a> {
    /// Code that is added to that of a block.
    pub(crate) fn of(block: &'a mut Block, depth: usize) -> PostfixCode<'a> {
        PostfixCode {
            ops: &mut block.ops,
            names: &mut block.names,
            depth,
        }
    }
}

/// A value: a literal stays one, anything else becomes code.
pub(crate) fn word_value<'a>(input: &'a [u8], code: &mut PostfixCode<'_>) -> Parsed<'a, Value> {
    let input = skip(input);
    // Most values are literals and need no code.
    if let [b'0'..=b'9' | b'.', ..] | [b'+' | b'-', b'0'..=b'9' | b'.', ..] = input {
        let (rest, literal) = number(input)?;
        return Ok((rest, Value::Number(literal)));
    }
    let from = code.ops.len() as u32;
    let (rest, ()) = operand(input, code, code.depth)?;
    // A literal behind signs or brackets folds into a literal.
    if let [Op::Push(literal)] = code.ops.get(from as usize..).unwrap_or_default() {
        let literal = *literal;
        code.ops.truncate(from as usize);
        return Ok((rest, Value::Number(literal)));
    }
    Ok((rest, Value::Ops(from, code.ops.len() as u32)))
}

/// `[ expression ]` as a value.
pub(crate) fn bracket_value<'a>(input: &'a [u8], code: &mut PostfixCode<'_>) -> Parsed<'a, Value> {
    let from = code.ops.len() as u32;
    let (rest, ()) = bracket(input, code, code.depth)?;
    Ok((rest, Value::Ops(from, code.ops.len() as u32)))
}

/// An expression with or without brackets around it, and whether an operator stood outside
/// brackets.
pub(crate) fn bare_value<'a>(
    input: &'a [u8],
    code: &mut PostfixCode<'_>,
) -> Parsed<'a, (Value, bool)> {
    let from = code.ops.len();
    let (rest, ()) = operand(input, code, code.depth)?;
    let first = code.ops.len();
    let (rest, ()) = operations(rest, code, code.depth, 0)?;
    Ok((
        rest,
        (
            Value::Ops(from as u32, code.ops.len() as u32),
            code.ops.len() > first,
        ),
    ))
}

/// The target of a setting with its `#` and `=`: the rest is its value.
pub(super) fn target<'a>(input: &'a [u8], code: &mut PostfixCode<'_>) -> Parsed<'a, Target> {
    let after = skip(input.get(1..).unwrap_or_default());
    let (rest, target) = if after.first() == Some(&b'<') {
        let (rest, text) = name(after, code.names)?;
        (rest, Target::Named(text))
    } else {
        let (rest, value) = word_value(after, code)?;
        (rest, Target::Numbered(value))
    };
    match skip(rest).split_first() {
        Some((b'=', rest)) => Ok((rest, target)),
        _ => expected(rest, "= after the parameter"),
    }
}

fn deeper<T>(
    input: &[u8],
    code: &PostfixCode<'_>,
    depth: usize,
) -> Result<usize, nom::Err<super::Fault>> {
    match depth.checked_sub(1) {
        Some(left) => Ok(left),
        None => fail::<T>(input, Problem::TooDeep { limit: code.depth }).map(|_| 0),
    }
}

/// A literal, parameter, bracket or function call.
fn operand<'a>(input: &'a [u8], code: &mut PostfixCode<'_>, depth: usize) -> Parsed<'a, ()> {
    let input = skip(input);
    match input {
        [b'[', ..] => bracket(input, code, depth),
        [b'#', after @ ..] => {
            let depth = deeper::<()>(input, code, depth)?;
            parameter(after, code, depth)
        }
        // A sign before a digit belongs to the literal; before anything else it is an operation.
        [sign @ (b'+' | b'-'), after @ ..]
            if !matches!(skip(after).first(), Some(b'0'..=b'9' | b'.')) =>
        {
            let depth = deeper::<()>(input, code, depth)?;
            let (rest, ()) = operand(after, code, depth)?;
            if *sign == b'-' {
                negate(code.ops);
            }
            Ok((rest, ()))
        }
        [first, ..] if first.is_ascii_alphabetic() => call(input, code, depth),
        _ => {
            let (rest, literal) = number(input)?;
            code.ops.push(Op::Push(literal));
            Ok((rest, ()))
        }
    }
}

/// Negates what was pushed last; a literal at once.
fn negate(ops: &mut Vec<Op>) {
    if let Some(Op::Push(literal)) = ops.last_mut() {
        *literal = -*literal;
    } else {
        ops.push(Op::Negate);
    }
}

/// What follows `#`: a name or a value that is the parameter's number.
fn parameter<'a>(input: &'a [u8], code: &mut PostfixCode<'_>, depth: usize) -> Parsed<'a, ()> {
    let input = skip(input);
    if input.first() == Some(&b'<') {
        let (rest, text) = name(input, code.names)?;
        code.ops.push(Op::Named(text));
        return Ok((rest, ()));
    }
    let (rest, ()) = operand(input, code, depth)?;
    code.ops.push(Op::Parameter);
    Ok((rest, ()))
}

/// `<name>`, put into `names` in lower case and without blanks.
pub(crate) fn name<'a>(input: &'a [u8], names: &mut Vec<u8>) -> Parsed<'a, Text> {
    let (rest, _) = tag(&b"<"[..])(input)?;
    let (rest, inside) = take_while1(|byte: u8| byte != b'>' && byte != 0)
        .parse(rest)
        .or_else(|_: nom::Err<super::Fault>| expected(rest, "a name"))?;
    if rest.first() != Some(&b'>') {
        return expected(input, "> after the name");
    }
    // `#<Some Name>` and `#<somename>` are the same parameter.
    let start = names.len() as u32;
    names.extend(
        inside
            .iter()
            .filter(|byte| !matches!(byte, b' ' | b'\t'))
            .map(u8::to_ascii_lowercase),
    );
    let text = Text {
        start,
        len: names.len() as u32 - start,
    };
    if text.len == 0 {
        return expected(input, "a name");
    }
    Ok((rest.get(1..).unwrap_or_default(), text))
}

pub(crate) fn expected<'a, T>(input: &'a [u8], expected: &'static str) -> Parsed<'a, T> {
    fail(input, Problem::Expected { expected })
}

/// `[ expression ]`.
fn bracket<'a>(input: &'a [u8], code: &mut PostfixCode<'_>, depth: usize) -> Parsed<'a, ()> {
    let input = skip(input);
    let Some((b'[', inside)) = input.split_first() else {
        return expected(input, "[");
    };
    let depth = deeper::<()>(input, code, depth)?;
    let (rest, ()) = operand(inside, code, depth)?;
    let (rest, ()) = operations(rest, code, depth, 0)?;
    match skip(rest) {
        [b']', after @ ..] => Ok((after, ())),
        [] => expected(rest, "]"),
        [first, ..] if first.is_ascii_alphabetic() => unknown(skip(rest)),
        other => expected(other, "an operator or ]"),
    }
}

/// Operators of at least a precedence with their right operands.
fn operations<'a>(
    mut input: &'a [u8],
    code: &mut PostfixCode<'_>,
    depth: usize,
    least: u8,
) -> Parsed<'a, ()> {
    loop {
        let at = skip(input);
        let Ok((after, operator)) = binary(at) else {
            return Ok((at, ()));
        };
        // Precedence climbing: an operator takes everything to its right that binds tighter.
        let precedence = operator.precedence();
        if precedence < least {
            return Ok((at, ()));
        }
        let (rest, ()) = operand(after, code, depth)?;
        let (rest, ()) = operations(rest, code, depth, precedence + 1)?;
        code.ops.push(Op::Binary(operator));
        input = rest;
    }
}

/// A function with its argument in brackets.
fn call<'a>(input: &'a [u8], code: &mut PostfixCode<'_>, depth: usize) -> Parsed<'a, ()> {
    // EXISTS takes a parameter, not its value; ATAN has two arguments in two brackets.
    if let Ok((rest, _)) = keyword(input, b"exists") {
        return exists(rest, code, depth);
    }
    if let Ok((rest, _)) = keyword(input, b"atan") {
        let (rest, ()) = bracket(rest, code, depth)?;
        let Some((b'/', rest)) = skip(rest).split_first() else {
            return expected(rest, "/ and the second argument of ATAN");
        };
        let (rest, ()) = bracket(rest, code, depth)?;
        code.ops.push(Op::Atan);
        return Ok((rest, ()));
    }
    let Ok((rest, function)) = function(input) else {
        return unknown(input);
    };
    let (rest, ()) = bracket(rest, code, depth)?;
    code.ops.push(Op::Unary(function));
    Ok((rest, ()))
}

fn keyword<'a>(input: &'a [u8], word: &'static [u8]) -> Tried<'a, &'a [u8]> {
    tag_no_case(word)(input)
}

/// `EXISTS[#<name>]` or `EXISTS[#5]`, after the function's name.
fn exists<'a>(input: &'a [u8], code: &mut PostfixCode<'_>, depth: usize) -> Parsed<'a, ()> {
    let Some((b'[', rest)) = skip(input).split_first() else {
        return expected(input, "[");
    };
    let Some((b'#', rest)) = skip(rest).split_first() else {
        return expected(rest, "a parameter as the argument of EXISTS");
    };
    // By name, or by a number that may be computed.
    let rest = if skip(rest).first() == Some(&b'<') {
        let (rest, text) = name(skip(rest), code.names)?;
        code.ops.push(Op::Exists(text));
        rest
    } else {
        let depth = deeper::<()>(rest, code, depth)?;
        let (rest, ()) = operand(rest, code, depth)?;
        code.ops.push(Op::ExistsNumber);
        rest
    };
    match skip(rest).split_first() {
        Some((b']', rest)) => Ok((rest, ())),
        _ => expected(rest, "]"),
    }
}

#[cold]
fn unknown<T>(input: &[u8]) -> Parsed<'_, T> {
    let name: String = input
        .iter()
        .take_while(|byte| byte.is_ascii_alphabetic())
        .take(20)
        .map(|&byte| char::from(byte))
        .collect();
    // A single letter is the next word: what is missing is this one's number.
    if name.len() <= 1 {
        fail(
            input,
            Problem::MissingNumber {
                after: "the letter or operator".to_owned(),
            },
        )
    } else {
        fail(input, Problem::UnknownName { name })
    }
}

/// Result of an alternative; its error carries no reason and costs nothing.
pub(super) type Tried<'a, T> = IResult<&'a [u8], T, ()>;

/// A binary operator. The first byte decides between symbols and words, so that the end of an
/// expression is found without trying all of them.
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
