//! The load from torque, speed and acceleration: a Kalman filter over its four unknowns, which
//! drift.
//!
//! ```text
//! T/T_rated = J (a J_M/T_rated) + b_L (w/100 rad/s) + T_f sign(w) + T_const      unknowns in parts of J_M and of the rated torque
//! r = T - row x,   K = P row'/(row P row' + 10 S/g^2),   x += K r,   P -= K row P       S: spread of the residuals
//! g = (S + row P row')/(S + row P row' + r^2)                                          robust weight
//! ```
//! A motion that does not excite an unknown keeps its value, and its variance grows slowly. The
//! prior is the range of usual axes. Blocks in which the load is between the flanks or bounces do
//! not obey the model; their weight falls with their residual r.

use super::bridge::Crossed;
use super::watch::Motor;
use serde::{Deserialize, Serialize};

/// Consecutive blocks have much the same disturbances: this number counts as one. Tuned, on 96 drawn
/// cells: 10 learns more slowly and leaves one worse than none, 2 grows sure of disturbances that last
/// and leaves two.
const CORRELATED_BLOCKS: f64 = 4.0;
/// Gain of the mean square of the residuals a block: it follows within a hundred blocks. A choice:
/// faster follows single disturbances, slower lags when the load changes.
const SPREAD_GAIN: f64 = 0.01;
/// Largest squared residual that enters it, in mean squares: three deviations.
const SPREAD_CUT: f64 = 9.0;
/// Least spread of the residuals, part of the rated torque. Tuned (0.002 and 0.0007 before).
const LEAST_SPREAD: f64 = 1e-3;
/// Gain of the means of residual and squared residual a block: they follow within 25 blocks.
/// Residuals of one sign over that time show that the estimate is wrong, not the blocks. A choice:
/// faster takes single disturbances for a bias, slower leaves a wrong estimate longer in force.
const BIAS_GAIN: f64 = 0.04;
/// Part of the mean square from which on the squared mean is a bias. A choice: residuals that are
/// independent reach half of `BIAS_GAIN` (0.02) on the average.
const BIASED_SHARE: f64 = 0.3;
/// Part of the prior's standard deviations that is added to the estimate's at each biased block, so
/// that it is learned anew. A choice: 25 biased blocks open the estimate to a tenth of the prior.
const RELEARN_SHARE: f64 = 0.02;
/// Standard deviations up to which a residual is what the estimate's own variance foresees: no
/// bias, since the update that follows takes it away.
const FORESEEN_DEVIATIONS: f64 = 2.0;
/// Friction below zero by more than this contradicts the model, part of the rated torque. A choice:
/// several times the error of a friction that is zero.
const IMPOSSIBLE_SHARE: f64 = 3e-3;
/// Viscous friction below zero by more than this is that of no load, part of the rated torque at 100 rad/s. A
/// choice: more than its error while it is being learned.
const IMPOSSIBLE_VISCOUS: f64 = 0.02;
/// Unmodelled mean torque over a whole reversal, part of the rated one. A choice: larger learns
/// less from each reversal, smaller trusts cogging and uneven friction.
const UNMODELLED_SHARE: f64 = 3e-3;
/// Part of the inertia's torque that is uncertain over a reversal, for a load that bounces at its
/// ends. A choice: larger learns the inertia more slowly, smaller takes a bounce for inertia.
const BOUNCE_SHARE: f64 = 0.1;
/// Standard deviations from which on a reversal contradicts the estimate of the inertia.
const CONTRADICTION_DEVIATIONS: f64 = 3.0;
/// Largest difference of two contradictions in a row that agree, as a part of their sum: then the
/// inertia is in doubt by as much. A choice: narrower needs more reversals to put a wrong inertia
/// in doubt, wider takes two chance contradictions for one.
const AGREEMENT_SHARE: f64 = 0.3;
/// Least standard deviation of the inertia after a crossing that told it, part of it, if it was not known
/// better before. Tuned on 128 drawn cells: with one as sure as the crossing is (1 % and less) 20261124-21
/// throws its load.
const LEAST_INERTIA_DOUBT: f64 = 0.05;
/// Least inertia of a load, over that of the motor: no axis has less.
pub(super) const LEAST_INERTIA: f64 = 0.1;
/// Unknowns: inertia (over that of the motor), viscous friction (over rated torque at 100 rad/s),
/// Coulomb friction, constant torque (over the rated).
pub(super) const N: usize = 4;
/// Prior of the unknowns, the range of usual axes: mean. Viscous friction that takes more than a
/// fifth of the rated torque at the rated speed of a motor is rare.
const PRIOR_MEAN: LoadVector = [1.5, 0.03, 0.05, 0.0];
/// Prior of the unknowns: standard deviation.
const PRIOR_DEVIATION: LoadVector = [3.0, 0.1, 0.3, 0.05];
/// Viscous friction of usual axes, in the unit of the prior: mean and standard deviation. An axis that has moved at one
/// feed alone shows the sum of its frictions, and whether the one that holds a load at rest is part of it, this has to
/// say. Tuned on drawn cells, whose axes have 0 to 0.1; one with 0.12 and no other friction counts as
/// without any yet, whatever its feed.
const USUAL_VISCOUS: [f64; 2] = [0.03, 0.05];
/// Standard deviation of the drift from block to block (of the inertia, as a part of it). Friction
/// drifts most: if a constant torque were as free, half of any change of the friction would be
/// taken for one as long as the axis moves one way. Tuned with the learning within the first
/// strokes (viscous friction 3e-4 and constant torque 1e-4 before).
const DRIFT: LoadVector = [1e-3, 3e-5, 1e-4, 1e-5];
/// Speed at which viscous friction is given in parts of the rated torque, rad/s: a unit.
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
    /// How much the last reversal contradicted the inertia, 0 if it did not.
    contradiction: f64,
}

