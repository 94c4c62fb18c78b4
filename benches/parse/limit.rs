//! Loops without grammar, spans or diagnostics: what there is to reach.

use nom::IResult;
use nom::bytes::complete::{take_till, take_while};
use nom::number::complete::double;

const POWERS: [f64; 16] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
];

/// By hand: digits to an integer, one exact power of ten. The sum of all values.
pub(crate) fn by_hand(text: &[u8]) -> f64 {
    let mut sum = 0.0;
    let mut at = 0;
    while let Some(&byte) = text.get(at) {
        at += 1;
        if byte == b'(' {
            at += text[at..]
                .iter()
                .position(|byte| *byte == b')')
                .unwrap_or(0);
        }
        if !byte.is_ascii_alphabetic() {
            continue;
        }
        let negative = text.get(at) == Some(&b'-');
        at += usize::from(negative);
        let (mut mantissa, mut fraction, mut after_point) = (0u64, 0, 0);
        while let Some(&byte) = text.get(at) {
            if byte.is_ascii_digit() {
                mantissa = mantissa
                    .wrapping_mul(10)
                    .wrapping_add(u64::from(byte - b'0'));
                fraction += after_point;
            } else if byte == b'.' {
                after_point = 1;
            } else {
                break;
            }
            at += 1;
        }
        let value = mantissa as f64 / POWERS[fraction & 15];
        sum += if negative { -value } else { value };
    }
    sum
}

/// nom, with a number parser of choice: a letter and its value, everything else is passed over.
fn by_nom(text: &[u8], number: impl Fn(&[u8]) -> IResult<&[u8], f64>) -> f64 {
    let mut sum = 0.0;
    let mut rest = text;
    while let Some((&first, after)) = rest.split_first() {
        rest = after;
        if first == b'(' {
            rest = take_till::<_, _, nom::error::Error<&[u8]>>(|byte| byte == b')')(after)
                .map_or(after, |(rest, _)| rest);
        } else if first.is_ascii_alphabetic()
            && let Ok((after, value)) = number(after)
        {
            sum += value;
            rest = after;
        }
    }
    sum
}

/// nom with its own numbers.
pub(crate) fn nom_double(text: &[u8]) -> f64 {
    by_nom(text, |input| double(input))
}

/// nom with fast-float2.
pub(crate) fn nom_fast_float(text: &[u8]) -> f64 {
    by_nom(text, |input| {
        let (rest, digits) =
            take_while(|byte: u8| byte.is_ascii_digit() || matches!(byte, b'-' | b'.'))(input)?;
        fast_float2::parse(digits)
            .map(|value| (rest, value))
            .map_err(|_| {
                nom::Err::Error(nom::error::Error::new(input, nom::error::ErrorKind::Float))
            })
    })
}
