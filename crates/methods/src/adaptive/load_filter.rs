//! What torque, speed and acceleration say of the load: a Kalman filter over its four unknowns,
//! which drift.
//!
//! What a motion does not excite keeps its value and slowly becomes less sure. Before the first
//! block stands what any axis may have. Blocks in which the load hangs between the flanks or
//! bounces do not obey the model; their weight 1/(1 + r^2/s^2)^2 falls with their residual r over
//! the spread s of the others.

use super::bridge::Crossed;
use super::watch::Motor;
use serde::{Deserialize, Serialize};

/// Blocks follow each other with much the same disturbances: so many count as one.
const ALIKE: f64 = 10.0;
/// The spread of the residuals follows within a hundred blocks; a residual counts three times the
/// spread at most.
const SPREAD_GAIN: f64 = 0.01;
const SPREAD_CUT: f64 = 9.0;
/// Least spread, part of the rated torque.
const LEAST_SPREAD: f64 = 1e-3;
/// Residuals that agree in their sign over 25 blocks tell that what is known is wrong, not that the
/// blocks are: then it is learned anew, with this part of what any axis may have added to the
/// standard deviations at each block.
const BIAS_GAIN: f64 = 0.04;
const BIASED: f64 = 0.3;
const RELEARN: f64 = 0.02;
/// Over a whole reversal: mean torque that nothing models, part of the rated one; part of the
/// inertia for a load that bounces at its ends; standard deviations of a surprise; and how two in a
/// row have to agree, part of their sum, for the inertia to be in doubt by as much.
const UNTOLD: f64 = 3e-3;
const BOUNCE: f64 = 0.1;
const SURPRISE: f64 = 3.0;
const AGREE: f64 = 0.3;
/// Inertia of the load over that of the motor.
pub(super) const LEAST_INERTIA: f64 = 0.1;
/// Unknowns: inertia (over that of the motor), viscous friction (over rated torque at 100 rad/s),
/// Coulomb friction, constant torque (over the rated).
pub(super) const N: usize = 4;
/// What any axis may have: mean and standard deviation, and the drift from block to block. Viscous
/// friction that takes more than a fifth of the rated torque at the rated speed of a motor is rare.
/// Of what drifts, friction does most: were a constant torque as free, half of any change of the
/// friction would be taken for one as long as the axis moves one way.
const MEAN: LoadVector = [1.5, 0.03, 0.05, 0.0];
const SPREAD: LoadVector = [3.0, 0.1, 0.3, 0.05];
const DRIFT: LoadVector = [1e-3, 3e-5, 1e-4, 1e-5];
pub(super) const VISCOUS_SPEED: f64 = 100.0;

pub(super) type LoadVector = [f64; N];

/// The filter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LoadFilter {
    pub(super) mean: LoadVector,
    covariance: [[f64; N]; N],
    /// Mean square of the residuals over the rated torque.
    spread: f64,
    /// Mean of the last residuals and of their squares, over the rated torque.
    bias: f64,
    power: f64,
    /// What the last reversal said of the inertia, if it was a surprise.
    surprise: f64,
}

impl LoadFilter {
    pub(super) fn new() -> LoadFilter {
        let mut covariance = [[0.0; N]; N];
        for (i, row) in covariance.iter_mut().enumerate() {
            row[i] = SPREAD[i] * SPREAD[i];
        }
        LoadFilter {
            mean: MEAN,
            covariance,
            spread: 1e-3,
            bias: 0.0,
            power: 0.0,
            surprise: 0.0,
        }
    }

    /// Covariance of the unknowns in the units of each.
    pub(super) fn covariance(&self, unit: &LoadVector) -> [LoadVector; N] {
        std::array::from_fn(|i| std::array::from_fn(|j| self.covariance[i][j] * unit[i] * unit[j]))
    }

    /// Standard deviation over value of the inertia.
    pub(super) fn inertia_doubt(&self) -> f64 {
        self.covariance[0][0].max(0.0).sqrt() / self.mean[0].max(LEAST_INERTIA)
    }

    /// Standard deviation of the Coulomb friction, over the rated torque.
    pub(super) fn friction_doubt(&self) -> f64 {
        self.covariance[2][2].max(0.0).sqrt()
    }

    /// The most likely values that are possible: no friction or inertia below zero.
    pub(super) fn possible(&self) -> LoadVector {
        let (mut mean, mut p) = (self.mean, self.covariance);
        for (i, least) in [(1, 0.0), (2, 0.0), (0, LEAST_INERTIA)] {
            if mean[i] < least && p[i][i] > 0.0 {
                let (column, off): (LoadVector, f64) =
                    (std::array::from_fn(|j| p[j][i] / p[i][i]), least - mean[i]);
                let row = p[i];
                for j in 0..N {
                    mean[j] += column[j] * off;
                    for k in 0..N {
                        p[j][k] -= column[j] * row[k];
                    }
                }
            }
        }
        mean
    }