impl LoadFilter {
    pub(super) fn new() -> LoadFilter {
        let mut covariance = [[0.0; N]; N];
        for (i, row) in covariance.iter_mut().enumerate() {
            row[i] = PRIOR_DEVIATION[i] * PRIOR_DEVIATION[i];
        }
        LoadFilter {
            mean: PRIOR_MEAN,
            covariance,
            spread: 1e-3,
            bias: 0.0,
            power: 0.0,
            contradiction: 0.0,
        }
    }

    /// With unknowns that were learned before and their covariance, in SI; `unit`: SI value of one
    /// unit of each.
    pub(super) fn known(
        mean: &LoadVector,
        covariance: &[LoadVector; N],
        unit: &LoadVector,
    ) -> LoadFilter {
        LoadFilter {
            mean: std::array::from_fn(|i| mean[i] / unit[i]),
            covariance: std::array::from_fn(|i| {
                std::array::from_fn(|j| covariance[i][j] / (unit[i] * unit[j]))
            }),
            ..LoadFilter::new()
        }
    }

    /// Covariance of the unknowns in the units of each.
    pub(super) fn covariance(&self, unit: &LoadVector) -> [LoadVector; N] {
        std::array::from_fn(|i| std::array::from_fn(|j| self.covariance[i][j] * unit[i] * unit[j]))
    }

    /// Takes over what a crossing told of the unknowns (SI, as in [`LoadFilter::known`]), which began
    /// from what the filter knew then. What is known better meanwhile stays.
    pub(super) fn learn(
        &mut self,
        mean: &LoadVector,
        covariance: &[LoadVector; N],
        unit: &LoadVector,
    ) {
        let mut told = LoadFilter::known(mean, covariance, unit);
        if told.covariance[0][0] < self.covariance[0][0]
            && (0..N).all(|i| told.covariance[i][i] > 0.0)
        {
            let least = LEAST_INERTIA_DOUBT * told.mean[0];
            told.covariance[0][0] +=
                (least * least).min(self.covariance[0][0] - told.covariance[0][0]);
            (self.mean, self.covariance) = (told.mean, told.covariance);
        }
    }

    /// Standard deviation over value of the inertia.
    pub(super) fn inertia_doubt(&self) -> f64 {
        self.covariance[0][0].max(0.0).sqrt() / self.mean[0].max(LEAST_INERTIA)
    }

    /// Coulomb friction and its standard deviation, over the rated torque, of an axis whose viscous friction is that of
    /// usual ones.
    pub(super) fn usual_friction(&self) -> [f64; 2] {
        let (mean, p) = (&self.mean, &self.covariance);
        let [usual, spread] = USUAL_VISCOUS;
        // as by a measurement of the viscous friction
        let gain = p[2][1] / (p[1][1].max(0.0) + spread * spread);
        [
            mean[2] + gain * (usual - mean[1]),
            (p[2][2] - gain * p[1][2]).max(0.0).sqrt(),
        ]
    }

