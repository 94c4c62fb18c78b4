//! Numbers as text: fast fixed-point for large tables, and rounding for people.

/// Powers of ten that are exact in an `f64` and as integers.
const POWERS_OF_TEN: [u64; 16] = [
    1,
    10,
    100,
    1_000,
    10_000,
    100_000,
    1_000_000,
    10_000_000,
    100_000_000,
    1_000_000_000,
    10_000_000_000,
    100_000_000_000,
    1_000_000_000_000,
    10_000_000_000_000,
    100_000_000_000_000,
    1_000_000_000_000_000,
];

/// Largest magnitude that [`push_fixed`] writes by integer arithmetic: integers up to here are
/// exact.
const EXACT_INTEGERS_TO: f64 = 9_007_199_254_740_992.0;

/// Appends `value` with `decimals` (at most 15) digits after the point, `1.500`.
///
/// The last digit is rounded to nearest of the fraction times a power of ten in `f64`, which can
/// differ from the correctly rounded decimal by one unit only when the value lies within 1e-16 of
/// the middle between two. Minus zero is written without its sign; values that are not finite are
/// written as nothing (an empty cell).
pub fn push_fixed(out: &mut Vec<u8>, value: f64, decimals: usize) {
    if !value.is_finite() {
        return;
    }
    let decimals = decimals.min(POWERS_OF_TEN.len() - 1);
    let magnitude = value.abs();
    if magnitude >= EXACT_INTEGERS_TO {
        out.extend_from_slice(format!("{value:.decimals$}").as_bytes());
        return;
    }
    let scale = POWERS_OF_TEN[decimals];
    let mut whole = magnitude as u64;
    // The fraction of a double is exact; only its product with the power of ten is rounded.
    let mut fraction = ((magnitude - whole as f64) * scale as f64).round_ties_even() as u64;
    // 0.9996 with three decimals rounds up into the whole part.
    if fraction >= scale {
        whole += 1;
        fraction -= scale;
    }
    // The sign goes before digits that are not all 0: no -0.000.
    if value < 0.0 && (whole != 0 || fraction != 0) {
        out.push(b'-');
    }
    push_integer(out, whole);
    if decimals > 0 {
        out.push(b'.');
        push_padded(out, fraction, decimals);
    }
}

/// Appends an integer.
pub fn push_integer(out: &mut Vec<u8>, value: u64) {
    let mut width = 1;
    while width < 20 && value >= POWERS_OF_TEN.get(width).copied().unwrap_or(u64::MAX) {
        width += 1;
    }
    // Beyond the table of powers: rare, so the general way serves.
    if width > 15 {
        out.extend_from_slice(value.to_string().as_bytes());
    } else {
        push_padded(out, value, width);
    }
}

/// Appends `value` in exactly `width` digits (at most 20), with leading zeros.
fn push_padded(out: &mut Vec<u8>, mut value: u64, width: usize) {
    let mut digits = [b'0'; 20];
    for digit in digits[..width].iter_mut().rev() {
        *digit = b'0' + (value % 10) as u8;
        value /= 10;
    }
    out.extend_from_slice(&digits[..width]);
}

/// Appends a time given as a whole number of nanoseconds in s, with as few decimals (3, 6 or 9) as
/// a clock of this period needs.
pub fn push_seconds(out: &mut Vec<u8>, time_ns: u64, period_ns: u64) {
    const NS_PER_S: u64 = 1_000_000_000;
    push_integer(out, time_ns / NS_PER_S);
    out.push(b'.');
    // The coarsest decimal unit in which every tick is a whole number.
    let (unit, width) = if period_ns.is_multiple_of(1_000_000) {
        (1_000_000, 3)
    } else if period_ns.is_multiple_of(1_000) {
        (1_000, 6)
    } else {
        (1, 9)
    };
    push_padded(out, time_ns % NS_PER_S / unit, width);
}

/// A number with a fixed number of decimals, without a minus sign on what rounds to zero; `-` if it
/// is not finite.
pub fn fixed(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return "-".to_owned();
    }
    // What rounds to zero has no sign: -0.00 would look like an error to one side.
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|b| b == b'0' || b == b'.') => rest.to_owned(),
        _ => text,
    }
}

/// Decimals that are meaningful for micrometres or millidegrees of a magnitude.
pub fn error_decimals(magnitude: f64) -> usize {
    match magnitude {
        m if m < 100.0 => 2,
        m if m < 10_000.0 => 1,
        _ => 0,
    }
}

/// Magnitude from which on a number is written with an exponent. A choice: a million um is a metre.
const EXPONENT_MAGNITUDE: f64 = 1e6;

/// As [`fixed`], with an exponent from a million on: `3.63e7`.
pub fn compact(value: f64, decimals: usize) -> String {
    if value.is_finite() && value.abs() >= EXPONENT_MAGNITUDE {
        format!("{value:.2e}")
    } else {
        fixed(value, decimals)
    }
}

/// An error in um or mdeg for running text: 2 decimals below 100, 1 below 10 000, else none.
pub fn error(value: f64) -> String {
    compact(value, error_decimals(value.abs()))
}

