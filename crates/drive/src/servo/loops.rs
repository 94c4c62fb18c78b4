//! The laws of the drive: encoder, position and velocity loop, current loop, and their numbers.
//!
//! Each law stands once, over a [`Number`]: for the drive of one axis here, and for a batch.

use super::filter::FilterState;
use super::{Measured, Servo};
use crate::config::{AntiWindup, FrictionFeedforward};
use crate::number::numbers;
use crate::plant::{PlantInput, PlantState};
use crate::signal::{Correction, Reference};
use lostmotion_base::Number;
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
        let seen = VelocityInput {
            position: reference.position,
            velocity: reference.velocity,
            next_velocity: next.velocity,
            last_position: self.reference,
            measured_position: measured.position,
            measured_velocity: measured.velocity,
            correction: correction.outputs(),
            integral: self.integral,
            voltage_limited,
        };
        let mut options = DriveOptions {
            servo,
            filters: &mut self.filters,
            // friction fed forward acts in the coming period, so it follows the travel in it
            coming_travel: next.position - reference.position,
        };
        let VelocityOutput {
            command,
            within_limit,
            integral,
        } = servo.numbers.command(&seen, &mut options);
        self.reference = reference.position;
        self.integral = integral;
        // a delayed command takes effect when newer ones are already computed
        self.earlier_commands = [self.current_command, self.earlier_commands[0]];
        self.current_command = command;
        !within_limit
    }
}

numbers! {
    /// What measuring and the position and velocity loop compute with.
    TickNumbers {
        /// Servo period, s.
        period,
        /// Step of the encoder, rad; 0 if it reads the position itself.
        encoder_step,
        /// Current periods in a servo period.
        current_steps,
        /// Position gain, 1/s.
        position_gain,
        /// Share of the reference's velocity that is fed forward.
        velocity_feedforward,
        /// Share of the acceleration, times the inertia that the drive was told, kg m2.
        inertia_feedforward,
        /// Velocity gain, A s/rad.
        velocity_gain,
        /// Servo period over the velocity loop's integral time.
        velocity_share,
        /// N m/A.
        torque_constant,
        /// A.
        current_limit,
        /// Pairs of poles.
        pole_pairs,
        /// V s/rad.
        back_emf,
    }
}

/// What the position and velocity loop sees at a servo tick.
#[derive(Clone, Copy)]
pub(crate) struct VelocityInput<N: Number> {
    /// Reference now.
    pub(crate) position: N,
    pub(crate) velocity: N,
    pub(crate) next_velocity: N,
    /// Position reference at the last servo tick.
    pub(crate) last_position: N,
    /// What the encoder shows, and its difference over the period.
    pub(crate) measured_position: N,
    pub(crate) measured_velocity: N,
    /// Position, velocity, torque and feedback of the correction.
    pub(crate) correction: [N; 4],
    pub(crate) integral: N,
    /// Whether the voltage was cut since the last servo tick.
    pub(crate) voltage_limited: N::Mask,
}

/// What it answers.
#[derive(Clone, Copy)]
pub(crate) struct VelocityOutput<N: Number> {
    /// Current command, A.
    pub(crate) command: N,
    /// Whether it is what was computed; false where the limit cut it.
    pub(crate) within_limit: N::Mask,
    /// Next integral part, A.
    pub(crate) integral: N,
}

/// What a drive may have on top of the plain velocity loop: by default nothing, with
/// back-calculation.
pub(crate) trait VelocityOptions<N: Number> {
    /// The torque fed forward, with what the drive was told of friction added.
    #[inline(always)]
    fn with_friction(&self, torque: N) -> N {
        torque
    }

    /// The current command through the drive's filters.
    #[inline(always)]
    fn filter(&mut self, current: N) -> N {
        current
    }

    /// The integral's step from the proportional part `push`, the part of the command that was cut
    /// off (negative where a positive one was), and whether the error asks for more of the torque
    /// that there is.
    #[inline(always)]
    fn integral_step(
        &self,
        share: N,
        push: N,
        cut: N,
        outward: N::Mask,
        voltage_limited: N::Mask,
    ) -> N {
        back_calculation(share, push, cut, outward, voltage_limited)
    }
}

/// A drive without filters and friction feed-forward.
pub(crate) struct PlainDrive;

impl<N: Number> VelocityOptions<N> for PlainDrive {}

/// Those of one axis' drive.
struct DriveOptions<'a> {
    servo: &'a Servo,
    filters: &'a mut FilterState,
    /// What the reference travels in the coming period, in which the torque acts, rad.
    coming_travel: f64,
}

