//! The answer of a reading.

use super::lanes::{LANES, Lanes};
use super::newton::Accepted;
use super::prior::GAP;

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
