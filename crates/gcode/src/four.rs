//! Numbers with four decimals, written fast.

use std::fmt::{self, Display, Formatter};

/// A number that is shown as `{:.4}` shows it.
///
/// Times 10,000 and rounded it is a whole number, whose digits are cheap. The product is off by
/// half a unit in its last place at most; where that could change the rounding, or the product is
/// too large, the standard library does it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Four(pub(crate) f64);

/// Products below this (2^43) are exact to 1/2048.
const LARGEST: f64 = 8_796_093_022_208.0;
/// Largest distance from a whole number at which the rounding is certain.
const CERTAIN: f64 = 0.5 - 1.0 / 1024.0;
/// Bytes: sign, up to 9 digits, point, 4 digits, and one to spare.
const SIZE: usize = 16;

impl Display for Four {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let scaled = self.0.abs() * 1e4;
        let whole = (scaled + 0.5) as u64;
        if scaled.is_nan() || scaled >= LARGEST || (scaled - whole as f64).abs() > CERTAIN {
            return write!(f, "{:.4}", self.0);
        }
        let mut text = [b'-'; SIZE];
        let start = put(&mut text, whole) - usize::from(self.0.is_sign_negative());
        let shown = text
            .get(start..)
            .and_then(|bytes| std::str::from_utf8(bytes).ok());
        f.write_str(shown.ok_or(fmt::Error)?)
    }
}

/// Puts ten-thousandths at the end of a text and gives where they begin; what lies before is left
/// as it is.
fn put(text: &mut [u8; SIZE], mut whole: u64) -> usize {
    let mut start = SIZE;
    for (index, slot) in text.iter_mut().enumerate().rev() {
        let place = SIZE - 1 - index;
        if place == 4 {
            *slot = b'.';
            continue;
        }
        *slot = b'0' + (whole % 10) as u8;
        whole /= 10;
        start = index;
        if place > 4 && whole == 0 {
            break;
        }
    }
    start
}

#[cfg(test)]
mod tests {
    use super::Four;
    use proptest::prelude::*;

    fn check(number: f64) {
        assert_eq!(
            Four(number).to_string(),
            format!("{number:.4}"),
            "{number:e}"
        );
    }

    #[test]
    fn borders_of_rounding_and_size_are_as_in_the_standard_library() {
        for number in [
            0.0,
            0.00005,
            0.00015,
            0.12345,
            0.99995,
            0.999_950_000_1,
            9.99995,
            1e-300,
            12345.67895,
            f64::MIN_POSITIVE,
        ] {
            for near in [number, number.next_up(), number.next_down(), -number] {
                check(near);
            }
        }
        for number in [
            879_609_302.220_7,
            879_609_302.220_8,
            879_609_302.3,
            1e9,
            1e22,
            f64::MAX,
            f64::INFINITY,
            f64::NAN,
        ] {
            check(number);
            check(-number);
        }
    }

    proptest! {
        #[test]
        fn all_numbers_are_as_in_the_standard_library(bits in any::<u64>(), small in -1e6..1e6, ten_thousandths in -2_000_000_000_i64..2_000_000_000) {
            check(f64::from_bits(bits));
            check(small);
            // Decimals as programs have them, and half way between.
            check(ten_thousandths as f64 / 1e4);
            check(ten_thousandths as f64 / 1e5);
            check((2 * ten_thousandths + 1) as f64 / 2e4);
        }
    }
}
