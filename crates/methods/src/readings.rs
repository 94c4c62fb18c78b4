//! A robust estimate of a quantity that is read again and again: the largest group of the last
//! readings that agree.
//!
//! A reading may be wrong and report a small variance, so none is believed because it came first,
//! and one alone only where it is clear. Readings agree within their variances and the drift since;
//! those of the largest group (of groups of one size, the one with the newest reading) are joined
//! by weighted least squares, a straight line over their age, whose slope is held by the drift that
//! is possible.
//!
//! ```text
//! agree:   (z_i - z_c)^2 <= 9 (P_i + P_c + (0.005 z_c |age_i - age_c|)^2)
//! line:    minimise sum (z_i - x + s age_i)^2/P_i + s^2/(0.005 z_c)^2      x: value at the newest of the group, s: drift a reading
//! ```
//! Of a gap that several readings agree on, larger ones are kept apart until as many in a row agree with
//! each other: where a traverse is right the contact is soft and shows little, and readings of it may run
//! away, each larger than the one before. While a correction is in use that holds from the first reading on:
//! one that is too long throws the load, so that the gap seems larger yet. Half as many again that agree then
//! speak against the correction, and not for a larger gap: all is forgotten, and read anew without one.
//! Smaller ones have to be more than those that agree with it: a load
//! that still bounces when its axis comes back again is read to have crossed a part of the gap.
//!
//! Where the flank wavered, the motor may have crossed more than once, and the distances add up:
//! such a reading counts only if it is not much larger than those of single crossings, or so much larger that it is
//! no sum of them.

use serde::{Deserialize, Serialize};

/// Smallest pivot of the normal equations of the fits, whose parameters are scaled to the order of
/// 1: what the data do not determine stays finite. A choice: 45 units in the last place of 1.
pub(crate) const LEAST_PIVOT: f64 = 1e-14;

/// Number of readings kept. Decision 62 of the book; a choice: more remember a changed gap longer,
/// fewer let two wrong readings outvote the rest.
const KEPT_READINGS: usize = 8;
/// Readings that agree from which on larger ones are kept apart. A choice: half of those that are kept.
const ESTABLISHED: u32 = 4;
/// How many larger ones in a row have to agree against as many as that. A choice: more than had to agree first.
const RIVALS: usize = 6;
/// Standard deviation of the drift from reading to reading, part of the value. Tuned (0.004 before
/// a trend was learned); the tests below follow a drift of as much.
const DRIFT_SHARE: f64 = 0.005;
/// Least standard deviation of a reading, part of the value: errors of the model that no variance
/// reports. Tuned (0.01 before readings were compared with other gaps).
const LEAST_DEVIATION_SHARE: f64 = 0.005;
/// Standard deviations within which readings agree: 3 leave out 0.3 % of good ones.
const GATE_DEVIATIONS: f64 = 3.0;
/// Part of a reading within which another agrees whatever their variances: first readings are off by
/// as much while the load is not known well. A choice: what is used then leaves a tenth.
const NEAR_SHARE: f64 = 0.1;
/// Crossings that are remembered as hints, readings that do not count among them.
const KEPT_HINTS: usize = 8;
/// Hints that are wanted before any is used.
const LEAST_HINTS: usize = 6;
/// The same where the smallest of them agree within `NEAR_SHARE`. A choice: as many readings as are needed for
/// the whole of a gap; what bounces or adds up is seldom the same three times.
const AGREEING_HINTS: usize = 3;
/// Part of the second smallest that is used: they may all be off to one side, and what is too small
/// only leaves a part of the error.
const HINT_SHARE: f64 = 0.75;
/// Largest standard deviation of a group that is used, part of its value. A choice: what is used
/// then leaves about a tenth of the error.
const LARGEST_DOUBT: f64 = 0.1;
/// Largest standard deviation of a single reading that is used, part of its value. A choice: twice
/// that of a group, still better than no compensation.
const LARGEST_DOUBT_ALONE: f64 = 0.2;
/// Part of a single reading that is used at rest where it does not count alone, or of the smallest hint. Tuned:
/// of 13 drawn cells such readings of the tool's axis were 0.99 to 1.09 of the gap, of six more hints 0.6 to 1.7; at rest
/// what is too large leaves no more than what is as much too small.
const SINGLE_SHARE: f64 = 0.9;
/// Ratio to the smallest single crossing from which on a reading over a wavering flank counts as
/// several crossings added up: between once and twice the gap.
const ADDED_UP_RATIO: f64 = 1.5;
/// The same beyond which it is no sum of crossings. A choice: the motor crosses twice, seldom three times; a single
/// crossing that was read a quarter of the gap would else keep all others away for good (604417-3).
const LARGEST_SUM_RATIO: f64 = 3.0;

