//! What is known of a number of which readings come one after the other: the largest group of the last ones that agree.
//!
//! A reading may be wrong and sure of itself, so none counts alone, and none is believed because it came first. Readings agree within their variances and
//! the drift since; those of the largest group (of groups of one size, the one with the newest reading) are joined by a scalar Kalman filter
//! from the oldest on.

use serde::{Deserialize, Serialize};

/// Readings kept.
const KEPT: usize = 8;
/// Drift from reading to reading, part of the value.
const DRIFT: f64 = 0.004;
/// Standard deviation that no reading undercuts, part of the value.
const LEAST: f64 = 0.01;
/// Standard deviations within which readings agree.
const GATE: f64 = 3.0;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Readings {
    pub(super) value: f64,
    pub(super) variance: f64,
    /// Readings in the group.
    pub(super) count: u32,
    /// Readings in all.
    pub(super) seen: u32,
    /// Values and variances, the newest first.
    recent: [Option<(f64, f64)>; KEPT],
}

impl Readings {
    pub(super) fn take(&mut self, value: f64, variance: f64) {
        self.seen = self.seen.saturating_add(1);
        self.recent.rotate_right(1);
        self.recent[0] = Some((value, variance + LEAST * LEAST * value * value));
        for age in 0..KEPT {
            let group = self.group(age);
            if age == 0 || group.count > self.count {
                (self.value, self.variance, self.count) = (group.value, group.variance, group.count);
            }
        }
    }

    /// The readings that agree with one of them, joined.
    fn group(&self, around: usize) -> Readings {
        let mut joined = Readings::default();
        let Some((centre, its)) = self.recent[around] else { return joined };
        for (age, reading) in self.recent.iter().enumerate().rev() {
            let drift = DRIFT * centre;
            joined.variance += drift * drift;
            let Some((value, variance)) = *reading else { continue };
            let apart = drift * age.abs_diff(around) as f64;
            if (value - centre) * (value - centre) > GATE * GATE * (its + variance + apart * apart) {
                continue;
            }
            let gain = if joined.count == 0 { 1.0 } else { joined.variance / (joined.variance + variance) };
            joined.value += gain * (value - joined.value);
            joined.variance = if joined.count == 0 { variance } else { joined.variance * (1.0 - gain) };
            joined.count += 1;
        }
        joined
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
    fn a_wrong_first_reading_is_outvoted_and_one_alone_counts_one() {
        let mut known = Readings::default();
        known.take(1.6, 1e-6);
        assert_eq!(known.count, 1);
        known.take(1.0, 1e-6);
        assert_eq!((known.value, known.count), (1.0, 1));
        known.take(1.01, 1e-6);
        assert!((known.value - 1.005).abs() < 2e-3 && known.count == 2, "{known:?}");
        known.take(3.0, 1e-6);
        assert!((known.value - 1.005).abs() < 2e-3 && known.count == 2, "{known:?}");
    }
}
