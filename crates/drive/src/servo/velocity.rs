//! Position P and velocity PI.

use super::filter::FilterState;
use super::{Measured, Servo};
use crate::config::{AntiWindup, FrictionFeedforward};
use crate::signal::Correction;
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
    /// Those of the last and the last but one, A; in force where the command is delayed.
    pub earlier_commands: [f64; 2],
    /// Filters of the current command.
    pub filters: FilterState,
}

impl VelocityState {
    pub(super) fn new(servo: &Servo, position: f64, reference: f64, current: f64) -> VelocityState {
        VelocityState {
            position,
            reference,
            integral: current,
            current_command: current,
            earlier_commands: [current; 2],
            filters: servo.filters.settled(current),
        }
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
        let position_error =
            (reference.position + correction.position) - (measured.position - correction.feedback);
        let wanted = drive.position_gain_per_s * position_error
            + drive.velocity_feedforward * mean_velocity
            + correction.velocity;
        let mut torque = drive.acceleration_feedforward * servo.told_inertia * mean_acceleration
            + correction.torque;
        if let Some(friction) = &drive.friction_feedforward {
            torque += friction.torque((next.position - reference.position) / period);
        }

        let error = wanted - measured.velocity;
        let push = drive.velocity_gain_a_s_per_rad * error;
        let free = servo.filters.step(
            &mut self.filters,
            push + self.integral + torque / servo.torque_constant,
        );
        let cut = free.clamp(-drive.current_limit_a, drive.current_limit_a);
        self.integrate(servo, push, error * cut > 0.0, cut - free, voltage_limited);
        self.earlier_commands = [self.current_command, self.earlier_commands[0]];
        self.current_command = cut;
        cut != free
    }

    /// The integral's step; `outward` says that the error asks for more of the torque that there
    /// is.
    #[inline]
    fn integrate(
        &mut self,
        servo: &Servo,
        push: f64,
        outward: bool,
        cut: f64,
        voltage_limited: bool,
    ) {
        let share = servo.velocity_share;
        self.integral += match servo.drive.anti_windup {
            AntiWindup::BackCalculation => {
                share
                    * (if voltage_limited && outward {
                        0.0
                    } else {
                        push
                    } + cut)
            }
            AntiWindup::Conditional if outward && (voltage_limited || cut != 0.0) => 0.0,
            AntiWindup::Conditional | AntiWindup::None => share * push,
        };
    }
}

impl FrictionFeedforward {
    /// Torque at a reference velocity, N m.
    #[inline]
    fn torque(&self, velocity: f64) -> f64 {
        let smoothed =
            velocity / (velocity * velocity + self.smoothing_rad_s * self.smoothing_rad_s).sqrt();
        self.coulomb_nm * smoothed + self.viscous_nm_s_per_rad * velocity
    }
}
