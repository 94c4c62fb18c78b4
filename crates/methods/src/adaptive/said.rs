//! The result of a reading, tested against alternatives; and where a contact began.

use super::lanes::{Innovation, LANES, Lanes, Progress};
use super::newton::{Accepted, LEAST_SCALE};
use super::prior::{GAP, OF_LOAD};
use serde::{Deserialize, Serialize};

/// Alternative half gaps that a found one is compared with, as parts of it, itself first; the last
/// lane is the gap without an end. Steps of decision 63 of the book.
pub(super) const AGAINST: [f64; LANES - 1] = [1.0, 0.98, 1.02, 0.94, 1.06, 0.8, 1.25];

/// What a window says of the half gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Said {
    pub(super) half_gap: f64,
    /// Variance of the half gap, rad2.
    pub(super) variance: f64,
    /// Whether the flank wavered.
    pub(super) wavered: bool,
    /// Mean square of the innovations over their variance: with the best hypothesis, and without a
    /// gap.
    pub(super) misfit: f64,
    pub(super) without: f64,
    /// How much smaller the sum of squared innovations over their variance is than with a gap without
    /// an end: twice the log-likelihood ratio of contact against no contact.
    pub(super) evidence: f64,
    /// The load's inertia, viscous friction, Coulomb friction and constant torque that explain it
    /// best, SI, and their covariance.
    pub(super) load: ([f64; 4], [[f64; 4]; 4]),
}

impl Said {
    /// No contact was found.
    pub(super) const NOTHING: Said = Said {
        half_gap: 0.0,
        variance: f64::INFINITY,
        wavered: true,
        misfit: f64::INFINITY,
        without: 0.0,
        evidence: 0.0,
        load: ([0.0; 4], [[0.0; 4]; 4]),
    };

    /// The found half gap with the costs of the alternatives in [`AGAINST`]. The reported variance is
    /// at least what the cost at the alternative gaps implies, whatever the derivatives say.
    pub(super) fn checked(found: &Accepted, costs: &Lanes, wavered: bool, without: f64) -> Said {
        let Accepted {
            at,
            misfit,
            mut variance,
            ..
        } = *found;
        // costs over the misfit, as the scale of Gauss-Newton
        let [least, .., endless] = costs.map(|cost| cost / misfit.max(LEAST_SCALE)).0;
        for (part, cost) in AGAINST.iter().zip(&costs.0) {
            // a parabola: a cost larger by c at a distance off means a variance of off^2/c
            let off = (part - 1.0) * at[GAP];
            variance = variance.max(off * off / (cost / misfit.max(LEAST_SCALE) - least).max(1.0));
        }
        Said {
            half_gap: at[GAP],
            variance,
            wavered,
            misfit,
            without,
            evidence: endless - least,
            load: (OF_LOAD.map(|unknown| at[unknown]), found.load),
        }
    }
}

/// A half gap that is never crossed, rad: more than a turn of the motor.
pub(super) const ENDLESS_HALF_GAP_RAD: f64 = 10.0;
/// Lane of that gap while an onset is searched for; behind it nobody asks.
const ENDLESS_LANE: usize = 1;
/// Lanes of that search: no gap at all, and one without an end.
pub(super) const ONSET_LANES: usize = ENDLESS_LANE + 1;
/// Samples that are kept after the onset: what follows tells of the shaft's ringing, not of the
/// gap. A choice: 1 ms; fewer cut the contact off, more let the ringing in.
const SAMPLES_AFTER_ONSET: usize = 4;
/// Allowance of the cumulative sum a sample: three times the squared innovation over its variance
/// that is expected without contact. A choice: lower lets noise add up to an onset, higher misses
/// soft contacts.
const EXPECTED_SQUARE: f64 = 3.0;
/// Part of a known half gap over which no contact is searched for, since the start of a traverse
/// may look like one. A choice: larger hides the contact of a gap that was believed too large.
const BLIND_SHARE: f64 = 0.5;
/// Innovations over their standard deviation that may be the first of a contact, from a soft one to
/// a hard one: each gives a candidate for the half gap.
const THRESHOLDS: [f64; 4] = [4.0, 8.0, 16.0, 32.0];

/// Search for a contact in the lane of the gap without an end, in which a contact moves the motor as
/// its current does not explain: a one-sided cumulative sum (Page, 1954).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Onset {
    /// Sum of squares beyond the expected ones.
    met: f64,
    /// Half of the way across the gap where each threshold was first exceeded, rad.
    pub(super) half_ways: [Option<f64>; THRESHOLDS.len()],
    /// Samples up to where the sum is sufficient, with those after it.
    pub(super) end: Option<usize>,
}

impl Onset {
    /// Searches a sample: `side`, the flank that was left; `known`, a half gap that is known already
    /// (rad, else 0); `enough`, the sum of squares that shows a contact.
    #[inline(always)]
    pub(super) fn look(
        &mut self,
        innovation: &Innovation,
        progress: &Progress,
        side: f64,
        known: f64,
        enough: f64,
    ) {
        // the way of the motor across the gap since it left its flank
        let way = ENDLESS_HALF_GAP_RAD - progress.lead[ENDLESS_LANE] * side;
        if way < BLIND_SHARE * known {
            return;
        }
        // the far flank pushes the motor back towards the one that it left
        let e = (innovation.e[ENDLESS_LANE] * side / innovation.variance.sqrt()).max(0.0);
        self.met = (self.met + e * e - EXPECTED_SQUARE).max(0.0);
        if self.met > enough && self.end.is_none() {
            self.end = Some(progress.taken() + SAMPLES_AFTER_ONSET);
        }
        // where each threshold is first exceeded, the way so far would be the whole gap
        for (half_way, threshold) in self.half_ways.iter_mut().zip(THRESHOLDS) {
            if half_way.is_none() && e > threshold && way > 0.0 {
                *half_way = Some(0.5 * way);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::newton::{Newton, Sums};
    use super::super::prior::Prior;
    use super::*;
    use lostmotion_drive::twin::LoadModel;

    #[test]
    fn it_is_no_surer_than_the_gaps_it_was_held_against_tell() {
        let load = LoadModel {
            inertia: 0.01,
            viscous: 0.002,
            coulomb: 1.0,
            constant: 0.0,
            stiffness: 1500.0,
            damping: 0.1,
        };
        let prior = Prior {
            load,
            covariance: [[0.0; 4]; 4],
            motor_coulomb: 0.1,
            rated_torque: 10.0,
            half_gap: 0.5,
            side: 1.0,
        };
        let mut newton = Newton::new(prior.mean());
        newton.take(&Sums::default(), 100.0, &prior, &[1.0; 7], false);
        let mut found = newton.accepted.unwrap();
        (found.variance, found.misfit) = (1e-8, 1.0);
        // 6 % off costs 4: a standard deviation of 3 %
        let said = Said::checked(
            &found,
            &Lanes([10.0, 30.0, 30.0, 14.0, 15.0, 500.0, 500.0, 810.0]),
            false,
            1e3,
        );
        assert!(
            (said.variance.sqrt() - 0.03 * 0.5).abs() < 1e-12
                && (said.evidence - 800.0).abs() < 1e-12,
            "{said:?}"
        );
    }
}
