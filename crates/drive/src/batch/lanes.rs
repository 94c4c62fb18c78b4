//! The numbers of a group of axes, quantity by quantity.

use crate::plant::{Electric, Lane, PlantState, Watch};
use crate::runner::{CurrentLoop, Monitored, Seen};
use crate::servo::{CurrentNumbers, TickNumbers};
use crate::signal::{AxisSample, Correction, Engagement, MotorSample};

/// Axes in a group: the widest vector. With twice as many, what they carry from tick to tick leaves the processor's
/// nearest memory, which takes longer than the waiting for results that a second vector would fill.
pub const WIDTH: usize = 8;

/// One quantity of all lanes.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Row(pub(super) [f64; WIDTH]);

impl Default for Row {
    fn default() -> Row {
        Row([0.0; WIDTH])
    }
}

/// States of the current loops and the plants.
#[derive(Clone, Debug, Default)]
pub(super) struct PeriodStates {
    pub(super) current_q: Row,
    pub(super) current_d: Row,
    pub(super) gap_angle: Row,
    pub(super) motor: Row,
    pub(super) load: Row,
    pub(super) position: Row,
    pub(super) integral_d: Row,
    pub(super) integral_q: Row,
    pub(super) pending_d: Row,
    pub(super) pending_q: Row,
    /// Sum of i_q for the drive's mean.
    pub(super) sum: Row,
    pub(super) peak: Row,
}

/// What is held over a servo tick.
#[derive(Clone, Debug, Default)]
pub(super) struct Inputs {
    pub(super) command: Row,
    pub(super) cross: Row,
    pub(super) back_emf: Row,
    pub(super) load_torque: Row,
}

/// What stays as long as a lane's mode does: see [`Lane`].
#[derive(Clone, Debug, Default)]
pub(super) struct PeriodNumbers {
    pub(super) current_loop: CurrentNumbers<Row>,
    pub(super) electric: Electric<Row>,
    pub(super) columns: [[Row; 4]; 7],
    pub(super) travel: [Row; 7],
    pub(super) torque_constant: Row,
    pub(super) offset: Row,
    pub(super) friction: [Row; 2],
    pub(super) shaft: [Row; 2],
    pub(super) third: Row,
    pub(super) range: [Row; 2],
    pub(super) push: [Row; 2],
    pub(super) push_margin: Row,
    pub(super) sliding: [Row; 2],
    pub(super) speed_margin: [Row; 2],
    pub(super) holding: [Row; 2],
    pub(super) torque_margin: Row,
    pub(super) watches: [Watch<Row>; 2],
}

/// A group of axes as the kernel sees it.
#[derive(Clone, Debug)]
pub(super) struct Lanes {
    pub(super) states: PeriodStates,
    pub(super) inputs: Inputs,
    pub(super) numbers: PeriodNumbers,
    pub(super) loops: Loops,
    /// Whether a lane may not pull, or stands: the kernel looks for that only then.
    pub(super) any_pushing: bool,
    pub(super) any_stuck: bool,
    modes: [Option<Lane>; WIDTH],
    load_constant: [f64; WIDTH],
}

impl Lanes {
    /// Lanes of zeros, in which nothing ever happens.
    pub(super) fn new(servo_ticks: usize) -> Lanes {
        let (low, high) = (Row([f64::NEG_INFINITY; WIDTH]), Row([f64::INFINITY; WIDTH]));
        // with bounds at infinity a lane without an axis never stops the kernel
        let numbers = PeriodNumbers {
            current_loop: CurrentNumbers {
                limit_squared: high,
                ..CurrentNumbers::default()
            },
            range: [low, high],
            push_margin: low,
            speed_margin: [low; 2],
            holding: [high; 2],
            ..PeriodNumbers::default()
        };
        Lanes {
            states: PeriodStates::default(),
            inputs: Inputs::default(),
            numbers,
            loops: Loops::new(servo_ticks),
            any_pushing: false,
            any_stuck: false,
            modes: [None; WIDTH],
            load_constant: [0.0; WIDTH],
        }
    }