/// The last readings, and the estimate of their largest group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Readings {
    /// Estimate, in the unit of the readings.
    pub(super) value: f64,
    /// Its variance.
    pub(super) variance: f64,
    /// Readings in the group.
    pub(super) count: u32,
    /// Readings in all.
    pub(super) seen: u32,
    /// The newest first.
    recent: [Option<Kept>; KEPT_READINGS],
    /// Larger ones that came in a row since the last that agreed, the newest first.
    rivals: [Option<Kept>; RIVALS],
    /// The smallest crossings that showed a contact and did not count; 0 for none.
    hints: [f64; KEPT_HINTS],
}

/// Which group is believed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Consensus {
    /// The largest.
    Largest,
    /// Of those with half as many readings as the largest, two at least, the one with the smallest
    /// value, for quantities of which less is safe: a gap that is too small only leaves a part of
    /// the error. Readings near each other agree whatever their variances.
    Least {
        /// Whether a correction was in use at the crossing.
        corrected: bool,
    },
}

impl Consensus {
    fn near_share(self) -> f64 {
        match self {
            Consensus::Largest => 0.0,
            Consensus::Least { .. } => NEAR_SHARE,
        }
    }

    /// How many readings have to agree for larger ones to be kept apart; `None` for never.
    fn established(self) -> Option<u32> {
        match self {
            Consensus::Largest => None,
            // a traverse that is too long throws the load, and its gap seems larger yet
            Consensus::Least { corrected: true } => Some(1),
            Consensus::Least { corrected: false } => Some(ESTABLISHED),
        }
    }
}

/// A reading, and how far it is to be believed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Kept {
    value: f64,
    variance: f64,
    wavered: bool,
    alone: bool,
}

impl Readings {
    /// A value with its variance that was read before, as the newest readings: as many as had
    /// agreed and are kept.
    pub(super) fn known(value: f64, variance: f64, count: u32) -> Readings {
        let mut known = Readings::default();
        // of n readings the mean has an nth of the variance of each; as many as are kept, so that
        // new ones have to be as many to contradict
        let count = count.min(KEPT_READINGS as u32);
        for _ in 0..count {
            known.take(value, f64::from(count) * variance, false, true);
        }
        known
    }

    /// Takes a reading and its variance; `wavered`: the flank wavered meanwhile; `alone`: it is clear
    /// enough to count alone.
    pub(super) fn take(&mut self, value: f64, variance: f64, wavered: bool, alone: bool) {
        self.take_by(Consensus::Largest, value, variance, wavered, alone);
    }

