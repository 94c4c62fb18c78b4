//! Literal numbers, correctly rounded.

use super::fault::{Parsed, fail};
use crate::problem::Problem;
use nom::bytes::complete::take_while;

/// Powers of ten that are exact in an f64.
const POWERS: [f64; 23] =
    [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22];
/// Digits that always fit a u64.
const SAFE_DIGITS: usize = 19;
/// Integers up to here are exact in an f64.
const EXACT: u64 = 1 << 53;

const fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t')
}

/// Skips blanks.
pub(crate) fn blanks(input: &[u8]) -> Parsed<'_, &[u8]> {
    take_while(is_blank)(input)
}

/// The input after its blanks.
pub(crate) fn skip(input: &[u8]) -> &[u8] {
    match input {
        [first, ..] if is_blank(*first) => blanks(input).map_or(input, |(rest, _)| rest),
        _ => input,
    }
}

/// A number: sign, digits with at most one point, no exponent. Blanks may stand between its characters.
///
/// The value is the f64 nearest to the decimal: up to 19 digits go through one exact integer and one exact power of ten,
/// whose quotient IEEE 754 rounds correctly; others through the standard library.
pub(crate) fn number(input: &[u8]) -> Parsed<'_, f64> {
    let (mut at, negative) = match input.first() {
        Some(b'-') => (1, true),
        Some(b'+') => (1, false),
        _ => (0, false),
    };
    let (mut mantissa, mut digits, mut point) = (0u64, 0usize, None);
    while let Some(&byte) = input.get(at) {
        if byte.is_ascii_digit() {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
            digits += 1;
        } else if byte == b'.' && point.is_none() {
            point = Some(digits);
        } else {
            break;
        }
        at += 1;
    }
    let rest = input.get(at..).unwrap_or_default();
    let fraction = point.map_or(0, |before| digits - before);
    let continues = matches!(rest.first(), Some(b' ' | b'\t' | b'.')) && matches!(skip(rest).first(), Some(b'0'..=b'9' | b'.'));
    if continues || digits == 0 || digits > SAFE_DIGITS || mantissa > EXACT {
        return spread(input);
    }
    let value = POWERS.get(fraction).map_or(0.0, |power| mantissa as f64 / power);
    Ok((rest, if negative { -value } else { value }))
}

/// The long way: a number with blanks inside, many digits, or something wrong with it.
#[cold]
fn spread(input: &[u8]) -> Parsed<'_, f64> {
    let mut text = String::new();
    let mut rest = input;
    loop {
        match skip(rest) {
            [sign @ (b'+' | b'-'), after @ ..] if text.is_empty() => {
                text.push(char::from(*sign));
                rest = after;
            }
            [digit @ (b'0'..=b'9' | b'.'), after @ ..] => {
                text.push(char::from(*digit));
                rest = after;
            }
            _ => break,
        }
    }
    if !text.bytes().any(|byte| byte.is_ascii_digit()) {
        let after = if text.is_empty() { "the letter or operator".to_owned() } else { text };
        return fail(input, Problem::MissingNumber { after });
    }
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok((rest, value)),
        _ => {
            text.truncate(40);
            fail(input, Problem::BadNumber { text })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn value(text: &str) -> Option<f64> {
        number(text.as_bytes()).ok().filter(|(rest, _)| rest.is_empty()).map(|(_, value)| value)
    }

    #[test]
    fn blanks_may_stand_inside() {
        assert_eq!(value("+0. 12 34"), Some(0.1234));
        assert_eq!(value("1 0 . 5"), Some(10.5));
        assert_eq!(value("-.5"), Some(-0.5));
        assert_eq!(value("7."), Some(7.0));
    }

    #[test]
    fn what_is_not_a_number_is_refused() {
        for text in ["", ".", "-", "1.2.3", "1 . 2 . 3", "--3"] {
            assert_eq!(value(text), None, "{text}");
        }
        assert_eq!(value(&"9".repeat(400)), None);
    }

    proptest! {
        #[test]
        fn the_nearest_f64(text in "[+-]?[0-9]{1,25}(\\.[0-9]{0,25})?") {
            let expected: f64 = text.parse().unwrap();
            prop_assert_eq!(value(&text).map(f64::to_bits), Some(expected.to_bits()));
        }
    }
}
