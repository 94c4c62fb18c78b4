//! Learning the load from the torque that the motor gives beyond its own need.
//!
//! Over 8 ms at a time, each 4 ms, in which the axis moves steadily (15 ms after any reversal, change of flank or crossing), means weighted
//! with a triangle, so that the mean acceleration is an exact second difference of positions and a shaft's ringing cancels:
//! ```text
//! T = K_t i - J_M alpha - b_v w - F_M sign(w)              measured, motor side
//! T = J_L alpha + b_L w + T_f sign(w) + T_const
//! ```
//! An acceleration that does not stand out of the encoder's steps by three standard deviations counts as none: as a regressor that is noise, it
//! would make the inertia too small and too sure.
//!
//! A Kalman filter over the four unknowns, which drift: what a motion does not excite keeps its value and slowly becomes less sure. Before the
//! first block stands what any axis may have. Blocks in which the load hangs between the flanks or bounces do not obey the second line; their
//! weight 1/(1 + r^2/s^2)^2 falls with their residual r over the spread s of the others.

use super::super::Signals;
use super::super::twin::{LoadModel, Twin, TwinState};
use super::block::{BLOCK, Block};
use super::watch::Motor;
use lostmotion_base::Clock;
use serde::{Deserialize, Serialize};

/// Ticks that have to pass after a reversal or a change of flank: 15 ms, three periods of a shaft's ringing.
const SETTLE: u32 = 60;
/// Standard deviations by which an acceleration has to stand out.
const CLEAR: f64 = 3.0;
/// Blocks before the load is believed.
const ENOUGH: u32 = 8;
/// Blocks follow each other with much the same disturbances: so many count as one.
const ALIKE: f64 = 10.0;
/// The spread of the residuals follows within a hundred blocks; a residual counts three times the spread at most.
const SPREAD_GAIN: f64 = 0.01;
const SPREAD_CUT: f64 = 9.0;
/// Least spread, part of the rated torque.
const LEAST_SPREAD: f64 = 2e-3;
/// Residuals that agree in their sign over 25 blocks tell that what is known is wrong, not that the blocks are: then it is learned anew, with this
/// part of what any axis may have added to the standard deviations at each block.
const BIAS_GAIN: f64 = 0.04;
const BIASED: f64 = 0.3;
const RELEARN: f64 = 0.02;
/// A load slower than this does not count as moving, rad/s.
const MOVING_RAD_S: f64 = 0.02;
/// Inertia of the load over that of the motor.
const LEAST_INERTIA: f64 = 0.1;
const MOST_INERTIA: f64 = 100.0;
/// Unknowns: inertia (over that of the motor), viscous friction (over rated torque at 100 rad/s), Coulomb friction, constant torque (over the rated).
const N: usize = 4;
/// What any axis may have: mean and standard deviation, and the drift from block to block. Viscous friction that takes more than a fifth of the rated
/// torque at the rated speed of a motor is rare. Of what drifts, friction does most: were a constant torque as free, half of any change of the friction would
/// be taken for one as long as the axis moves one way.
const MEAN: Vector = [1.5, 0.03, 0.05, 0.0];
const SPREAD: Vector = [3.0, 0.1, 0.3, 0.05];
const DRIFT: Vector = [1e-3, 3e-5, 1e-4, 1e-5];
const VISCOUS_SPEED: f64 = 100.0;

type Vector = [f64; N];

/// The filter, and the block under way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LearningState {
    mean: Vector,
    covariance: [[f64; N]; N],
    blocks: u32,
    /// Mean square of the residuals over the rated torque.
    spread: f64,
    /// Mean of the last residuals and of their squares, over the rated torque.
    bias: f64,
    power: f64,
    /// Whether the load has been learned.
    pub(super) known: bool,
    calm: u32,
    twin_speed: f64,
    block: Block,
    before: Option<Block>,
}

impl LearningState {
    pub(super) fn new() -> LearningState {
        let mut covariance = [[0.0; N]; N];
        for (i, row) in covariance.iter_mut().enumerate() {
            row[i] = SPREAD[i] * SPREAD[i];
        }
        LearningState {
            mean: MEAN,
            covariance,
            blocks: 0,
            spread: 1e-3,
            bias: 0.0,
            power: 0.0,
            known: false,
            calm: 0,
            twin_speed: 0.0,
            block: Block::default(),
            before: None,
        }
    }

    /// Covariance of inertia, viscous friction, Coulomb friction and constant torque, SI.
    pub(super) fn covariance(&self, inertia: f64, rated: f64) -> [Vector; N] {
        let unit = units(inertia, rated);
        std::array::from_fn(|i| std::array::from_fn(|j| self.covariance[i][j] * unit[i] * unit[j]))
    }

    /// Standard deviation over value of the inertia.
    pub(super) fn inertia_doubt(&self) -> f64 {
        self.covariance[0][0].max(0.0).sqrt() / self.mean[0].max(LEAST_INERTIA)
    }

