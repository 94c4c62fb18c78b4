//! Learning the load from the torque that the motor gives beyond its own need.
//!
//! Over blocks of 4 ms in which the axis moves steadily (30 ms after any reversal, change of flank, crossing or saturation):
//! ```text
//! T = K_t mean(i) - J_M alpha - b_v w - F_M sign(w)        measured, motor side
//! T = J_L alpha_L + b_L w + T_f sign(w) + T_const          alpha_L from the gapless twin: free of encoder noise
//! ```
//! Weighted least squares with forgetting. Blocks in which the load hangs between the flanks or bounces do not obey the
//! second line; their weight 1/(1 + r^2/s^2)^2 falls with their residual r over the spread s of the others.

use super::Signals;
use super::twin::{LoadModel, Twin, TwinState};
use lostmotion_base::Clock;
use serde::{Deserialize, Serialize};

/// Ticks of a block: 4 ms.
const BLOCK: u32 = 16;
/// Ticks that have to pass after a reversal or a change of flank: 30 ms.
const SETTLE: u32 = 120;
/// Blocks before the load is believed, and how many of them in each direction.
const ENOUGH: f64 = 40.0;
const EACH_WAY: f64 = 10.0;
/// Forgetting per block: a memory of 1000 blocks, 4 s of motion.
const KEEP: f64 = 1.0 - 1.0 / 1000.0;
/// The spread of the residuals follows within a hundred blocks; a residual counts three times the spread at most.
const SPREAD_GAIN: f64 = 0.01;
const SPREAD_CUT: f64 = 9.0;
/// A load slower than this does not count as moving, rad/s.
const MOVING_RAD_S: f64 = 0.02;
/// Unit of the viscous friction in the equations, so that the unknowns are of like size.
const VISCOUS_UNIT: f64 = 0.01;
/// Inertia of the load over that of the motor.
const INERTIA_RATIO: [f64; 2] = [0.02, 100.0];
/// Unknowns: inertia, viscous, Coulomb, constant.
const N: usize = 4;

/// Sums of the least squares problem, and the block under way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct LearningState {
    normal: [[f64; N]; N],
    right: [f64; N],
    /// Blocks taken in the negative and in the positive direction.
    ways: [f64; 2],
    /// Mean square of the residuals, (N m)^2.
    spread: f64,
    /// Whether the load has been learned.
    pub(super) known: bool,
    calm: u32,
    twin_torque: f64,
    twin_speed: f64,
    current: f64,
    block: Block,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Block {
    ticks: u32,
    current_sum: f64,
    position: f64,
    velocity: f64,
    load_velocity: f64,
}

impl LearningState {
    /// One tick; changes the load at the end of a block.
    pub(super) fn step(&mut self, twin: &Twin, now: &TwinState, signals: &Signals, crossing: bool, load: &mut LoadModel) {
        let speed = now.plant.load_velocity;
        let reverses = speed * self.twin_speed < 0.0 || now.torque * self.twin_torque < 0.0;
        let disturbed = crossing || signals.saturated || speed.abs() < MOVING_RAD_S || reverses;
        let mean_current = 0.5 * (self.current + signals.current);
        (self.twin_speed, self.twin_torque, self.current) = (speed, now.torque, signals.current);
        self.calm = if disturbed { 0 } else { (self.calm + 1).min(SETTLE) };
        if self.calm < SETTLE {
            self.block.ticks = 0;
            return;
        }
        if self.block.ticks == 0 {
            let (position, velocity) = (signals.motor_position, signals.motor_velocity);
            self.block = Block { ticks: 0, current_sum: 0.0, position, velocity, load_velocity: speed };
        } else {
            self.block.current_sum += mean_current;
        }
        self.block.ticks += 1;
        if self.block.ticks > BLOCK {
            self.take_block(twin, speed, signals, load);
            self.block.ticks = 0;
        }
    }