/// A value that was given by people, with at most 6 decimals and no trailing zeros: `10`, `2.5`.
pub fn plain(value: f64) -> String {
    let text = fixed(value, 6);
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// A share in per cent for people: one decimal below 10 %, whole per cent above.
pub fn percent(ratio: f64) -> String {
    let value = ratio * 100.0;
    let decimals = if value.abs() < 10.0 { 1 } else { 0 };
    format!("{} %", compact(value, decimals))
}

/// A time in s for people: `0.420 s`, `12.3 s`, `10 min 5 s`, `2 h 3 min`.
pub fn duration(seconds: f64) -> String {
    if !seconds.is_finite() || seconds < 0.0 {
        return "-".to_owned();
    }
    let rounded = seconds.round() as u64;
    match seconds {
        // The bounds lie where rounding would add a digit: 10.000 s, 120.0 s.
        s if s < 9.9995 => format!("{s:.3} s"),
        s if s < 119.95 => format!("{s:.1} s"),
        _ if rounded < 7200 => format!("{} min {} s", rounded / 60, rounded % 60),
        _ => format!("{} h {} min", rounded / 3600, rounded % 3600 / 60),
    }
}

/// A duration with the one before: `61.3 s in place of 58.0 s`; `61.3 s, 12.5 ms longer` where both would read
/// alike, and `61.3 s, as before` where they are.
pub fn duration_in_place(after_s: f64, before_s: f64) -> String {
    let [after, before] = [after_s, before_s].map(duration);
    if after != before {
        return format!("{after} in place of {before}");
    }
    let more_ms = 1e3 * (after_s - before_s);
    // Microseconds are of rounding.
    if more_ms.is_nan() || more_ms.abs() < 1e-2 {
        return format!("{after}, as before");
    }
    let (size, unit) = if more_ms.abs() < 1e3 {
        (fixed(more_ms.abs(), 2), "ms")
    } else {
        (fixed(1e-3 * more_ms.abs(), 1), "s")
    };
    let way = if more_ms > 0.0 { "longer" } else { "shorter" };
    format!("{after}, {size} {unit} {way}")
}

/// A value cut to a number of decimals, as `f64`: the nearest number that prints that short.
pub fn round_to(value: f64, decimals: usize) -> f64 {
    let scale = POWERS_OF_TEN[decimals.min(POWERS_OF_TEN.len() - 1)] as f64;
    let scaled = (value * scale).round();
    // Beyond 2^53 the value has no decimals to cut. Adding 0 takes the sign off a negative zero.
    if scaled.abs() < EXACT_INTEGERS_TO {
        scaled / scale + 0.0
    } else {
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn written(value: f64, decimals: usize) -> String {
        let mut out = Vec::new();
        push_fixed(&mut out, value, decimals);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn fixed_point_of_chosen_values() {
        for (value, decimals, text) in [
            (0.0, 3, "0.000"),
            (-0.0, 3, "0.000"),
            (-1e-9, 3, "0.000"),
            (0.9999, 3, "1.000"),
            (-12.5, 1, "-12.5"),
            (1e15, 2, "1000000000000000.00"),
            (1e17, 1, "100000000000000000.0"),
            (7.0, 0, "7"),
            (f64::NAN, 3, ""),
            (f64::INFINITY, 3, ""),
        ] {
            assert_eq!(written(value, decimals), text);
        }
    }

    #[test]
    fn seconds_are_exact() {
        let text = |ns, period| {
            let mut out = Vec::new();
            push_seconds(&mut out, ns, period);
            String::from_utf8(out).unwrap()
        };
        assert_eq!(text(0, 1_000_000), "0.000");
        assert_eq!(text(3_600_001_000_000, 1_000_000), "3600.001");
        assert_eq!(text(250_000, 250_000), "0.000250");
        assert_eq!(text(62_500, 31_250), "0.000062500");
    }

    #[test]
    fn durations_and_shares_read_well() {
        assert_eq!(duration(0.42), "0.420 s");
        assert_eq!(duration(61.26), "61.3 s");
        assert_eq!(duration(605.0), "10 min 5 s");
        assert_eq!(duration(7384.0), "2 h 3 min");
        assert_eq!(duration_in_place(61.3, 58.0), "61.3 s in place of 58.0 s");
        assert_eq!(duration_in_place(61.26, 61.3), "61.3 s, 40.00 ms shorter");
        assert_eq!(duration_in_place(7390.0, 7384.0), "2 h 3 min, 6.0 s longer");
        assert_eq!(duration_in_place(8.41, 8.41), "8.410 s, as before");
        assert_eq!(percent(0.0213), "2.1 %");
        assert_eq!(percent(1.8), "180 %");
        assert_eq!(fixed(-0.0004, 2), "0.00");
        assert_eq!(
            [plain(10.0), plain(2.5), plain(0.0), plain(1e-9)],
            ["10", "2.5", "0", "0"]
        );
    }

    proptest! {
        /// What is written is the value, to half a unit of its last digit and the rounding of f64.
        #[test]
        fn written_numbers_read_back(value in -1e6..1e6_f64, decimals in 0usize..=12) {
            let read: f64 = written(value, decimals).parse().unwrap();
            let half = 0.5 / POWERS_OF_TEN[decimals] as f64;
            prop_assert!((read - value).abs() <= half + value.abs() * 4e-16, "{value} {read}");
        }

        /// Integers of any size.
        #[test]
        fn integers_are_exact(value: u64) {
            let mut out = Vec::new();
            push_integer(&mut out, value);
            prop_assert_eq!(String::from_utf8(out).unwrap(), value.to_string());
        }
    }
}
