//! What is known before a window is read: the most probable values of the unknowns and their
//! uncertainty.
//!
//! The learned load comes with its covariance, stiffness and motor friction with the uncertainty of
//! a data sheet; the half gap has no prior. All have a slack on top, since models are never exact.

use super::lanes::{Hypotheses, LANES, Lanes};
use crate::readings::LEAST_PIVOT;
use lostmotion_base::linalg::{cholesky, cholesky_solve};
use lostmotion_drive::twin::LoadModel;
use serde::{Deserialize, Serialize};

/// Unknowns: half gap, Coulomb friction, constant torque, inertia, viscous friction, stiffness,
/// motor's Coulomb friction.
pub(super) const N: usize = LANES - 1;
pub(super) const GAP: usize = 0;
const COULOMB: usize = 1;
const CONSTANT: usize = 2;
pub(super) const INERTIA: usize = 3;
const VISCOUS: usize = 4;
const STIFFNESS: usize = 5;
const MOTOR: usize = 6;
/// Places of what the learning of the load knows: inertia, viscous friction, Coulomb friction,
/// constant torque.
pub(super) const OF_LOAD: [usize; 4] = [INERTIA, VISCOUS, COULOMB, CONSTANT];

/// One number for each unknown, SI.
pub(super) type Vector = [f64; N];

/// The learned load with its covariance, the motor's friction, and the half gap if it is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Prior {
    pub(super) load: LoadModel,
    /// Covariance of the load's inertia, viscous friction, Coulomb friction and constant torque,
    /// SI.
    pub(super) covariance: [[f64; 4]; 4],
    pub(super) motor_coulomb: f64,
    pub(super) rated_torque: f64,
    /// Half gap near which to search, rad; 0 where it is unknown.
    pub(super) half_gap: f64,
    /// Flank that is left, -1 or 1: the difference of the constant torque has its sign.
    pub(super) side: f64,
}

impl Prior {
    /// Most probable values. The half gap is a start without weight.
    pub(super) fn mean(&self) -> Vector {
        let load = &self.load;
        [
            self.half_gap,
            load.coulomb,
            load.constant,
            load.inertia,
            load.viscous,
            load.stiffness,
            self.motor_coulomb,
        ]
    }

    /// Smallest values that are possible.
    pub(super) fn least(&self) -> Vector {
        [
            0.0,
            0.0,
            f64::NEG_INFINITY,
            0.1 * self.load.inertia,
            0.0,
            0.1 * self.load.stiffness,
            0.0,
        ]
    }

    /// Standard deviations of the model's own errors, which no covariance contains: parts of each
    /// value and of the rated torque. That of the stiffness is a data sheet's tenth. The others are
    /// a choice: smaller ones trust the learned load more than its model holds, larger ones leave
    /// the gap open.
    fn slack(&self) -> Vector {
        let (load, rated) = (&self.load, self.rated_torque);
        [
            f64::INFINITY,
            0.005 * load.coulomb + 2e-4 * rated,
            3e-4 * rated,
            0.02 * load.inertia,
            0.02 * load.viscous + 1e-5 * rated,
            0.1 * load.stiffness,
            0.02 * self.motor_coulomb + 2e-4 * rated,
        ]
    }

    /// Differences for the derivatives: a hundredth of the gap, and for the others what moves the
    /// contact about as far, at most a fifth of their standard deviations. A friction that is off
    /// by half a standard deviation may move the contact of a long crossing by several gaps, where
    /// a derivative says nothing. `time_s`: since the start of the window;
    /// `speed`: largest of the motor's in it, rad/s.
    pub(super) fn step(&self, half_gap: f64, time_s: f64, speed: f64) -> Vector {
        let mut spread = self.slack();
        for (unknown, entry) in OF_LOAD.into_iter().enumerate() {
            spread[entry] += self.covariance[unknown][unknown].max(0.0).sqrt();
        }
        // an inertia is not uncertain by more than itself
        spread[INERTIA] = spread[INERTIA].min(self.load.inertia);
        let mut step = spread.map(|spread| 0.2 * spread);
        // a constant torque that moves the load by that way in the window: way = torque t^2/(2 J_L)
        let way = (0.01 * half_gap).max(1e-6);
        let torque = 2.0 * way * self.load.inertia / (time_s * time_s);
        // what acts on the load anyway: an error of inertia or stiffness acts in proportion to it
        let drag = self.load.coulomb + self.load.viscous * speed + self.load.constant.abs();
        let bounds = [
            f64::INFINITY,
            torque,
            torque,
            self.load.inertia * torque / drag.max(1e-3 * self.rated_torque),
            torque / speed.max(0.1),
            self.load.stiffness * way * self.load.stiffness / drag.max(1e-3 * self.rated_torque),
            f64::INFINITY,
        ];
        for (step, bound) in step.iter_mut().zip(bounds) {
            *step = step.min(bound);
        }
        step[GAP] = way;
        // mirrored windows give mirrored differences, so both flanks read the same gap
        step[CONSTANT] *= self.side;
        step
    }