    /// Takes up the numbers of an axis in the mode it is in; false if it has to step by itself.
    pub(super) fn describe(&mut self, lane: usize, axis: &CurrentLoop<'_>) -> bool {
        // a command delayed into the servo period and a plant that is not linear have no product
        // with a table
        let (Some(servo), Some(plant)) = (
            axis.servo.current_numbers(),
            axis.plant.lane(axis.plant_state.mode),
        ) else {
            return false;
        };
        // the lane's column of every row
        let n = &mut self.numbers;
        n.current_loop.put(servo, in_lane(lane));
        n.electric.put(&plant.electric, in_lane(lane));
        self.load_constant[lane] = plant.load_constant;
        for (rows, column) in n.columns.iter_mut().zip(plant.columns) {
            put(rows, lane, column);
        }
        put(&mut n.travel, lane, plant.travel);
        n.torque_constant.0[lane] = plant.known.torque_constant;
        n.offset.0[lane] = plant.known.offset;
        put(&mut n.friction, lane, plant.known.friction);
        put(&mut n.shaft, lane, plant.known.shaft.into());
        n.third.0[lane] = plant.known.look.third;
        put(&mut n.range, lane, plant.known.look.range);
        put(&mut n.push, lane, plant.known.look.push);
        n.push_margin.0[lane] = plant.known.look.push_margin;
        put(&mut n.sliding, lane, plant.known.look.sliding);
        put(&mut n.speed_margin, lane, plant.known.look.speed_margin);
        put(&mut n.holding, lane, plant.known.look.holding);
        n.torque_margin.0[lane] = plant.known.look.torque_margin;
        for (rows, watch) in n.watches.iter_mut().zip(&plant.watches) {
            rows.put(watch, in_lane(lane));
        }
        // kept to see whether an event has left the mode that these numbers belong to
        self.modes[lane] = Some(plant);
        // looks that no lane needs are left out of the kernel
        self.any_pushing = self.modes.iter().flatten().any(|lane| lane.known.pushes);
        self.any_stuck = self.modes.iter().flatten().any(|lane| lane.known.stands);
        true
    }

    /// Whether an axis is still in the mode it was described in.
    pub(super) fn knows(&self, lane: usize, axis: &CurrentLoop<'_>) -> bool {
        self.modes[lane].is_some_and(|lane| lane.known.mode == axis.plant_state.mode)
    }

    /// Takes up what is held over a servo tick.
    pub(super) fn hold(&mut self, lane: usize, axis: &CurrentLoop<'_>) {
        let current = &axis.servo_state.current;
        self.inputs.command.0[lane] = axis.servo_state.velocity.current_command;
        self.inputs.cross.0[lane] =
            current.electric_speed * self.numbers.current_loop.inductance.0[lane];
        self.inputs.back_emf.0[lane] = current.back_emf;
        self.inputs.load_torque.0[lane] = self.load_constant[lane] + axis.load_torque;
    }

    /// Takes up the whole drive of an axis; false if it is not a plain one.
    pub(super) fn settle(&mut self, lane: usize, axis: &CurrentLoop<'_>) -> bool {
        self.inputs.back_emf.0[lane] = axis.servo_state.current.back_emf;
        self.gather(lane, axis);
        self.loops.take_up(lane, axis)
    }

    /// Takes up a setpoint of a resident lane.
    pub(super) fn refer(&mut self, lane: usize, axis: &CurrentLoop<'_>) {
        self.inputs.load_torque.0[lane] = self.load_constant[lane] + axis.load_torque;
        self.loops.refer(lane, axis);
    }

    /// Brings a resident axis up to date for a period of its own.
    pub(super) fn hand_over(&self, lane: usize, axis: &mut CurrentLoop<'_>) {
        self.loops
            .hand_over(lane, self.inputs.back_emf.0[lane], axis);
        self.scatter(lane, axis);
    }

    /// Gives a resident axis everything back.
    pub(super) fn release(&self, lane: usize, axis: &mut CurrentLoop<'_>) {
        self.hand_over(lane, axis);
        self.loops.give_back(lane, axis);
    }

    /// What the drive of a resident lane has seen.
    pub(super) fn seen(&self, lane: usize) -> Seen {
        let (s, drive) = (&self.states, &self.loops.states);
        Seen {
            motor_position: drive.seen.0[lane],
            motor_velocity: self.loops.velocity.0[lane],
            current: s.current_q.0[lane],
            mean_current: self.loops.mean_current.0[lane],
            saturated: drive.saturated.0[lane] > 0.0,
            load_position: s.position.0[lane],
        }
    }

    /// All signals of a resident lane at a servo tick, with what its compensator answers.
    #[inline(always)]
    pub(super) fn sample(
        &self,
        lane: usize,
        index: usize,
        axis: &CurrentLoop<'_>,
        correction: &Correction,
    ) -> AxisSample {
        let s = &self.states;
        // the mode is the axis' own: events are taken by itself
        let state = PlantState {
            current_q: s.current_q.0[lane],
            current_d: s.current_d.0[lane],
            gap_angle: s.gap_angle.0[lane],
            motor_velocity: s.motor.0[lane],
            load_velocity: s.load.0[lane],
            load_position: s.position.0[lane],
            ..*axis.plant_state
        };
        let reference = axis.references.get(index).copied().unwrap_or_default();
        AxisSample::of(reference, axis.plant, &state, correction)
    }

