//! What is known of a number of which readings come one after the other: the largest group of the
//! last ones that agree.
//!
//! A reading may be wrong and sure of itself, so none counts alone, and none is believed because it
//! came first. Readings agree within their variances and the drift since; those of the largest
//! group (of groups of one size, the one with the newest reading) are joined by a scalar Kalman
//! filter from the oldest on. Where the flank wavered, the motor may have crossed more than once,
//! and the way adds up: such a reading counts only if it is not much larger than those of single
//! crossings.

use serde::{Deserialize, Serialize};

/// Smallest pivot of the normal equations of the fits, whose parameters are scaled to the order of
/// 1: what the data do not determine stays finite. Origin unknown, kept.
pub(crate) const LEAST_PIVOT: f64 = 1e-14;

/// Readings kept.
const KEPT: usize = 8;
/// Standard deviation of the drift from reading to reading, part of the value.
const DRIFT: f64 = 0.005;
/// Standard deviation that no reading undercuts, part of the value.
const LEAST: f64 = 0.005;
/// Standard deviations within which readings agree.
const GATE: f64 = 3.0;
/// Standard deviation over value below which what is known is used, and a reading that counts
/// alone.
const SURE: f64 = 0.1;
const ALONE: f64 = 0.2;
/// A reading over a flank that wavered is too large if it is so many times one of a single
/// crossing.
const LARGER: f64 = 1.5;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Readings {
    pub(super) value: f64,
    pub(super) variance: f64,
    /// Readings in the group.
    pub(super) count: u32,
    /// Readings in all.
    pub(super) seen: u32,
    /// The newest first.
    recent: [Option<Kept>; KEPT],
}

/// A reading that is kept.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Kept {
    value: f64,
    variance: f64,
    wavered: bool,
    alone: bool,
}

impl Readings {
    /// Takes a reading and its variance; `wavered`: the flank wavered meanwhile; `alone`: it is so
    /// clear that it counts alone.
    pub(super) fn take(&mut self, value: f64, variance: f64, wavered: bool, alone: bool) {
        let single = |kept: &Kept| {
            if kept.wavered {
                f64::INFINITY
            } else {
                kept.value
            }
        };
        let most = LARGER
            * self
                .recent
                .iter()
                .flatten()
                .map(single)
                .fold(if wavered { f64::INFINITY } else { value }, f64::min);
        if wavered && value > most {
            return;
        }
        self.seen = self.seen.saturating_add(1);
        self.recent
            .iter_mut()
            .for_each(|entry| *entry = entry.filter(|kept| !kept.wavered || kept.value <= most));
        self.recent.rotate_right(1);
        self.recent[0] = Some(Kept {
            value,
            variance: variance + LEAST * LEAST * value * value,
            wavered,
            alone,
        });
        self.count = 0;
        for age in 0..KEPT {
            let group = self.group(age);
            if group.count > self.count {
                (self.value, self.variance, self.count) =
                    (group.value, group.variance, group.count);
            }
        }
    }

    /// The readings that agree with one of them, joined: a straight line over their age up to the
    /// newest of them, as steep as they show and drifts are.
    fn group(&self, around: usize) -> Readings {
        let mut joined = Readings::default();
        let Some(Kept {
            value: centre,
            variance: its,
            ..
        }) = self.recent[around]
        else {
            return joined;
        };
        let drift = DRIFT * centre;
        // what is left out says nothing of how far the drift went meanwhile
        let mut newest = None;
        let (mut normal, mut right) = ([0.0, 0.0, 1.0 / (drift * drift)], [0.0; 2]);
        for (age, reading) in self.recent.iter().enumerate() {
            let Some(Kept {
                value, variance, ..
            }) = *reading
            else {
                continue;
            };
            let apart = drift * age.abs_diff(around) as f64;
            if (value - centre) * (value - centre) > GATE * GATE * (its + variance + apart * apart)
            {
                continue;
            }
            let newest = *newest.get_or_insert(age);
            let (weight, age) = (1.0 / variance, (age - newest) as f64);
            normal = [
                normal[0] + weight,
                normal[1] - weight * age,
                normal[2] + weight * age * age,
            ];
            right = [right[0] + weight * value, right[1] - weight * age * value];
            joined.count += 1;
        }
        let determinant = normal[0] * normal[2] - normal[1] * normal[1];
        joined.value = (normal[2] * right[0] - normal[1] * right[1]) / determinant;
        joined.variance = normal[2] / determinant;
        joined
    }

