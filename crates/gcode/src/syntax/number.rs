//! Literal numbers, correctly rounded.

use super::block::{Parsed, fail};
use crate::problem::Problem;

/// Powers of ten that are exact in an f64.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];
/// Digits that always fit a u64.
const SAFE_DIGITS: usize = 19;
/// Integers up to here are exact in an f64.
const LARGEST_EXACT_INTEGER: u64 = 1 << 53;
const fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t')
}

/// The input after its blanks.
#[inline]
pub(crate) fn skip(mut input: &[u8]) -> &[u8] {
    while let [first, rest @ ..] = input {
        if !is_blank(*first) {
            break;
        }
        input = rest;
    }
    input
}

/// A number: sign, digits with at most one point, no exponent. Blanks may stand between its
/// characters.
///
/// The value is the f64 nearest to the decimal: up to 19 digits go through one exact integer and
/// one exact power of ten, whose quotient IEEE 754 rounds correctly; others through the standard
/// library.
pub(crate) fn number(input: &[u8]) -> Parsed<'_, f64> {
    match literal(input) {
        Some((rest, value)) if !matches!(skip(rest).first(), Some(b'0'..=b'9' | b'.')) => {
            Ok((rest, value))
        }
        _ => spread(input),
    }
}

/// A number without blanks whose digits and power of ten are exact in an f64, so that one division
/// rounds it correctly. It may go on after what is returned. Inlined because it is most of the time
/// that reading words takes.
#[inline(always)]
pub(crate) fn literal(input: &[u8]) -> Option<(&[u8], f64)> {
    let (negative, digits) = match input {
        [b'-', after @ ..] => (true, after),
        [b'+', after @ ..] => (false, after),
        _ => (false, input),
    };
    let (mut rest, mut mantissa) = integer(digits, 0);
    let mut count = digits.len() - rest.len();
    let mut fraction = 0;
    // Digits after the point go on in the same integer; their count is the power of ten.
    if let [b'.', after @ ..] = rest {
        (rest, mantissa) = integer(after, mantissa);
        fraction = after.len() - rest.len();
        count += fraction;
    }
    // Beyond these bounds integer or quotient would round: left to the standard library.
    if count == 0 || count > SAFE_DIGITS || mantissa > LARGEST_EXACT_INTEGER {
        return None;
    }
    // Both operands are exact, so that the quotient is the nearest f64 (Clinger 1990).
    let value = mantissa as f64 / POWERS.get(fraction)?;
    // The sign is set without a branch, which could not be predicted.
    Some((
        rest,
        f64::from_bits(value.to_bits() | u64::from(negative) << 63),
    ))
}

/// Appends digits to a mantissa, which wraps if there are too many.
#[inline(always)]
fn integer(mut input: &[u8], mut mantissa: u64) -> (&[u8], u64) {
    while let [byte, after @ ..] = input {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        input = after;
    }
    (input, mantissa)
}

/// The long way: a number with blanks inside, many digits, or something wrong with it.
#[cold]
fn spread(input: &[u8]) -> Parsed<'_, f64> {
    let mut text = String::new();
    let mut rest = input;
    loop {
        // The characters are gathered without their blanks.
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
        let after = if text.is_empty() {
            "the letter or operator".to_owned()
        } else {
            text
        };
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
        number(text.as_bytes())
            .ok()
            .filter(|(rest, _)| rest.is_empty())
            .map(|(_, value)| value)
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
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn the_nearest_f64(text in "[+-]?[0-9]{1,25}(\\.[0-9]{0,25})?") {
            let expected: f64 = text.parse().unwrap();
            prop_assert_eq!(value(&text).map(f64::to_bits), Some(expected.to_bits()));
        }

        /// Where one division is just possible, and just not any more.
        #[test]
        fn the_nearest_f64_about_the_largest_exact_integer(near in -2000i64..2000, scale in 0u32..3, point in 0usize..20, zeros in 0usize..6) {
            let digits = (((1i64 << 53) + near) * 10i64.pow(scale)).to_string();
            let at = digits.len().saturating_sub(point);
            let text = format!("{}{}.{}", "0".repeat(zeros), &digits[..at], &digits[at..]);
            prop_assert_eq!(value(&text).map(f64::to_bits), Some(text.parse::<f64>().unwrap().to_bits()));
        }

        /// The decimal half way between two neighbours, and the decimals beside it.
        #[test]
        fn ties_go_to_the_even_one(mantissa in (1u64 << 52)..(1 << 53), below in prop::sample::select(vec!["", "0001", "00000000000000000001"])) {
            // Multiples of 1/2 above 2^52 lie on or half way between neighbours.
            let text = format!("{mantissa}.5{below}");
            let up = !below.is_empty() || mantissa % 2 == 1;
            prop_assert_eq!(value(&text), Some((mantissa + u64::from(up)) as f64));
        }
    }
}