    /// One tick; changes the load at the end of a block. `disturbed`: the load may be between its flanks.
    pub(super) fn step(&mut self, twin: &Twin, now: &TwinState, signals: &Signals, disturbed: bool, motor: &Motor, load: &mut LoadModel) {
        let speed = now.plant.load_velocity;
        let disturbed = disturbed || speed.abs() < MOVING_RAD_S || speed * self.twin_speed < 0.0;
        self.twin_speed = speed;
        self.calm = if disturbed { 0 } else { (self.calm + 1).min(SETTLE) };
        let position = signals.motor_position;
        if self.calm < SETTLE {
            (self.block, self.before) = (Block::start(position), None);
            return;
        }
        self.block.push(signals);
        if self.block.ticks >= BLOCK {
            let last = std::mem::replace(&mut self.block, Block::start(position));
            if let Some(before) = self.before.replace(last) {
                self.take(twin, [&before, &last], position, motor, load);
            }
        }
    }

    /// Takes two blocks in a row, and where the motor is at their end.
    fn take(&mut self, twin: &Twin, [first, second]: [&Block; 2], position: f64, motor: &Motor, load: &mut LoadModel) {
        let (count, inertia, rated) = (f64::from(BLOCK), motor.inertia, motor.rated_torque);
        let span = count * Clock::SERVO.period_s();
        let speed = (second.position - first.position + (second.way - first.way) / count) / span;
        let acceleration = ((position - second.position) - (second.position - first.position)) / (span * span);
        let own = inertia * acceleration + motor.viscous * speed + twin.motor_coulomb() * speed.signum();
        let torque = motor.torque_constant * (first.rising + second.falling) / count - own;
        // the variance of a second difference is six times that of a position
        let stands_out = acceleration * acceleration * span * span * span * span > 6.0 * CLEAR * CLEAR * motor.noise * motor.noise;
        let seen = if stands_out { acceleration } else { 0.0 };
        self.update(&[seen * inertia / rated, speed / VISCOUS_SPEED, speed.signum(), 1.0], torque / rated);
        self.blocks = self.blocks.saturating_add(1);
        if self.blocks >= ENOUGH {
            let (unit, mean) = (units(inertia, rated), self.possible());
            load.inertia = mean[0].clamp(LEAST_INERTIA, MOST_INERTIA) * unit[0];
            load.viscous = mean[1].max(0.0) * unit[1];
            load.coulomb = mean[2].max(0.0) * unit[2];
            load.constant = mean[3] * unit[3];
            self.known = true;
        }
    }

    /// The most likely values that are possible: no friction or inertia below zero.
    fn possible(&self) -> Vector {
        let (mut mean, mut p) = (self.mean, self.covariance);
        for (i, least) in [(1, 0.0), (2, 0.0), (0, LEAST_INERTIA)] {
            if mean[i] < least && p[i][i] > 0.0 {
                let (column, off): (Vector, f64) = (std::array::from_fn(|j| p[j][i] / p[i][i]), least - mean[i]);
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

    fn update(&mut self, row: &Vector, torque: f64) {
        for (i, line) in self.covariance.iter_mut().enumerate() {
            line[i] += DRIFT[i] * DRIFT[i] * if i == 0 { self.mean[0] * self.mean[0] } else { 1.0 };
        }
        let residual = torque - row.iter().zip(self.mean).map(|(a, x)| a * x).sum::<f64>();
        let spread = self.spread.max(LEAST_SPREAD * LEAST_SPREAD);
        let ph: Vector = std::array::from_fn(|i| (0..N).map(|j| self.covariance[i][j] * row[j]).sum());
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
        let fit = if self.known && !biased { (spread + foreseen) / (spread + foreseen + square) } else { 1.0 };
        self.spread += SPREAD_GAIN * (square.min(SPREAD_CUT * spread) - self.spread);
        let scale = 1.0 / (foreseen + ALIKE * spread / (fit * fit));
        for i in 0..N {
            self.mean[i] += ph[i] * scale * residual;
            for j in 0..N {
                self.covariance[i][j] -= ph[i] * ph[j] * scale;
            }
        }
    }
}

/// SI value of one unit of each unknown.
fn units(inertia: f64, rated: f64) -> Vector {
    [inertia, rated / VISCOUS_SPEED, rated, rated]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_finds_what_the_motion_shows_and_keeps_what_it_does_not() {
        let mut state = LearningState::new();
        for n in 0..4000 {
            let (way, alpha) = (if n % 200 < 100 { 1.0 } else { -1.0 }, f64::from(n % 7) - 3.0);
            let row = [0.1 * alpha, 0.0, way, 1.0];
            state.update(&row, 0.3 * alpha + 0.1 * way - 0.02);
        }
        let [inertia, viscous, coulomb, constant] = state.mean;
        assert!((inertia - 3.0).abs() < 0.02 && (coulomb - 0.1).abs() < 1e-3 && (constant + 0.02).abs() < 1e-3, "{:?}", state.mean);
        assert!((viscous - MEAN[1]).abs() < 1e-9);
        for _ in 0..4000 {
            let row = [0.0, 0.0, 1.0, 1.0];
            state.update(&row, 0.08);
        }
        assert!((state.mean[0] - inertia).abs() < 1e-6 && (state.mean[2] - coulomb).abs() < 1e-3, "{:?}", state.mean);
    }
}