    /// The motor of a resident lane at a servo tick.
    pub(super) fn motor(&self, lane: usize) -> MotorSample {
        let (s, gap_angle) = (&self.states, self.states.gap_angle.0[lane]);
        // the mode is the one that the lane's numbers belong to: events take up others
        let contact = self.modes[lane]
            .as_ref()
            .map(|plant| plant.known.mode.contact);
        MotorSample {
            position: s.position.0[lane] + gap_angle,
            current: s.current_q.0[lane],
            torque: self.numbers.torque_constant.0[lane] * s.current_q.0[lane],
            engagement: contact.map_or(Engagement::Gap, |contact| contact.engagement(gap_angle)),
        }
    }

    /// What the control of a resident lane watches at the end of a setpoint, with the lane's own
    /// count of ticks at a limit on top of those before; the sum of the squared current starts anew.
    #[inline(always)]
    pub(super) fn monitored(&mut self, lane: usize, servo_ticks: u32, before: u64) -> Monitored {
        let (drive, units) = (&self.loops.states, self.loops.units.0[lane]);
        let [position, _, _, feedback] = &self.loops.correction;
        let current_squared = self.loops.current_squares.0[lane] / f64::from(servo_ticks);
        self.loops.current_squares.0[lane] = 0.0;
        Monitored {
            reference: drive.reference.0[lane] * units,
            motor: drive.seen.0[lane] * units,
            correction: (position.0[lane] + feedback.0[lane]) * units,
            current_squared,
            saturated_samples: before + self.loops.saturated_ticks.0[lane] as u64,
            peak_current_a: self.states.peak.0[lane],
        }
    }

    /// Takes up an axis' state.
    pub(super) fn gather(&mut self, lane: usize, axis: &CurrentLoop<'_>) {
        let (s, plant, current) = (
            &mut self.states,
            &*axis.plant_state,
            &axis.servo_state.current,
        );
        s.current_q.0[lane] = plant.current_q;
        s.current_d.0[lane] = plant.current_d;
        s.gap_angle.0[lane] = plant.gap_angle;
        s.motor.0[lane] = plant.motor_velocity;
        s.load.0[lane] = plant.load_velocity;
        s.position.0[lane] = plant.load_position;
        s.integral_d.0[lane] = current.integral_d;
        s.integral_q.0[lane] = current.integral_q;
        s.pending_d.0[lane] = current.pending[0];
        s.pending_q.0[lane] = current.pending[1];
        s.sum.0[lane] = current.sum;
    }

    /// Gives an axis its state back.
    pub(super) fn scatter(&self, lane: usize, axis: &mut CurrentLoop<'_>) {
        let (s, plant, current) = (
            &self.states,
            &mut *axis.plant_state,
            &mut axis.servo_state.current,
        );
        plant.current_q = s.current_q.0[lane];
        plant.current_d = s.current_d.0[lane];
        plant.gap_angle = s.gap_angle.0[lane];
        plant.motor_velocity = s.motor.0[lane];
        plant.load_velocity = s.load.0[lane];
        plant.load_position = s.position.0[lane];
        current.integral_d = s.integral_d.0[lane];
        current.integral_q = s.integral_q.0[lane];
        current.pending = [s.pending_d.0[lane], s.pending_q.0[lane]];
        current.sum = s.sum.0[lane];
    }
}

/// Puts a number of an axis into its lane.
pub(super) fn in_lane(lane: usize) -> impl Fn(&mut Row, &f64) {
    move |row, value| row.0[lane] = *value
}

fn put<const N: usize>(rows: &mut [Row; N], lane: usize, values: [f64; N]) {
    for (row, value) in rows.iter_mut().zip(values) {
        row.0[lane] = value;
    }
}

// Measuring, position and velocity loop of a group of axes, quantity by quantity.
//
// A lane that is *resident* has its whole drive here between two setpoints; the axis itself is
// brought up to date where it steps by itself, and when it is released.

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
    pub(super) numbers: TickNumbers<Row>,
    /// Axis units in a rad of the motor.
    pub(super) units: Row,
    pub(super) states: DriveStates,
    /// Position and velocity references of the present setpoint.
    pub(super) references: Vec<[Row; 2]>,
    /// Measured speed, and the mean current.
    pub(super) velocity: Row,
    pub(super) mean_current: Row,
    /// Sum of i_d^2 + i_q^2 over the servo ticks of the present setpoint.
    pub(super) current_squares: Row,
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
        self.numbers.put(numbers, in_lane(lane));
        self.units.0[lane] = axis.units_per_motor_rad;
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
        self.current_squares.0[lane] = 0.0;
        // a compensator that is never asked (`none`) corrects by zero
        self.correction.iter_mut().for_each(|row| row.0[lane] = 0.0);
        // a voltage cut before this push still holds back the integral at the next tick
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