    /// Standard deviation of the constant torque, over the rated torque.
    pub(super) fn constant_doubt(&self) -> f64 {
        self.covariance[3][3].max(0.0).sqrt()
    }

    /// Whether a load may have this inertia and this viscous friction.
    pub(super) fn is_possible(&self) -> bool {
        self.mean[0] >= LEAST_INERTIA && self.mean[1] > -IMPOSSIBLE_VISCOUS
    }

    /// The most probable values that are physically possible: neither friction nor inertia below
    /// their bounds.
    pub(super) fn possible(&self, [least, most]: [f64; 2]) -> LoadVector {
        let (mut mean, mut p) = (self.mean, self.covariance);
        for (i, least, most) in [
            (1, 0.0, f64::INFINITY),
            (2, 0.0, f64::INFINITY),
            (0, least.max(LEAST_INERTIA), most),
        ] {
            let bound = mean[i].clamp(least, most);
            // condition the normal distribution on the bound: the other unknowns move with their
            // covariance, as by a measurement without noise
            if mean[i] != bound && p[i][i] > 0.0 {
                let (column, off): (LoadVector, f64) =
                    (std::array::from_fn(|j| p[j][i] / p[i][i]), bound - mean[i]);
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

    /// Updates with the momentum balance of a whole reversal.
    pub(super) fn cross(&mut self, said: &Crossed, motor: &Motor) {
        let (inertia, rated) = (motor.inertia, motor.rated_torque);
        // the same regressors as in steady motion, as means over the reversal
        let row = [
            said.acceleration * inertia / rated,
            said.speed / VISCOUS_SPEED,
            said.sign,
            1.0,
        ];
        let residual =
            said.torque / rated - row.iter().zip(self.mean).map(|(a, x)| a * x).sum::<f64>();
        // friction in the time whose direction is unknown: the wrong sign counts twice
        let loose = 2.0 * self.mean[2].max(0.0) * said.loose;
        let bounce = BOUNCE_SHARE * self.mean[0] * row[0];
        // variance of the innovation: unmodelled torque, unknown direction of sliding, bouncing
        let noise = UNMODELLED_SHARE * UNMODELLED_SHARE + loose * loose + bounce * bounce;
        let ph = self.gains(&row);
        let foreseen: f64 = ph.iter().zip(row).map(|(p, a)| p * a).sum();
        // innovation test; a contradiction in terms of the inertia
        let contradiction = if residual * residual
            > CONTRADICTION_DEVIATIONS * CONTRADICTION_DEVIATIONS * (foreseen + noise)
        {
            residual / row[0]
        } else {
            0.0
        };
        let before = std::mem::replace(&mut self.contradiction, contradiction);
        if contradiction * before > 0.0
            && (contradiction - before).abs()
                < AGREEMENT_SHARE * (contradiction.abs() + before.abs())
        {
            // two in a row that agree: steady stretches had made the variance too small for an
            // inertia that they did not excite
            self.covariance[0][0] += contradiction * contradiction;
        }
        let ph = self.gains(&row);
        let foreseen: f64 = ph.iter().zip(row).map(|(p, a)| p * a).sum();
        self.correct(&ph, 1.0 / (foreseen + noise), residual);
    }

    /// Updates with a block. `noise`: variance of the first regressor, whose errors would bias the
    /// inertia towards zero; `known`: enough blocks came before to recognise bad ones.
    pub(super) fn update(&mut self, row: &LoadVector, torque: f64, noise: f64, known: bool) {
        // prediction: the unknowns drift, the inertia in proportion to itself
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
        // errors in variables: the regressor's noise acts through the inertia on the residual
        let of_inertia = self.mean[0].max(LEAST_INERTIA);
        let spread = self.spread.max(LEAST_SPREAD * LEAST_SPREAD) + noise * of_inertia * of_inertia;
        let ph = self.gains(row);
        let foreseen: f64 = ph.iter().zip(row).map(|(p, a)| p * a).sum();
        // bias test before the robust weight, which would discard what contradicts a wrong estimate
        let square = residual * residual;
        let unforeseen = if square > FORESEEN_DEVIATIONS * FORESEEN_DEVIATIONS * (foreseen + spread)
        {
            residual
        } else {
            0.0
        };
        self.bias += BIAS_GAIN * (unforeseen - self.bias);
        self.power += BIAS_GAIN * (square - self.power);
        let bias = self.bias * self.bias;
        let biased = bias > BIASED_SHARE * self.power && bias > LEAST_SPREAD * LEAST_SPREAD;
        if biased {
            self.relearn_friction();
        }
        // friction below zero: what was learned contradicts itself, learn anew
        if self.mean[1].min(self.mean[2]) < -IMPOSSIBLE_SHARE {
            self.relearn_friction();
        }
        // robust weight of Geman and McClure; blocks in which the load is loose lose theirs
        let fit = if known && !biased {
            (spread + foreseen) / (spread + foreseen + square)
        } else {
            1.0
        };
        // scale of the residuals, with outliers cut
        self.spread += SPREAD_GAIN * (square.min(SPREAD_CUT * spread) - self.spread);
        self.correct(
            &ph,
            1.0 / (foreseen + CORRELATED_BLOCKS * spread / (fit * fit)),
            residual,
        );
    }

    /// Opens what is known of friction and constant torque. Not of the inertia: loads that bounce
    /// would be taken for a new one, and reversals show by themselves that it is wrong (`cross`).
    fn relearn_friction(&mut self) {
        for (i, line) in self.covariance.iter_mut().enumerate().skip(1) {
            line[i] += RELEARN_SHARE * RELEARN_SHARE * PRIOR_DEVIATION[i] * PRIOR_DEVIATION[i];
        }
    }

    /// P row.
    fn gains(&self, row: &LoadVector) -> LoadVector {
        std::array::from_fn(|i| (0..N).map(|j| self.covariance[i][j] * row[j]).sum())
    }

    /// Kalman update with gain `scale P row`.
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
        assert!((viscous - PRIOR_MEAN[1]).abs() < 1e-9);
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

    /// Coulomb friction and its standard deviation after strokes to and fro at one speed, over 100 rad/s.
    fn at_one_feed(speed: f64, viscous: f64, coulomb: f64) -> [f64; 2] {
        let mut state = LoadFilter::new();
        for n in 0..4000 {
            let way = if n % 200 < 100 { 1.0 } else { -1.0 };
            let torque = way * (viscous * speed + coulomb);
            state.update(&[0.0, way * speed, way, 1.0], torque, 0.0, true);
        }
        state.usual_friction()
    }

    #[test]
    fn one_feed_shows_whether_friction_holds_a_load_of_usual_axes() {
        for speed in [0.1, 0.5, 2.0] {
            // most of it is more than the viscous friction of usual axes
            let coulomb = 0.12 * speed + 0.01;
            let [found, deviation] = at_one_feed(speed, 0.03, coulomb);
            assert!(
                (found - coulomb).abs() < deviation && found - 2.0 * deviation > 5e-3,
                "{speed}: {found} {deviation}"
            );
            // none of it holds the load
            let [found, deviation] = at_one_feed(speed, 0.1, 0.0);
            assert!(
                found - 2.0 * deviation < 5e-3,
                "{speed}: {found} {deviation}"
            );
        }
    }

    #[test]
    fn a_crossing_makes_no_inertia_surer_than_it_can() {
        let unit = [1.0; N];
        let told = |deviation: f64| {
            let mut covariance = [[0.0; N]; N];
            for (i, row) in covariance.iter_mut().enumerate() {
                row[i] = if i == 0 { deviation * deviation } else { 1e-4 };
            }
            covariance
        };
        let mut filter = LoadFilter::new();
        filter.learn(&[2.0, 0.0, 0.1, 0.0], &told(1e-3), &unit);
        assert!((filter.inertia_doubt() - LEAST_INERTIA_DOUBT).abs() < 1e-5);
        assert!((filter.covariance[2][2] - 1e-4).abs() < 1e-12);
        // what was known better stays as well known
        let mut filter = LoadFilter::known(&[2.0, 0.0, 0.1, 0.0], &told(0.02), &unit);
        filter.learn(&[2.1, 0.0, 0.2, 0.0], &told(1e-3), &unit);
        assert!((filter.covariance[0][0] - 4e-4).abs() < 1e-12 && filter.mean[2] == 0.2);
    }
}