impl VelocityOptions<f64> for DriveOptions<'_> {
    #[inline(always)]
    fn with_friction(&self, torque: f64) -> f64 {
        match &self.servo.drive.friction_feedforward {
            Some(friction) => {
                torque + friction.torque(self.coming_travel / self.servo.numbers.period)
            }
            None => torque,
        }
    }

    #[inline(always)]
    fn filter(&mut self, current: f64) -> f64 {
        self.servo.filters.step(self.filters, current)
    }

    #[inline(always)]
    fn integral_step(
        &self,
        share: f64,
        push: f64,
        cut: f64,
        outward: bool,
        voltage_limited: bool,
    ) -> f64 {
        match self.servo.drive.anti_windup {
            AntiWindup::BackCalculation => {
                back_calculation(share, push, cut, outward, voltage_limited)
            }
            AntiWindup::Conditional if outward && (voltage_limited || cut != 0.0) => 0.0,
            AntiWindup::Conditional | AntiWindup::None => share * push,
        }
    }
}

/// Back-calculation: what the limit cut off is taken from the integral, too. Where the voltage was
/// at its limit the command was not cut, so there the proportional part waits instead.
#[inline(always)]
fn back_calculation<N: Number>(
    share: N,
    push: N,
    cut: N,
    outward: N::Mask,
    voltage_limited: N::Mask,
) -> N {
    share * (N::choose(voltage_limited & outward, push.zero(), push) + cut)
}

impl<N: Number> TickNumbers<N> {
    /// Position and velocity loop of a servo tick: see the head of [`crate::servo`].
    #[inline(always)]
    pub(crate) fn command(
        &self,
        seen: &VelocityInput<N>,
        options: &mut impl VelocityOptions<N>,
    ) -> VelocityOutput<N> {
        let [by_position, by_velocity, by_torque, by_feedback] = seen.correction;
        // means over the periods in which each acts: the velocity fed forward over the encoder's
        // last one, the acceleration over the coming one
        let mean_velocity = (seen.position - seen.last_position) / self.period;
        let mean_acceleration = (seen.next_velocity - seen.velocity) / self.period;
        let position_error = (seen.position + by_position) - (seen.measured_position - by_feedback);
        let wanted = self.position_gain * position_error
            + self.velocity_feedforward * mean_velocity
            + by_velocity;
        // torques fed forward become current through the torque constant below
        let torque =
            options.with_friction(self.inertia_feedforward * mean_acceleration + by_torque);

        // velocity PI; the filters see the whole command, feed-forward included
        let error = wanted - seen.measured_velocity;
        let push = self.velocity_gain * error;
        let free = options.filter(push + seen.integral + torque / self.torque_constant);
        let command = free.clamp(-self.current_limit, self.current_limit);
        // the error asks for more of the torque that is already limited: integrating it would wind
        // up
        let outward = push.zero().less(error * command);
        let step = options.integral_step(
            self.velocity_share,
            push,
            command - free,
            outward,
            seen.voltage_limited,
        );
        VelocityOutput {
            command,
            within_limit: command.equals(free),
            integral: seen.integral + step,
        }
    }

    /// Speed that the drive computes from two readings of the encoder, rad/s.
    #[inline(always)]
    pub(crate) fn speed(&self, position: N, last: N) -> N {
        (position - last) / self.period
    }

    /// Mean i_q over a servo period by the trapezoidal rule, A: from the sum over its current
    /// periods, and i_q at its start and end.
    #[inline(always)]
    pub(crate) fn mean_current(&self, sum: N, start: N, end: N) -> N {
        (sum + sum.constant(0.5) * (end - start)) / self.current_steps
    }
}

