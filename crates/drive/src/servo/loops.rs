//! The laws of the drive: encoder, position and velocity loop, current loop, and their numbers.

use super::filter::FilterState;
use super::{Measured, Servo};
use crate::config::{AntiWindup, FrictionFeedforward};
use crate::plant::{PlantInput, PlantState};
use crate::signal::{Correction, Reference};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

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

// Current PI in d and q, with decoupling, back-EMF and the limit of the voltage vector.

/// State of the current loops.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurrentState {
    pub(crate) integral_d: f64,
    pub(crate) integral_q: f64,
    /// Voltages computed but not yet applied (d, q), V.
    pub(crate) pending: [f64; 2],
    /// Electric speed as the drive knows it, rad/s; held over a servo period.
    pub(crate) electric_speed: f64,
    /// Back-EMF as the drive knows it, V; held over a servo period.
    pub(crate) back_emf: f64,
    /// Current periods since the last servo tick; counted where the command is delayed.
    pub(super) periods: u32,
    /// Whether the voltage was cut since the last servo tick.
    pub(crate) limited: bool,
    /// i_q at the last servo tick and its sum over the current periods since, A.
    pub(crate) first: f64,
    pub(crate) sum: f64,
}

impl CurrentState {
    pub(super) fn new(voltage: f64, current: f64, periods: f64) -> CurrentState {
        CurrentState {
            integral_d: 0.0,
            integral_q: voltage,
            pending: [0.0, voltage],
            electric_speed: 0.0,
            back_emf: 0.0,
            periods: 0,
            limited: false,
            first: current,
            sum: periods * current,
        }
    }

    #[inline]
    pub(super) fn voltage(
        &mut self,
        servo: &Servo,
        command: f64,
        plant: &PlantState,
    ) -> PlantInput {
        self.sum += plant.current_q;
        let gain = servo.drive.current_gain_v_per_a;
        let share = servo.current_share;
        let cross = self.electric_speed * servo.inductance;
        let (error_d, error_q) = (-plant.current_d, command - plant.current_q);
        let free_d = gain * error_d + self.integral_d - cross * plant.current_q;
        let free_q = gain * error_q + self.integral_q + cross * plant.current_d + self.back_emf;
        let limit = servo.voltage_limit;
        let (cut_d, cut_q) = if free_d * free_d + free_q * free_q > limit * limit {
            self.limited = true;
            // d first: a field current that gets out of hand would weaken or saturate the machine
            let d = free_d.clamp(-limit, limit);
            let room = (limit * limit - d * d).sqrt();
            (d, free_q.clamp(-room, room))
        } else {
            (free_d, free_q)
        };
        self.integral_d += share * (gain * error_d + (cut_d - free_d));
        self.integral_q += share * (gain * error_q + (cut_q - free_q));
        let [voltage_d, voltage_q] = if servo.drive.voltage_delay_periods == 0 {
            [cut_d, cut_q]
        } else {
            self.pending
        };
        self.pending = [cut_d, cut_q];
        PlantInput {
            voltage_d,
            voltage_q,
            load_torque: 0.0,
        }
    }
}

// Position measured in whole counts.

/// An encoder: rounds to its nearest count, halves away from zero, so that it reads the same in
/// both directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoder {
    step_rad: f64,
}

impl Encoder {
    /// Reads the position itself.
    pub const IDEAL: Encoder = Encoder { step_rad: 0.0 };

    /// An encoder of so many counts for one turn of the motor.
    pub fn with_counts(counts_per_rev: u32) -> Encoder {
        Encoder {
            step_rad: TAU / f64::from(counts_per_rev),
        }
    }

    /// Its step, rad; 0 if it reads the position itself.
    pub(crate) fn step_rad(&self) -> f64 {
        self.step_rad
    }

    /// What it shows at a position, rad.
    #[inline]
    pub fn read(&self, position: f64) -> f64 {
        if self.step_rad > 0.0 {
            (position / self.step_rad).round() * self.step_rad
        } else {
            position
        }
    }
}

// The drive's numbers for a batch, which computes with them what the drive itself does, operation
// by operation.

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
            && self.filters.is_empty()
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
