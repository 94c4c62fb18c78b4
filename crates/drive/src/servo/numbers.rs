//! The drive's numbers for a batch, which computes with them what the drive itself does, operation
//! by operation.

use super::Servo;
use crate::config::AntiWindup;

/// What [`Servo::voltage`] computes with as long as no voltage is cut: see `current`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CurrentNumbers {
    pub(crate) gain: f64,
    pub(crate) share: f64,
    pub(crate) inductance: f64,
    pub(crate) limit_squared: f64,
    pub(crate) delayed: bool,
}

/// What [`Servo::measure`], [`Servo::mean_current`] and [`Servo::command`] compute with in a plain
/// drive.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TickNumbers {
    /// Servo period, s.
    pub(crate) period: f64,
    /// Of the encoder, rad; 0 if it reads the position itself.
    pub(crate) encoder_step: f64,
    pub(crate) current_steps: f64,
    pub(crate) position_gain: f64,
    pub(crate) velocity_feedforward: f64,
    /// Of the acceleration, times the inertia that the drive was told.
    pub(crate) inertia_feedforward: f64,
    pub(crate) velocity_gain: f64,
    pub(crate) velocity_share: f64,
    pub(crate) torque_constant: f64,
    pub(crate) current_limit: f64,
    pub(crate) pole_pairs: f64,
    pub(crate) back_emf: f64,
}

impl Servo {
    /// Numbers of the current loops for a batch; none where the command changes within a servo
    /// period.
    pub(crate) fn current_numbers(&self) -> Option<CurrentNumbers> {
        (self.drive.command_delay_periods == 0).then_some(CurrentNumbers {
            gain: self.drive.current_gain_v_per_a,
            share: self.current_share,
            inductance: self.inductance,
            limit_squared: self.voltage_limit * self.voltage_limit,
            delayed: self.drive.voltage_delay_periods != 0,
        })
    }

    /// Numbers of measuring and of position and velocity loop for a batch; none where the drive has
    /// filters, friction feed-forward, another anti-windup than back-calculation, or a command that
    /// changes within a servo period.
    pub(crate) fn tick_numbers(&self) -> Option<TickNumbers> {
        let drive = &self.drive;
        let plain = drive.command_delay_periods == 0
            && self.filters.len() == 0
            && drive.friction_feedforward.is_none()
            && matches!(drive.anti_windup, AntiWindup::BackCalculation);
        plain.then_some(TickNumbers {
            period: self.servo_period_s,
            encoder_step: self.encoder.step_rad(),
            current_steps: f64::from(self.current_steps),
            position_gain: drive.position_gain_per_s,
            velocity_feedforward: drive.velocity_feedforward,
            inertia_feedforward: drive.acceleration_feedforward * self.told_inertia,
            velocity_gain: drive.velocity_gain_a_s_per_rad,
            velocity_share: self.velocity_share,
            torque_constant: self.torque_constant,
            current_limit: drive.current_limit_a,
            pole_pairs: self.pole_pairs,
            back_emf: self.back_emf,
        })
    }
}