    /// The same by another rule.
    pub(super) fn take_by(
        &mut self,
        rule: Consensus,
        value: f64,
        variance: f64,
        wavered: bool,
        alone: bool,
    ) {
        // the smallest single crossing bounds the readings over wavering flanks, the new one and
        // those kept
        let single = |kept: &Kept| {
            if kept.wavered {
                f64::INFINITY
            } else {
                kept.value
            }
        };
        let least = self
            .recent
            .iter()
            .flatten()
            .map(single)
            .fold(if wavered { f64::INFINITY } else { value }, f64::min);
        let adds_up = |value: f64| {
            value > ADDED_UP_RATIO * least
                && (rule == Consensus::Largest || value <= LARGEST_SUM_RATIO * least)
        };
        if wavered && adds_up(value) {
            return;
        }
        self.seen = self.seen.saturating_add(1);
        self.recent.iter_mut().for_each(|entry| {
            *entry = entry.filter(|kept| !kept.wavered || !adds_up(kept.value));
        });
        let new = Kept {
            value,
            variance: variance + LEAST_DEVIATION_SHARE * LEAST_DEVIATION_SHARE * value * value,
            wavered,
            alone,
        };
        let larger = rule.established().is_some_and(|least| self.count >= least)
            && value > (1.0 + NEAR_SHARE) * self.value;
        if !larger {
            self.rivals = [None; RIVALS];
            // the oldest gives way to the new one
            self.recent.rotate_right(1);
            self.recent[0] = Some(new);
        } else if !self.rival(new) {
            return;
        } else if rule == (Consensus::Least { corrected: true }) {
            // they contradict the correction that they were read with
            *self = Readings {
                seen: self.seen,
                hints: self.hints,
                ..Readings::default()
            };
            return;
        }
        // consensus: the group around each reading in turn; of equal ones the first, which holds
        // the newest
        let groups: [Readings; KEPT_READINGS] =
            std::array::from_fn(|age| self.group(age, rule.near_share()));
        let largest = groups.iter().map(|group| group.count).max().unwrap_or(0);
        let stands = |group: &&Readings| {
            self.count >= ESTABLISHED && (group.value - self.value).abs() <= NEAR_SHARE * self.value
        };
        let standing = groups.iter().filter(stands).map(|group| group.count).max();
        let around = |least: f64, most: f64| (1.0 - NEAR_SHARE) * least..=(1.0 + NEAR_SHARE) * most;
        let believed = match rule {
            Consensus::Largest => f64::NEG_INFINITY..=f64::INFINITY,
            // no smaller group outnumbers the one that several readings agreed on
            Consensus::Least { .. } if standing == Some(largest) => around(self.value, self.value),
            Consensus::Least { .. } => {
                let enough = largest.div_ceil(2).max(2).min(largest);
                let least = groups
                    .iter()
                    .filter(|group| group.count >= enough)
                    .map(|group| group.value)
                    .fold(f64::INFINITY, f64::min);
                // groups around neighbours differ by a reading or two
                around(0.0, least)
            }
        };
        self.count = 0;
        for group in groups {
            if believed.contains(&group.value) && group.count > self.count {
                (self.value, self.variance, self.count) =
                    (group.value, group.variance, group.count);
            }
        }
    }

    /// Takes a reading that is larger than those that agree; whether it and those before it agree with each
    /// other, and so take their place.
    fn rival(&mut self, new: Kept) -> bool {
        self.rivals.rotate_right(1);
        self.rivals[0] = Some(new);
        // half as many again as those that they contradict
        let against = self.count.min(ESTABLISHED) as usize;
        let enough = (against * RIVALS).div_ceil(ESTABLISHED as usize);
        let mut others = Readings::default();
        others.recent[..enough].copy_from_slice(&self.rivals[..enough]);
        let agree = others.group(0, 0.0).count as usize == enough;
        if agree {
            self.recent = others.recent;
            self.rivals = [None; RIVALS];
        }
        agree
    }

    /// Takes a reading that may not count.
    pub(super) fn hint(&mut self, value: f64) {
        // the smallest are kept: one wrong cause may show the same gap time and again
        let largest = |a: &&mut f64, b: &&mut f64| a.total_cmp(b);
        let empty = self.hints.iter_mut().find(|hint| **hint == 0.0);
        if let Some(empty) = empty {
            *empty = value;
        } else if let Some(hint) = self.hints.iter_mut().max_by(largest) {
            *hint = hint.min(value);
        }
    }

    /// A value below what the last hints say: a part of the second smallest of several, or of few whose
    /// smallest agree; else 0.
    fn hinted(&self) -> f64 {
        let mut sorted = self.hints;
        sorted.sort_by(f64::total_cmp);
        // zeros, which are no hints, come first
        let known = sorted.iter().filter(|hint| **hint > 0.0).count();
        let least = &sorted[KEPT_HINTS - known..];
        let agree =
            known >= AGREEING_HINTS && least[AGREEING_HINTS - 1] <= (1.0 + NEAR_SHARE) * least[0];
        if known < LEAST_HINTS && !agree {
            return 0.0;
        }
        HINT_SHARE * least[1]
    }