    /// The value to use: that of readings that agree, or the least of those that count alone, since
    /// too small a one can do no harm. 0 if none is sure.
    pub(super) fn used(&self) -> f64 {
        if self.count > 1 {
            return if self.doubt() < SURE { self.value } else { 0.0 };
        }
        let alone =
            |kept: &&Kept| kept.alone && kept.variance < ALONE * ALONE * kept.value * kept.value;
        self.recent
            .iter()
            .flatten()
            .filter(alone)
            .map(|kept| kept.value)
            .reduce(f64::min)
            .unwrap_or(0.0)
    }

    /// Standard deviation over value.
    pub(super) fn doubt(&self) -> f64 {
        if self.count == 0 || self.value <= 0.0 {
            f64::INFINITY
        } else {
            self.variance.sqrt() / self.value
        }
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
            known.take(if n % 7 == 3 { 3.0 } else { value }, 1e-6, false, true);
        }
        assert!(
            (known.value - 1.245).abs() < 0.03 && known.doubt() < 0.02,
            "{known:?}"
        );
    }

    #[test]
    fn a_wrong_first_reading_is_outvoted_and_one_alone_counts_one() {
        let mut known = Readings::default();
        known.take(1.6, 1e-6, false, true);
        assert_eq!(known.count, 1);
        known.take(1.0, 1e-6, false, true);
        assert_eq!((known.value, known.count), (1.0, 1));
        known.take(1.01, 1e-6, false, true);
        assert!(
            (known.value - 1.005).abs() < 2e-3 && known.count == 2,
            "{known:?}"
        );
        known.take(3.0, 1e-6, false, true);
        assert!(
            (known.value - 1.005).abs() < 2e-3 && known.count == 2,
            "{known:?}"
        );
    }

    #[test]
    fn a_single_crossing_shows_that_wavering_ones_added_up() {
        let mut known = Readings::default();
        known.take(4.0, 1e-6, true, true);
        known.take(4.0, 1e-6, true, true);
        assert!((known.value - 4.0).abs() < 1e-12 && known.count == 2);
        known.take(1.0, 1e-6, false, true);
        assert_eq!((known.value, known.count), (1.0, 1));
        known.take(4.0, 1e-6, true, true);
        assert_eq!((known.value, known.count), (1.0, 1));
        known.take(1.01, 1e-6, true, true);
        assert_eq!(known.count, 2);
    }

    #[test]
    fn of_clear_readings_that_contradict_each_other_the_least_is_used_until_two_agree() {
        let mut known = Readings::default();
        let mut used = Vec::new();
        for (value, alone) in [
            (2.0, false),
            (2.6, true),
            (1.6, true),
            (3.5, true),
            (3.51, false),
        ] {
            known.take(value, 1e-6, false, alone);
            used.push(known.used());
        }
        assert_eq!(used[..4], [0.0, 2.6, 1.6, 1.6]);
        assert!((used[4] - 3.505).abs() < 5e-3, "{used:?}");
    }

    #[test]
    fn a_steady_drift_is_followed_without_lag() {
        let mut known = Readings::default();
        for n in 0..20 {
            known.take(1.0 + 0.006 * f64::from(n), 1e-6, false, true);
        }
        assert!((known.value - 1.114).abs() < 1e-3, "{known:?}");
    }
}
