//! The answer of a reading.

use super::lanes::{Innovation, LANES, Lanes, Progress};
use super::newton::Accepted;
use super::prior::GAP;
use serde::{Deserialize, Serialize};

/// Half gaps that what was found is held against, parts of it, itself first; one without an end
/// comes last.
pub(super) const AGAINST: [f64; LANES - 1] = [1.0, 0.98, 1.02, 0.94, 1.06, 0.8, 1.25];

/// What a window says.
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
    /// By how much the squares of the innovations over their variance are fewer than if the gap had
    /// no end.
    pub(super) evidence: f64,
}

impl Said {
    /// No contact was seen.
    pub(super) const NOTHING: Said = Said {
        half_gap: 0.0,
        variance: f64::INFINITY,
        wavered: true,
        misfit: f64::INFINITY,
        without: 0.0,
        evidence: 0.0,
    };

    /// What was found, with the costs of the half gaps that it is held against: it is no surer than
    /// these tell, whatever the derivatives say.
    pub(super) fn checked(found: &Accepted, costs: &Lanes, wavered: bool, without: f64) -> Said {
        let Accepted {
            at,
            misfit,
            mut variance,
            ..
        } = *found;
        let [least, .., endless] = costs.map(|cost| cost / misfit.max(1.0));
        for (part, cost) in AGAINST.iter().zip(costs) {
            let off = (part - 1.0) * at[GAP];
            variance = variance.max(off * off / (cost / misfit.max(1.0) - least).max(1.0));
        }
        Said {
            half_gap: at[GAP],
            variance,
            wavered,
            misfit,
            without,
            evidence: endless - least,
        }
    }
}

// Where a contact began: the lane of the gap without an end, in which the motor does what its
// current does not explain.

/// A half gap that is never crossed, rad.
pub(super) const ENDLESS: f64 = 10.0;
/// Lane of that gap.
const LANE: usize = 1;
/// Samples after the onset that are kept; squares that come without contact; part of a known half
/// gap over which no contact is looked for, since a traverse sets out so hard that it may look like
/// one.
const AFTER: usize = 4;
const EXPECTED: f64 = 3.0;
const LOOKED: f64 = 0.5;
/// Innovations over their standard deviation that may be the first of a contact.
const THRESHOLDS: [f64; 4] = [4.0, 8.0, 16.0, 32.0];

/// What was seen of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Onset {
    /// Sum of squares beyond what is expected.
    met: f64,
    /// Half of the way across the gap where each threshold was first exceeded, rad.
    pub(super) half_ways: [Option<f64>; THRESHOLDS.len()],
    /// Samples up to where enough was seen.
    pub(super) end: Option<usize>,
}

impl Onset {
    /// Looks for a contact in a sample: the flank that was left, a half gap that is known already
    /// (rad, else 0), and the sum of squares that is enough.
    pub(super) fn look(
        &mut self,
        innovation: &Innovation,
        progress: &Progress,
        side: f64,
        known: f64,
        enough: f64,
    ) {
        let way = ENDLESS - progress.lead[LANE] * side;
        if way < LOOKED * known {
            return;
        }
        let e = (innovation.e[LANE] * side / innovation.variance.sqrt()).max(0.0);
        self.met = (self.met + e * e - EXPECTED).max(0.0);
        if self.met > enough && self.end.is_none() {
            self.end = Some(progress.taken() + AFTER);
        }
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
        newton.take(&Sums::default(), 100.0, &prior, &[1.0; 7]);
        let mut found = newton.accepted.unwrap();
        (found.variance, found.misfit) = (1e-8, 1.0);
        // 6 % off costs 4: a standard deviation of 3 %
        let said = Said::checked(
            &found,
            &[10.0, 30.0, 30.0, 14.0, 15.0, 500.0, 500.0, 810.0],
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
