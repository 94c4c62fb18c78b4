//! Transcendental functions with the same bits on every platform.
//!
//! std's `sin`, `atan2`, `exp` and the like come from the platform's C library and differ by 1 to 3
//! units in the last place between platforms. These come from the pinned `libm` crate, so that
//! results are reproducible; clippy's `disallowed-methods` bans the others.

pub use libm::{
    acos, acosh, asin, asinh, atan, atan2, cbrt, cos, cosh, exp, exp2, expm1, hypot, log, log1p,
    log2, log10, pow, sin, sinh, tan, tanh,
};

/// Sine and cosine of an angle in rad.
pub fn sin_cos(angle_rad: f64) -> (f64, f64) {
    (libm::sin(angle_rad), libm::cos(angle_rad))
}

/// sin(x)/x, 1 at zero.
pub fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 {
        // The next term of the series, x^4/120, is below 1e-18.
        1.0 - x * x / 6.0
    } else {
        libm::sin(x) / x
    }
}

/// A quantile of unordered values by nearest rank; 0 if there are none.
pub fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    // Selection, not sorting: logs have 10^5 samples.
    let rank = ((values.len() - 1) as f64 * share).round() as usize;
    *values.select_nth_unstable_by(rank, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_by_rank() {
        assert_eq!(quantile(vec![], 0.5).to_bits(), 0.0_f64.to_bits());
        let values: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        assert!(
            (quantile(values.clone(), 0.95) - 95.0).abs() < 1e-12
                && (quantile(values, 0.5) - 50.0).abs() < 1e-12
        );
    }

    #[test]
    fn sinc_is_continuous_at_its_switch() {
        let x: f64 = 1e-4;
        assert!((sinc(x) - libm::sin(x) / x).abs() < 1e-15);
        assert_eq!(sinc(0.0).to_bits(), 1.0_f64.to_bits());
    }
}