    fn take_block(&mut self, twin: &Twin, load_velocity: f64, signals: &Signals, load: &mut LoadModel) {
        let span = f64::from(BLOCK) * Clock::SERVO.period_s();
        let speed = (signals.motor_position - self.block.position) / span;
        let acceleration = (signals.motor_velocity - self.block.velocity) / span;
        let inertia = twin.motor_inertia();
        let own = inertia * acceleration + twin.motor_viscous() * speed + twin.motor_coulomb() * speed.signum();
        let torque = twin.torque_constant() * self.block.current_sum / f64::from(BLOCK) - own;
        let row = [(load_velocity - self.block.load_velocity) / span * inertia, speed * VISCOUS_UNIT, speed.signum(), 1.0];
        let weight = self.weight(torque, &row, load, inertia);
        for (line, a) in self.normal.iter_mut().zip(row) {
            for (entry, b) in line.iter_mut().zip(row) {
                *entry = KEEP * *entry + weight * a * b;
            }
        }
        for (entry, a) in self.right.iter_mut().zip(row) {
            *entry = KEEP * *entry + weight * a * torque;
        }
        self.ways[usize::from(speed > 0.0)] += 1.0;
        if self.ways[0] + self.ways[1] >= ENOUGH && self.ways.iter().all(|way| *way >= EACH_WAY) {
            let [ratio, viscous, coulomb, constant] = solve(&self.normal, &self.right);
            load.inertia = ratio.clamp(INERTIA_RATIO[0], INERTIA_RATIO[1]) * inertia;
            load.viscous = (viscous * VISCOUS_UNIT).max(0.0);
            load.coulomb = coulomb.max(0.0);
            load.constant = constant;
            self.known = true;
        }
    }

    fn weight(&mut self, torque: f64, row: &[f64; N], load: &LoadModel, inertia: f64) -> f64 {
        if !self.known {
            self.spread += torque * torque / ENOUGH;
            return 1.0;
        }
        let known = [load.inertia / inertia, load.viscous / VISCOUS_UNIT, load.coulomb, load.constant];
        let residual = torque - row.iter().zip(known).map(|(a, x)| a * x).sum::<f64>();
        let spread = self.spread.max(1e-12);
        let square = residual * residual;
        self.spread += SPREAD_GAIN * (square.min(SPREAD_CUT * spread) - self.spread);
        let fit = spread / (spread + square);
        fit * fit
    }
}

/// Solves by Cholesky, with so slight a pull to zero that only what the motion does not excite feels it.
fn solve(normal: &[[f64; N]; N], right: &[f64; N]) -> [f64; N] {
    let mut l = [[0.0; N]; N];
    let mut x = [0.0; N];
    for i in 0..N {
        for j in 0..i {
            let sum: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            l[i][j] = (normal[i][j] - sum) / l[j][j];
        }
        let sum: f64 = (0..i).map(|k| l[i][k] * l[i][k]).sum();
        l[i][i] = (normal[i][i] * (1.0 + 1e-6) + 1e-12 - sum).max(1e-12).sqrt();
    }
    for i in 0..N {
        let sum: f64 = (0..i).map(|k| l[i][k] * x[k]).sum();
        x[i] = (right[i] - sum) / l[i][i];
    }
    for i in (0..N).rev() {
        let sum: f64 = (i + 1..N).map(|k| l[k][i] * x[k]).sum();
        x[i] = (x[i] - sum) / l[i][i];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_solves_normal_equations() {
        let normal = [[4.0, 1.0, 0.0, 0.5], [1.0, 3.0, 0.2, 0.0], [0.0, 0.2, 2.0, 0.1], [0.5, 0.0, 0.1, 1.0]];
        let wanted = [1.0, -2.0, 0.5, 3.0];
        let right = normal.map(|row| row.iter().zip(wanted).map(|(a, x)| a * x).sum::<f64>());
        for (x, wanted) in solve(&normal, &right).into_iter().zip(wanted) {
            assert!((x - wanted).abs() < 1e-5, "{x} {wanted}");
        }
    }

    #[test]
    fn what_is_not_excited_stays_zero() {
        assert_eq!(solve(&[[0.0; N]; N], &[0.0; N]), [0.0; N]);
    }
}