    /// Information matrix: the inverse of covariance plus slack; zero for the gap.
    pub(super) fn information(&self) -> [Vector; N] {
        let slack = self.slack();
        let mut information = [[0.0; N]; N];
        for unknown in [STIFFNESS, MOTOR] {
            information[unknown][unknown] = 1.0 / (slack[unknown] * slack[unknown]);
        }
        // scaled by the slack, so that the Cholesky factor is well conditioned
        let scaled: [[f64; 4]; 4] = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                self.covariance[i][j] / (slack[OF_LOAD[i]] * slack[OF_LOAD[j]])
                    + if i == j { 1.0 } else { 0.0 }
            })
        });
        let l = cholesky(&scaled, LEAST_PIVOT);
        // inverse column by column
        for (j, column) in OF_LOAD.into_iter().enumerate() {
            let unit: [f64; 4] = std::array::from_fn(|i| if i == j { 1.0 } else { 0.0 });
            for (i, value) in cholesky_solve(&l, &unit).into_iter().enumerate() {
                information[OF_LOAD[i]][column] = value / (slack[OF_LOAD[i]] * slack[column]);
            }
        }
        information
    }
}

/// The same hypothesis in all lanes.
pub(super) fn uniform(at: &Vector, damping: f64) -> Hypotheses {
    let [
        half_gap,
        coulomb,
        constant,
        inertia,
        viscous,
        stiffness,
        motor_coulomb,
    ] = at.map(|value| Lanes([value; LANES]));
    Hypotheses {
        half_gap,
        coulomb,
        constant,
        inertia,
        viscous,
        stiffness,
        damping: Lanes([damping; LANES]),
        motor_coulomb,
    }
}

/// The lanes of the unknown with this index.
pub(super) fn lanes_of(hypotheses: &mut Hypotheses, unknown: usize) -> &mut Lanes {
    match unknown {
        GAP => &mut hypotheses.half_gap,
        COULOMB => &mut hypotheses.coulomb,
        CONSTANT => &mut hypotheses.constant,
        INERTIA => &mut hypotheses.inertia,
        VISCOUS => &mut hypotheses.viscous,
        STIFFNESS => &mut hypotheses.stiffness,
        _ => &mut hypotheses.motor_coulomb,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn information_is_the_inverse_of_covariance_and_slack() {
        let load = LoadModel {
            inertia: 0.01,
            viscous: 0.002,
            coulomb: 1.0,
            constant: 0.0,
            stiffness: 1500.0,
            damping: 0.1,
        };
        let mut covariance = [[0.0; 4]; 4];
        (
            covariance[2][2],
            covariance[3][3],
            covariance[2][3],
            covariance[3][2],
        ) = (0.04, 0.04, -0.039, -0.039);
        let prior = Prior {
            load,
            covariance,
            motor_coulomb: 0.1,
            rated_torque: 10.0,
            half_gap: 0.0,
            side: 1.0,
        };
        let information = prior.information();
        // friction and constant torque are known together far better than each
        let both = information[1][1] + information[2][2] + 2.0 * information[1][2];
        assert!(
            both > 50.0 * (1.0 / 0.04)
                && information[1][2] > 0.0
                && (information[1][2] - information[2][1]).abs() < 1e-9 * both
        );
        assert!((information[5][5] - 1.0 / (150.0 * 150.0)).abs() < 1e-12);
        assert!(information[0].iter().all(|entry| *entry == 0.0));
    }
}
