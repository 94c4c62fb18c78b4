//! Where something hits the shaft: two momentum observers of the torque behind the motor, a quick
//! one and a slow one, part.

use super::model::Motor;
use super::window::Sample;
use lostmotion_drive::Signals;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Corners, rad/s.
const CORNERS_RAD_S: [f64; 2] = [1500.0, 60.0];
/// How far they have to part: part of the rated torque, and standard deviations of the quick one's
/// noise.
const PART: f64 = 0.01;
const NOISES: f64 = 8.0;
/// A blow is a difference so many times what it was, which fades with this time, s.
const JUMP: f64 = 1.5;
const FADES_S: f64 = 0.01;
/// Samples kept from before a blow and in all.
pub(super) const BEFORE: usize = 10;
pub(super) const LENGTH: usize = 250;

/// Observers, the last samples, and the window under way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Watch {
    momentum: [f64; 2],
    torque: [f64; 2],
    envelope: f64,
    recent: VecDeque<Sample>,
    window: Option<Vec<Sample>>,
    ticks: u32,
}

impl Watch {
    /// One tick. Gives a window that is complete.
    pub(super) fn step(&mut self, motor: &Motor, signals: &Signals) -> Option<Vec<Sample>> {
        let speed = signals.motor_velocity;
        let friction = motor.viscous * speed
            + if speed == 0.0 {
                0.0
            } else {
                motor.coulomb * speed.signum()
            };
        let drive = motor.torque_constant * signals.mean_current - friction;
        for ((momentum, torque), corner) in self
            .momentum
            .iter_mut()
            .zip(&mut self.torque)
            .zip(CORNERS_RAD_S)
        {
            *momentum += motor.period_s * (drive - *torque);
            *torque = corner * (*momentum - motor.inertia * speed);
        }
        let apart = (self.torque[0] - self.torque[1]).abs();
        let noise = CORNERS_RAD_S[0] * motor.inertia * motor.noise * std::f64::consts::SQRT_2
            / motor.period_s;
        let blow =
            apart > (PART * motor.rated_torque).max(NOISES * noise) && apart > JUMP * self.envelope;
        self.envelope = apart.max(self.envelope * (1.0 - motor.period_s / FADES_S));
        let sample = Sample {
            position: signals.motor_position,
            current: signals.current,
            mean: signals.mean_current,
        };
        if self.recent.len() >= BEFORE {
            self.recent.pop_front();
        }
        self.recent.push_back(sample);
        self.ticks = self.ticks.saturating_add(1);
        if blow {
            self.window = Some(self.recent.iter().copied().collect());
            return None;
        }
        let window = self.window.as_mut()?;
        window.push(sample);
        if window.len() < LENGTH {
            return None;
        }
        self.window.take()
    }
}