impl FrictionFeedforward {
    /// Torque at a reference velocity, N m.
    #[inline]
    fn torque(&self, velocity: f64) -> f64 {
        // the sign of the velocity without its jump at rest
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
    pub(super) fn new(voltage: f64, back_emf: f64, current: f64, periods: f64) -> CurrentState {
        CurrentState {
            integral_d: 0.0,
            integral_q: voltage,
            // the back-EMF is fed forward besides the integral
            pending: [0.0, voltage + back_emf],
            electric_speed: 0.0,
            back_emf: 0.0,
            periods: 0,
            limited: false,
            first: current,
            sum: periods * current,
        }
    }

    #[inline(always)]
    pub(super) fn voltage(
        &mut self,
        servo: &Servo,
        command: f64,
        plant: &PlantState,
    ) -> PlantInput {
        // sampled where the loop samples it, for the mean over the servo period
        self.sum += plant.current_q;
        let numbers = &servo.current_numbers;
        let period = CurrentPeriod {
            command,
            cross: self.electric_speed * numbers.inductance,
            back_emf: self.back_emf,
            current: [plant.current_d, plant.current_q],
            integral: [self.integral_d, self.integral_q],
            pending: self.pending,
        };
        let free = numbers.free_voltage(&period);
        // a cut is also reported to the velocity loop, whose integral has to wait
        let (cut_d, cut_q) = if numbers.exceeds_limit(free) {
            self.limited = true;
            cut_voltage(free, servo.voltage_limit)
        } else {
            (free[0], free[1])
        };
        let CurrentOutput {
            voltage: [voltage_d, voltage_q],
            integral: [integral_d, integral_q],
        } = numbers.output(&period, free, [cut_d, cut_q]);
        self.integral_d = integral_d;
        self.integral_q = integral_q;
        // computed now, applied a period later where the drive has that delay
        self.pending = [cut_d, cut_q];
        PlantInput {
            voltage_d,
            voltage_q,
            load_torque: 0.0,
        }
    }
}

/// The voltage vector within the limit, d and q. d first: a field current that is not held down would
/// weaken or saturate the machine.
#[inline]
fn cut_voltage([free_d, free_q]: [f64; 2], limit: f64) -> (f64, f64) {
    let d = free_d.clamp(-limit, limit);
    // what is left for q on the circle
    let room = (limit * limit - d * d).sqrt();
    (d, free_q.clamp(-room, room))
}

numbers! {
    /// What the current loops compute with.
    CurrentNumbers {
        /// V/A.
        gain,
        /// Current period over integral time.
        share,
        /// Of a phase, H.
        inductance,
        /// Square of the largest voltage, V2.
        limit_squared,
        /// 1 where a voltage acts a period after it was computed, else 0.
        delayed,
    }
}

/// What the current loops see in a period, d before q.
#[derive(Clone, Copy)]
pub(crate) struct CurrentPeriod<N> {
    /// Of i_q, A; that of i_d is 0.
    pub(crate) command: N,
    /// Electric speed times inductance, ohm.
    pub(crate) cross: N,
    pub(crate) back_emf: N,
    pub(crate) current: [N; 2],
    pub(crate) integral: [N; 2],
    /// Voltages computed in the last period.
    pub(crate) pending: [N; 2],
}

/// What they answer.
#[derive(Clone, Copy)]
pub(crate) struct CurrentOutput<N> {
    /// Voltages that act in the coming period, V.
    pub(crate) voltage: [N; 2],
    /// Next integral parts, V.
    pub(crate) integral: [N; 2],
}

impl<N: Number> CurrentNumbers<N> {
    /// PI in d and q with the coupling of the axes and the back-EMF fed forward, before the limit.
    #[inline(always)]
    pub(crate) fn free_voltage(&self, period: &CurrentPeriod<N>) -> [N; 2] {
        let ([push_d, push_q], [current_d, current_q]) = (self.push(period), period.current);
        [
            push_d + period.integral[0] - period.cross * current_q,
            push_q + period.integral[1] + period.cross * current_d + period.back_emf,
        ]
    }

    /// The proportional parts.
    #[inline(always)]
    fn push(&self, period: &CurrentPeriod<N>) -> [N; 2] {
        let [current_d, current_q] = period.current;
        [
            self.gain * -current_d,
            self.gain * (period.command - current_q),
        ]
    }

    /// Whether a voltage vector is longer than the inverter can give.
    #[inline(always)]
    pub(crate) fn exceeds_limit(&self, [d, q]: [N; 2]) -> N::Mask {
        self.limit_squared.less(d * d + q * q)
    }

    /// The voltage that acts now and the integrals with back-calculation, once the voltages have
    /// been cut.
    #[inline(always)]
    pub(crate) fn output(
        &self,
        period: &CurrentPeriod<N>,
        free: [N; 2],
        cut: [N; 2],
    ) -> CurrentOutput<N> {
        let push = self.push(period);
        let delayed = self.delayed.zero().less(self.delayed);
        CurrentOutput {
            voltage: [
                N::choose(delayed, period.pending[0], cut[0]),
                N::choose(delayed, period.pending[1], cut[1]),
            ],
            integral: [
                period.integral[0] + self.share * (push[0] + (cut[0] - free[0])),
                period.integral[1] + self.share * (push[1] + (cut[1] - free[1])),
            ],
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
        counted(position, self.step_rad)
    }
}

/// A position in whole counts of an encoder, or itself where the step is 0.
#[inline(always)]
pub(crate) fn counted<N: Number>(position: N, step: N) -> N {
    let counts = (position / step).round() * step;
    N::choose(step.zero().less(step), counts, position)
}

// Which drives a batch can step.

impl Servo {
    /// Numbers of the current loops.
    pub(crate) fn current_loop(&self) -> &CurrentNumbers<f64> {
        &self.current_numbers
    }

    /// Numbers of the current loops for a batch; `None` where the command changes within a servo
    /// period.
    pub(crate) fn current_numbers(&self) -> Option<&CurrentNumbers<f64>> {
        (self.drive.command_delay_periods == 0).then_some(&self.current_numbers)
    }

    /// Numbers of measuring and of position and velocity loop for a batch; `None` unless the drive
    /// is a [`PlainDrive`] whose command stays over a servo period.
    pub(crate) fn tick_numbers(&self) -> Option<&TickNumbers<f64>> {
        let drive = &self.drive;
        let plain = drive.command_delay_periods == 0
            && self.filters.is_empty()
            && drive.friction_feedforward.is_none()
            && matches!(drive.anti_windup, AntiWindup::BackCalculation);
        plain.then_some(&self.numbers)
    }
}