    /// Takes what a whole reversal says.
    pub(super) fn cross(&mut self, said: &Crossed, motor: &Motor) {
        let (inertia, rated) = (motor.inertia, motor.rated_torque);
        let row = [
            said.acceleration * inertia / rated,
            said.speed / VISCOUS_SPEED,
            said.sign,
            1.0,
        ];
        let residual =
            said.torque / rated - row.iter().zip(self.mean).map(|(a, x)| a * x).sum::<f64>();
        // slid the other way, it counts twice
        let loose = 2.0 * self.mean[2].max(0.0) * said.loose;
        let bounce = BOUNCE * self.mean[0] * row[0];
        let noise = UNTOLD * UNTOLD + loose * loose + bounce * bounce;
        let ph = self.gains(&row);
        let foreseen: f64 = ph.iter().zip(row).map(|(p, a)| p * a).sum();
        let surprise = if residual * residual > SURPRISE * SURPRISE * (foreseen + noise) {
            residual / row[0]
        } else {
            0.0
        };
        let before = std::mem::replace(&mut self.surprise, surprise);
        if surprise * before > 0.0
            && (surprise - before).abs() < AGREE * (surprise.abs() + before.abs())
        {
            // steady stretches have been sure of an inertia that they did not see
            self.covariance[0][0] += surprise * surprise;
        }
        let ph = self.gains(&row);
        let foreseen: f64 = ph.iter().zip(row).map(|(p, a)| p * a).sum();
        self.correct(&ph, 1.0 / (foreseen + noise), residual);
    }

    /// Takes a block; `noise`: variance of the first of its row, as a regressor's error it makes
    /// the inertia too small; `known`: enough came before to tell which are bad.
    pub(super) fn update(&mut self, row: &LoadVector, torque: f64, noise: f64, known: bool) {
        for (i, line) in self.covariance.iter_mut().enumerate() {
            line[i] += DRIFT[i]
                * DRIFT[i]
                * if i == 0 {
                    self.mean[0] * self.mean[0]
                } else {
                    1.0
                };
        }
        let residual = torque - row.iter().zip(self.mean).map(|(a, x)| a * x).sum::<f64>();
        let of_inertia = self.mean[0].max(LEAST_INERTIA);
        let spread = self.spread.max(LEAST_SPREAD * LEAST_SPREAD) + noise * of_inertia * of_inertia;
        let ph = self.gains(row);
        let foreseen: f64 = ph.iter().zip(row).map(|(p, a)| p * a).sum();
        let square = residual * residual;
        self.bias += BIAS_GAIN * (residual - self.bias);
        self.power += BIAS_GAIN * (square - self.power);
        let bias = self.bias * self.bias;
        let biased = bias > BIASED * self.power && bias > LEAST_SPREAD * LEAST_SPREAD;
        if biased {
            for (i, line) in self.covariance.iter_mut().enumerate() {
                line[i] += RELEARN * RELEARN * SPREAD[i] * SPREAD[i];
            }
        }
        let fit = if known && !biased {
            (spread + foreseen) / (spread + foreseen + square)
        } else {
            1.0
        };
        self.spread += SPREAD_GAIN * (square.min(SPREAD_CUT * spread) - self.spread);
        self.correct(
            &ph,
            1.0 / (foreseen + ALIKE * spread / (fit * fit)),
            residual,
        );
    }

    fn gains(&self, row: &LoadVector) -> LoadVector {
        std::array::from_fn(|i| (0..N).map(|j| self.covariance[i][j] * row[j]).sum())
    }

    fn correct(&mut self, ph: &LoadVector, scale: f64, residual: f64) {
        for i in 0..N {
            self.mean[i] += ph[i] * scale * residual;
            for j in 0..N {
                self.covariance[i][j] -= ph[i] * ph[j] * scale;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_finds_what_the_motion_shows_and_keeps_what_it_does_not() {
        let mut state = LoadFilter::new();
        for n in 0..4000 {
            let (way, alpha) = (
                if n % 200 < 100 { 1.0 } else { -1.0 },
                f64::from(n % 7) - 3.0,
            );
            let row = [0.1 * alpha, 0.0, way, 1.0];
            state.update(&row, 0.3 * alpha + 0.1 * way - 0.02, 0.0, true);
        }
        let [inertia, viscous, coulomb, constant] = state.mean;
        assert!(
            (inertia - 3.0).abs() < 0.02
                && (coulomb - 0.1).abs() < 1e-3
                && (constant + 0.02).abs() < 1e-3,
            "{:?}",
            state.mean
        );
        assert!((viscous - MEAN[1]).abs() < 1e-9);
        for _ in 0..4000 {
            let row = [0.0, 0.0, 1.0, 1.0];
            state.update(&row, 0.08, 0.0, true);
        }
        assert!(
            (state.mean[0] - inertia).abs() < 1e-6 && (state.mean[2] - coulomb).abs() < 1e-3,
            "{:?}",
            state.mean
        );
    }
}
