//! What is known of a number of which count come one after the other: a scalar Kalman filter with a gate.
//!
//! The number may drift: between count its variance grows. A reading far beside what is known is left out; two in a row that agree with each other
//! start over from them.

use serde::{Deserialize, Serialize};

/// Drift from reading to reading, part of the value.
const DRIFT: f64 = 0.004;
/// Standard deviation that no reading undercuts, part of the value.
const LEAST: f64 = 0.01;
/// Readings farther than so many standard deviations are left out.
const GATE: f64 = 3.0;
/// So many of them in a row, and nothing is known any more.
const MOST_STRAYS: u32 = 4;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Readings {
    pub(super) value: f64,
    pub(super) variance: f64,
    pub(super) count: u32,
    stray: Option<(f64, f64)>,
    strays: u32,
}

impl Readings {
    pub(super) fn take(&mut self, value: f64, variance: f64) {
        let variance = variance + LEAST * LEAST * value * value;
        if self.count == 0 {
            *self = Readings { value, variance, count: 1, stray: None, strays: 0 };
            return;
        }
        self.variance += DRIFT * DRIFT * self.value * self.value;
        let off = value - self.value;
        if off * off > GATE * GATE * (self.variance + variance) {
            match self.stray {
                Some((before, its)) if (value - before) * (value - before) < GATE * GATE * (its + variance) => {
                    *self = Readings { value: 0.5 * (value + before), variance: 0.5 * (variance + its), count: 2, stray: None, strays: 0 };
                }
                _ if self.strays + 1 >= MOST_STRAYS => *self = Readings::default(),
                _ => (self.stray, self.strays) = (Some((value, variance)), self.strays + 1),
            }
            return;
        }
        (self.stray, self.strays) = (None, 0);
        let gain = self.variance / (self.variance + variance);
        self.value += gain * off;
        self.variance *= 1.0 - gain;
        self.count = self.count.saturating_add(1);
    }

    /// Standard deviation over value.
    pub(super) fn doubt(&self) -> f64 {
        if self.count == 0 || self.value <= 0.0 { f64::INFINITY } else { self.variance.sqrt() / self.value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_follows_a_drift_and_leaves_out_what_is_far_beside() {
        let mut known = Readings::default();
        for n in 0..50 {
            let value = 1.0 + 0.005 * f64::from(n);
            known.take(if n % 7 == 3 { 3.0 } else { value }, 1e-6);
        }
        assert!((known.value - 1.245).abs() < 0.03 && known.doubt() < 0.02, "{known:?}");
    }

    #[test]
    fn two_that_agree_start_over_and_four_that_do_not_end_it() {
        let mut known = Readings::default();
        known.take(1.0, 1e-6);
        known.take(2.0, 1e-6);
        known.take(2.01, 1e-6);
        assert!((known.value - 2.005).abs() < 1e-12 && known.count == 2);
        for value in [1.0, 3.0, 5.0, 0.5] {
            known.take(value, 1e-6);
        }
        assert!(known.count == 0 && known.doubt().is_infinite());
    }
}
