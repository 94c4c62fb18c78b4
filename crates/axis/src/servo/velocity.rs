//! Position P and velocity PI.

use super::{Measured, Servo};
use crate::compensation::Correction;
use crate::signal::Reference;
use serde::{Deserialize, Serialize};

/// State of the position and velocity loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VelocityState {
    /// Encoder position at the last servo tick, rad.
    pub position: f64,
    /// Position reference at the last servo tick, rad.
    pub reference: f64,
    /// Integral part of the velocity PI, A.
    pub integral: f64,
    /// Current command of the present servo period, A.
    pub current_command: f64,
}

impl VelocityState {
    pub(super) fn new(position: f64, reference: f64, current: f64) -> VelocityState {
        VelocityState { position, reference, integral: current, current_command: current }
    }

    /// Returns whether the current command was cut.
    #[inline]
    pub(super) fn command(
        &mut self,
        servo: &Servo,
        reference: &Reference,
        next: &Reference,
        measured: &Measured,
        correction: &Correction,
        voltage_limited: bool,
    ) -> bool {
        let (drive, period) = (&servo.drive, servo.servo_period_s);
        let mean_velocity = (reference.position - self.reference) / period;
        let mean_acceleration = (next.velocity - reference.velocity) / period;
        self.reference = reference.position;

        let position_error = (reference.position + correction.position) - (measured.position - correction.feedback);
        let wanted = drive.position_gain_per_s * position_error + drive.velocity_feedforward * mean_velocity + correction.velocity;
        let torque = drive.acceleration_feedforward * servo.told_inertia * mean_acceleration + correction.torque;

        let error = wanted - measured.velocity;
        let gain = drive.velocity_gain_a_s_per_rad;
        let free = gain * error + self.integral + torque / servo.torque_constant;
        let cut = free.clamp(-drive.current_limit_a, drive.current_limit_a);
        let share = period / drive.velocity_time_s;
        let blocked = voltage_limited && error * cut > 0.0;
        self.integral += share * (if blocked { 0.0 } else { gain * error } + (cut - free));
        self.current_command = cut;
        cut != free
    }
}