    /// The readings that agree with the one at `around`, at least those within a part of it, joined by a straight line over their age, at
    /// the newest of them.
    fn group(&self, around: usize, near_share: f64) -> Readings {
        let mut joined = Readings::default();
        let Some(Kept {
            value: centre,
            variance: its,
            ..
        }) = self.recent[around]
        else {
            return joined;
        };
        let drift = DRIFT_SHARE * centre;
        // normal equations of value and slope; the slope's prior is the drift from reading to reading.
        // Ages count from the newest of the group: one that is left out does not let the line run on
        let mut newest = None;
        let (mut normal, mut right) = ([0.0, 0.0, 1.0 / (drift * drift)], [0.0; 2]);
        for (age, reading) in self.recent.iter().enumerate() {
            let Some(Kept {
                value, variance, ..
            }) = *reading
            else {
                continue;
            };
            // the gate widens with the drift between both
            let apart = drift * age.abs_diff(around) as f64;
            let gate = (GATE_DEVIATIONS * GATE_DEVIATIONS * (its + variance + apart * apart))
                .max(near_share * near_share * centre * centre);
            if (value - centre) * (value - centre) > gate {
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
        // 2 by 2 system in closed form; the variance is that of the value with the slope free
        let determinant = normal[0] * normal[2] - normal[1] * normal[1];
        joined.value = (normal[2] * right[0] - normal[1] * right[1]) / determinant;
        joined.variance = normal[2] / determinant;
        joined
    }

    /// The value to use: that of the group, or the smallest of the readings that count alone, since a
    /// gap that is too small only leaves a part of the error. 0 where nothing is known well enough.
    pub(super) fn used(&self) -> f64 {
        if self.count > 1 {
            return if self.doubt() < LARGEST_DOUBT {
                self.value
            } else {
                0.0
            };
        }
        let alone = |kept: &&Kept| {
            kept.alone
                && kept.variance
                    < LARGEST_DOUBT_ALONE * LARGEST_DOUBT_ALONE * kept.value * kept.value
        };
        self.recent
            .iter()
            .flatten()
            .filter(alone)
            .map(|kept| kept.value)
            .reduce(f64::min)
            .unwrap_or_else(|| if self.count == 0 { self.hinted() } else { 0.0 })
    }

    /// The value to use where one that is too large does little harm: a single reading that does not count
    /// alone tells it in part, and where there is none that tells it the smallest hint does. 0 where nothing is
    /// known well enough.
    pub(super) fn used_at_rest(&self) -> f64 {
        let used = self.used();
        if used > 0.0 {
            used
        } else if self.count > 0 && self.doubt() <= LARGEST_DOUBT_ALONE {
            SINGLE_SHARE * self.value
        } else if self.count > 1 {
            0.0
        } else {
            let hints = self.hints.iter().copied().filter(|hint| *hint > 0.0);
            SINGLE_SHARE * hints.reduce(f64::min).unwrap_or(0.0)
        }
    }

    /// Standard deviation of the group over its value; infinite while nothing is known.
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

    const UNCORRECTED: Consensus = Consensus::Least { corrected: false };

    /// Readings of a zigzag whose rows are a millimetre apart (550127-1), um: of 65.6.
    #[test]
    fn a_gap_that_is_known_is_not_given_up_for_a_few_smaller_readings() {
        let mut readings = Readings::known(65.78, 0.04, 8);
        for (value, deviation) in [
            (65.43, 0.14),
            (65.66, 0.14),
            (5.65, 1.13),
            (65.25, 0.15),
            (7.42, 0.85),
            (65.30, 0.13),
            (9.84, 1.5),
            (68.0, 1.1),
            (66.69, 1.21),
            (9.74, 1.95),
            (65.46, 0.18),
            (7.24, 1.45),
        ] {
            readings.take_by(UNCORRECTED, value, deviation * deviation, false, true);
            assert!(
                (64.0..68.0).contains(&readings.used()),
                "{value}: {readings:?}"
            );
        }
        // until they are more
        for _ in 0..5 {
            readings.take_by(UNCORRECTED, 7.0, 0.5, false, true);
        }
        assert!((6.0..8.0).contains(&readings.used()), "{readings:?}");
    }

    /// A corner of a square whose correction threw the load (20261130-31), um: of 9.8.
    #[test]
    fn larger_readings_with_a_correction_speak_against_it() {
        let mut readings = Readings::default();
        readings.take_by(UNCORRECTED, 17.6, 0.16, false, true);
        let corrected = Consensus::Least { corrected: true };
        // two of them contradict one
        readings.take_by(corrected, 31.4, 2.0, false, true);
        assert!((readings.used() - 17.6).abs() < 1e-9, "{readings:?}");
        readings.take_by(corrected, 31.7, 2.0, false, true);
        assert!(
            readings.used() == 0.0 && readings.count == 0,
            "{readings:?}"
        );
        // without one two of them outvote it
        let mut readings = Readings::default();
        for value in [17.6, 31.4, 31.7] {
            readings.take_by(UNCORRECTED, value, 0.16, false, true);
        }
        assert!((readings.used() - 31.5).abs() < 0.2, "{readings:?}");
    }

    /// A first reading that was far too small (a circle of the matrix), rad: of 3.2e-3.
    #[test]
    fn what_few_readings_say_is_contradicted_by_few() {
        let corrected = Consensus::Least { corrected: true };
        for (agree, against) in [(1, 2), (2, 3), (3, 5), (4, 6), (6, 6)] {
            let mut readings = Readings::default();
            for _ in 0..agree {
                readings.take_by(UNCORRECTED, 1.1, 1e-3, false, true);
            }
            for larger in 1..=against {
                assert_eq!(readings.count, agree, "{agree} {larger}");
                readings.take_by(corrected, 3.2, 1e-3, false, true);
            }
            assert_eq!(readings.count, 0, "{agree}");
        }
    }

    #[test]
    fn at_rest_the_smallest_hint_is_enough_and_in_motion_three_that_agree_are() {
        let mut known = Readings::default();
        assert_eq!(known.used_at_rest(), 0.0);
        for (hint, used, at_rest) in [(1.5, 0.0, 1.5), (1.05, 0.0, 1.05), (1.0, 0.0, 1.0)] {
            known.hint(hint);
            assert_eq!(known.used(), used);
            assert!((known.used_at_rest() - SINGLE_SHARE * at_rest).abs() < 1e-12);
        }
        known.hint(1.08);
        assert!((known.used() - HINT_SHARE * 1.05).abs() < 1e-12);
        // a reading that counts is believed in their place
        known.take(2.0, 1e-3, false, false);
        assert!(known.used() == 0.0 && (known.used_at_rest() - SINGLE_SHARE * 2.0).abs() < 1e-12);
    }

    #[test]
    fn the_smallest_hints_stay_however_often_a_larger_gap_shows() {
        let mut known = Readings::default();
        for n in 0..5 {
            known.hint(f64::from(1 + n / 2));
        }
        assert_eq!(known.used(), 0.0);
        for hint in [1.0; 3] {
            known.hint(hint);
        }
        for _ in 0..20 {
            known.hint(13.7);
        }
        assert!((known.used() - HINT_SHARE).abs() < 1e-12);
        // what is smaller replaces what is larger, and two of it are believed
        known.hint(0.5);
        assert!((known.used() - HINT_SHARE).abs() < 1e-12);
        known.hint(0.5);
        assert!((known.used() - 0.5 * HINT_SHARE).abs() < 1e-12);
    }

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
    fn a_crossing_that_is_read_far_too_small_keeps_no_wavering_ones_away() {
        let mut readings = Readings::default();
        readings.take_by(UNCORRECTED, 6.4, 1e-3, false, true);
        // twice as much may be two crossings
        readings.take_by(UNCORRECTED, 12.0, 0.1, true, false);
        assert_eq!((readings.value, readings.count), (6.4, 1));
        for value in [24.0, 24.1] {
            readings.take_by(UNCORRECTED, value, 0.1, true, false);
        }
        assert!((readings.value - 24.05).abs() < 0.1 && readings.count == 2);
        readings.take_by(UNCORRECTED, 0.4, 1e-3, false, true);
        assert!((readings.value - 24.05).abs() < 0.1 && readings.count == 2);
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

    #[test]
    fn larger_readings_have_to_agree_to_outvote_those_that_do() {
        let mut known = Readings::known(1.0, 1e-6, 8);
        // as contacts of a right traverse ran away
        let mut take = |value: f64| {
            known.take_by(UNCORRECTED, value, 1e-6, false, true);
            known.used()
        };
        for value in [1.18, 1.27, 1.41, 1.54, 1.64, 1.73, 1.58, 1.83, 1.67] {
            assert!((take(value) - 1.0).abs() < 1e-9);
        }
        // less is believed as before
        assert!((take(0.99) - 1.0).abs() < 5e-3);
        // a gap that is larger from one reading to the next
        let used: Vec<f64> = (0..6).map(|_| take(1.3)).collect();
        assert!(used[4] < 1.01 && (used[5] - 1.3).abs() < 1e-9, "{used:?}");
    }

    #[test]
    fn readings_of_no_gap_outvote_a_few_false_ones() {
        let mut known = Readings::default();
        for value in [0.02, 0.6, 0.02, 0.03, 0.55, 0.02, 0.02] {
            known.take_by(UNCORRECTED, value, 1e-3, false, true);
        }
        assert!(known.value < 0.05 && known.used() == 0.0, "{known:?}");
    }
}
