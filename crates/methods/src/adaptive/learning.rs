//! Learning the load from the torque that the motor gives beyond its own need.
//!
//! Over 8 ms at a time, each 4 ms, in which the axis moves steadily (15 ms after any reversal,
//! change of flank or crossing), means weighted with a triangle, so that the mean acceleration is
//! an exact second difference of positions and a shaft's ringing cancels:
//! ```text
//! T = K_t i - J_M alpha - b_v w - F_M sign(w)              measured, motor side
//! T = J_L alpha + b_L w + T_f sign(w) + T_const
//! ```
//! An acceleration that does not stand out of the encoder's steps by three standard deviations
//! counts as none: as a regressor that is noise, it would make the inertia too small and too sure.
//!
//! Over a reversal, from one steady stretch to the next, the balance of momentum holds whatever
//! happens between (`bridge`).
//!
//! The four unknowns are those of `load_filter`.

use super::bridge::{BLOCK, Block, Bridge};
use super::load_filter::{LEAST_INERTIA, LoadFilter, LoadVector, N, VISCOUS_SPEED};
use super::watch::Motor;
use lostmotion_base::Clock;
use lostmotion_drive::Signals;
use lostmotion_drive::twin::{LoadModel, Twin, TwinState};
use serde::{Deserialize, Serialize};

/// Ticks that have to pass after a reversal or a change of flank: 15 ms, three periods of a shaft's
/// ringing.
const SETTLE: u32 = 60;
/// Standard deviations by which an acceleration has to stand out.
const CLEAR: f64 = 4.0;
/// Blocks before the load is believed.
const ENOUGH: u32 = 8;
/// Part of its friction below which the torque behind the motor shows a load that is loose.
const LOOSE: f64 = 0.5;
/// A load slower than this does not count as moving, rad/s.
const MOVING_RAD_S: f64 = 0.02;
/// Inertia of the load over that of the motor, at most.
const MOST_INERTIA: f64 = 100.0;

/// The filter, and the block under way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LearningState {
    filter: LoadFilter,
    blocks: u32,
    /// Whether the load has been learned.
    pub(super) known: bool,
    calm: u32,
    twin_speed: f64,
    block: Block,
    before: Option<Block>,
    bridge: Option<Bridge>,
}

/// What is seen of the load at a tick: the torque behind the motor (N m), and whether the load may
/// be between its flanks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) torque: f64,
    pub(super) disturbed: bool,
}

impl LearningState {
    pub(super) fn new() -> LearningState {
        LearningState {
            filter: LoadFilter::new(),
            blocks: 0,
            known: false,
            calm: 0,
            twin_speed: 0.0,
            block: Block::default(),
            before: None,
            bridge: None,
        }
    }

    /// Covariance of inertia, viscous friction, Coulomb friction and constant torque, SI.
    pub(super) fn covariance(&self, inertia: f64, rated: f64) -> [LoadVector; N] {
        self.filter.covariance(&units(inertia, rated))
    }

    /// Standard deviation over value of the inertia.
    pub(super) fn inertia_doubt(&self) -> f64 {
        self.filter.inertia_doubt()
    }

    /// Coulomb friction that the load may have, N m.
    pub(super) fn most_friction(&self, load: &LoadModel, rated: f64) -> f64 {
        load.coulomb + self.filter.friction_doubt() * rated
    }

    /// One tick; changes the load at the end of a block.
    pub(super) fn step(
        &mut self,
        twin: &Twin,
        now: &TwinState,
        signals: &Signals,
        seen: Seen,
        motor: &Motor,
        load: &mut LoadModel,
    ) {
        let speed = now.plant.load_velocity;
        let disturbed =
            seen.disturbed || speed.abs() < MOVING_RAD_S || speed * self.twin_speed < 0.0;
        self.twin_speed = speed;
        self.calm = if disturbed {
            0
        } else {
            (self.calm + 1).min(SETTLE)
        };
        let position = signals.motor_position;
        if self.calm < SETTLE {
            let rest = std::mem::replace(&mut self.block, Block::start(position));
            if let Some(before) = self.before.take() {
                self.bridge = Some(Bridge::start(before, &rest));
            } else if let Some(bridge) = &mut self.bridge {
                bridge.skip(&rest);
            }
            // at rest friction holds whatever torque there is
            let loose = speed.abs() < MOVING_RAD_S
                || seen.torque.abs() < LOOSE * self.filter.mean[2] * motor.rated_torque;
            self.bridge = self
                .bridge
                .take()
                .and_then(|mut bridge| bridge.push(signals, speed, loose).then_some(bridge));
            return;
        }
        self.block.push(signals);
        if self.block.ticks >= BLOCK {
            let last = std::mem::replace(&mut self.block, Block::start(position));
            if let Some(bridge) = self.bridge.take() {
                self.filter.cross(
                    &bridge.end(&last, position, motor, twin.motor_coulomb()),
                    motor,
                );
            }
            if let Some(before) = self.before.replace(last) {
                self.take(twin, [&before, &last], position, motor, load);
            }
        }
    }

    /// Takes two blocks in a row, and where the motor is at their end.
    fn take(
        &mut self,
        twin: &Twin,
        [first, second]: [&Block; 2],
        position: f64,
        motor: &Motor,
        load: &mut LoadModel,
    ) {
        let (count, inertia, rated) = (f64::from(BLOCK), motor.inertia, motor.rated_torque);
        let span = count * Clock::SERVO.period_s();
        let speed = (second.position - first.position + (second.way - first.way) / count) / span;
        let acceleration =
            ((position - second.position) - (second.position - first.position)) / (span * span);
        let own =
            inertia * acceleration + motor.viscous * speed + twin.motor_coulomb() * speed.signum();
        let torque = motor.torque_constant * (first.rising + second.falling) / count - own;
        // the variance of a second difference is six times that of a position
        let noise = 6.0 * motor.noise * motor.noise / (span * span * span * span);
        let seen = if acceleration * acceleration > CLEAR * CLEAR * noise {
            acceleration
        } else {
            0.0
        };
        let row = [
            seen * inertia / rated,
            speed / VISCOUS_SPEED,
            speed.signum(),
            1.0,
        ];
        self.filter.update(
            &row,
            torque / rated,
            noise * (inertia / rated) * (inertia / rated),
            self.known,
        );
        self.blocks = self.blocks.saturating_add(1);
        if self.blocks >= ENOUGH {
            let (unit, mean) = (units(inertia, rated), self.filter.possible());
            load.inertia = mean[0].clamp(LEAST_INERTIA, MOST_INERTIA) * unit[0];
            load.viscous = mean[1].max(0.0) * unit[1];
            load.coulomb = mean[2].max(0.0) * unit[2];
            load.constant = mean[3] * unit[3];
            self.known = true;
        }
    }
}

/// SI value of one unit of each unknown.
fn units(inertia: f64, rated: f64) -> LoadVector {
    [inertia, rated / VISCOUS_SPEED, rated, rated]
}
