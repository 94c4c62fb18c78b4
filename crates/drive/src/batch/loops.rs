//! Measuring, position and velocity loop of a group of axes, quantity by quantity.
//!
//! A lane that is *resident* has its whole drive here between two setpoints; the axis itself is
//! brought up to date where it steps by itself, and when it is released.

use super::lanes::{Row, WIDTH};
use crate::runner::CurrentLoop;
use crate::servo::TickNumbers;
use crate::signal::Correction;

/// Numbers of the drive: see `servo::numbers`.
#[derive(Clone, Debug, Default)]
pub(super) struct DriveNumbers {
    pub(super) period: Row,
    pub(super) encoder_step: Row,
    pub(super) current_steps: Row,
    pub(super) position_gain: Row,
    pub(super) velocity_feedforward: Row,
    pub(super) inertia_feedforward: Row,
    pub(super) velocity_gain: Row,
    pub(super) velocity_share: Row,
    pub(super) torque_constant: Row,
    pub(super) current_limit: Row,
    pub(super) pole_pairs: Row,
    pub(super) back_emf: Row,
    pub(super) inductance: Row,
    pub(super) units: Row,
}

impl DriveNumbers {
    /// Takes up a drive; not its inductance and unit.
    pub(super) fn put(&mut self, lane: usize, numbers: &TickNumbers) {
        self.period.0[lane] = numbers.period;
        self.encoder_step.0[lane] = numbers.encoder_step;
        self.current_steps.0[lane] = numbers.current_steps;
        self.position_gain.0[lane] = numbers.position_gain;
        self.velocity_feedforward.0[lane] = numbers.velocity_feedforward;
        self.inertia_feedforward.0[lane] = numbers.inertia_feedforward;
        self.velocity_gain.0[lane] = numbers.velocity_gain;
        self.velocity_share.0[lane] = numbers.velocity_share;
        self.torque_constant.0[lane] = numbers.torque_constant;
        self.current_limit.0[lane] = numbers.current_limit;
        self.pole_pairs.0[lane] = numbers.pole_pairs;
        self.back_emf.0[lane] = numbers.back_emf;
    }
}

/// States of the drive.
#[derive(Clone, Debug, Default)]
pub(super) struct DriveStates {
    /// Encoder position and position reference at the last tick.
    pub(super) seen: Row,
    pub(super) reference: Row,
    pub(super) integral: Row,
    pub(super) command: Row,
    pub(super) earlier: [Row; 2],
    /// i_q at the last tick.
    pub(super) first: Row,
    pub(super) electric_speed: Row,
    /// 1 where the voltage, or anything, was cut since the last tick, else 0.
    pub(super) limited: Row,
    pub(super) saturated: Row,
}

/// What a tick takes and gives.
#[derive(Clone, Debug, Default)]
pub(super) struct Loops {
    pub(super) numbers: DriveNumbers,
    pub(super) states: DriveStates,
    /// Position and velocity references of the present setpoint.
    pub(super) references: Vec<[Row; 2]>,
    /// Measured speed, and the mean current.
    pub(super) velocity: Row,
    pub(super) mean_current: Row,
    /// Position, velocity, torque and feedback of the corrections.
    pub(super) correction: [Row; 4],
    /// Load and reference in the axis' unit at each tick.
    pub(super) shown: Vec<[Row; 2]>,
    /// Ticks at a limit.
    pub(super) saturated_ticks: Row,
}

impl Loops {
    /// For so many servo ticks in a setpoint.
    pub(super) fn new(servo_ticks: usize) -> Loops {
        let none = || [Row::default(), Row::default()];
        let (references, shown) = (
            (0..=servo_ticks).map(|_| none()).collect(),
            (0..servo_ticks).map(|_| none()).collect(),
        );
        Loops {
            references,
            shown,
            ..Loops::default()
        }
    }

    /// Takes up an axis; false if its drive is not a plain one.
    pub(super) fn take_up(&mut self, lane: usize, axis: &CurrentLoop<'_>) -> bool {
        let Some(numbers) = axis.servo.tick_numbers() else {
            return false;
        };
        self.numbers.put(lane, &numbers);
        self.numbers.units.0[lane] = axis.units_per_motor_rad;
        let (s, velocity, current) = (
            &mut self.states,
            &axis.servo_state.velocity,
            &axis.servo_state.current,
        );
        s.seen.0[lane] = velocity.position;
        s.reference.0[lane] = velocity.reference;
        s.integral.0[lane] = velocity.integral;
        s.command.0[lane] = velocity.current_command;
        (s.earlier[0].0[lane], s.earlier[1].0[lane]) =
            (velocity.earlier_commands[0], velocity.earlier_commands[1]);
        s.first.0[lane] = current.first;
        s.electric_speed.0[lane] = current.electric_speed;
        self.saturated_ticks.0[lane] = 0.0;
        self.correction.iter_mut().for_each(|row| row.0[lane] = 0.0);
        self.note_limits(lane, axis);
        true
    }

    /// Takes up what the periods that an axis took by itself have met.
    pub(super) fn note_limits(&mut self, lane: usize, axis: &CurrentLoop<'_>) {
        self.states.limited.0[lane] = f64::from(u8::from(axis.servo_state.current.limited));
        self.states.saturated.0[lane] = f64::from(u8::from(axis.servo_state.saturated));
    }

    /// Takes up the references of a setpoint.
    pub(super) fn refer(&mut self, lane: usize, axis: &CurrentLoop<'_>) {
        for ([position, velocity], reference) in self.references.iter_mut().zip(axis.references) {
            position.0[lane] = reference.position;
            velocity.0[lane] = reference.velocity;
        }
    }

    pub(super) fn correct(&mut self, lane: usize, by: &Correction) {
        for (row, value) in
            self.correction
                .iter_mut()
                .zip([by.position, by.velocity, by.torque, by.feedback])
        {
            row.0[lane] = value;
        }
    }

    /// Gives an axis what its drive holds over a tick.
    pub(super) fn hand_over(&self, lane: usize, back_emf: f64, axis: &mut CurrentLoop<'_>) {
        let s = &self.states;
        axis.servo_state.velocity.current_command = s.command.0[lane];
        axis.servo_state.current.electric_speed = s.electric_speed.0[lane];
        axis.servo_state.current.back_emf = back_emf;
        axis.servo_state.current.limited = s.limited.0[lane] > 0.0;
        axis.servo_state.saturated = s.saturated.0[lane] > 0.0;
    }

    /// Gives an axis the rest of its drive.
    pub(super) fn give_back(&self, lane: usize, axis: &mut CurrentLoop<'_>) {
        let (s, velocity) = (&self.states, &mut axis.servo_state.velocity);
        velocity.position = s.seen.0[lane];
        velocity.reference = s.reference.0[lane];
        velocity.integral = s.integral.0[lane];
        velocity.earlier_commands = [s.earlier[0].0[lane], s.earlier[1].0[lane]];
        axis.servo_state.current.first = s.first.0[lane];
    }

    /// Counts the ticks at a limit.
    pub(super) fn count(&mut self) {
        for lane in 0..WIDTH {
            self.saturated_ticks.0[lane] += self.states.saturated.0[lane];
        }
    }
}
