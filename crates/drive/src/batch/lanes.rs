//! The numbers of a group of axes, quantity by quantity.

use super::loops::Loops;
use crate::plant::Lane;
use crate::runner::CurrentLoop;
use crate::runner::Seen;

/// Axes in a group: two of the widest vectors, so that the processor has something to do while one
/// waits for its own results.
pub const WIDTH: usize = 16;

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
pub(super) struct States {
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

/// What stays as long as a lane's mode does: see [`Lane`] and `servo::numbers`.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbers {
    pub(super) gain: Row,
    pub(super) share: Row,
    pub(super) limit_squared: Row,
    /// 1 where the voltage is delayed, else 0.
    pub(super) delayed: Row,
    pub(super) columns: [[Row; 4]; 7],
    pub(super) travel: [Row; 7],
    pub(super) decay_d: Row,
    pub(super) gain_d: Row,
    pub(super) pole_pairs: Row,
    pub(super) inductance: Row,
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
}

/// A group of axes as the kernel sees it.
#[derive(Clone, Debug)]
pub(super) struct Lanes {
    pub(super) states: States,
    pub(super) inputs: Inputs,
    pub(super) numbers: Numbers,
    pub(super) loops: Loops,
    /// Whether a lane may not pull, or stands: the kernel looks for that only then.
    pub(super) any_pushing: bool,
    pub(super) any_stuck: bool,
    modes: [Option<Lane>; WIDTH],
    load_constant: [f64; WIDTH],
    inductance: [f64; WIDTH],
}

impl Lanes {
    /// Lanes of zeros, in which nothing ever happens.
    pub(super) fn new(servo_ticks: usize) -> Lanes {
        let (low, high) = (Row([f64::NEG_INFINITY; WIDTH]), Row([f64::INFINITY; WIDTH]));
        let numbers = Numbers {
            limit_squared: high,
            range: [low, high],
            push_margin: low,
            speed_margin: [low; 2],
            holding: [high; 2],
            ..Numbers::default()
        };
        Lanes {
            states: States::default(),
            inputs: Inputs::default(),
            numbers,
            loops: Loops::new(servo_ticks),
            any_pushing: false,
            any_stuck: false,
            modes: [None; WIDTH],
            load_constant: [0.0; WIDTH],
            inductance: [0.0; WIDTH],
        }
    }

    /// Takes up the numbers of an axis in the mode it is in; false if it has to step by itself.
    pub(super) fn describe(&mut self, lane: usize, axis: &CurrentLoop<'_>) -> bool {
        let (Some(servo), Some(plant)) = (
            axis.servo.current_numbers(),
            axis.plant.lane(axis.plant_state.mode),
        ) else {
            return false;
        };
        let n = &mut self.numbers;
        n.gain.0[lane] = servo.gain;
        n.share.0[lane] = servo.share;
        n.limit_squared.0[lane] = servo.limit_squared;
        n.delayed.0[lane] = if servo.delayed { 1.0 } else { 0.0 };
        self.inductance[lane] = servo.inductance;
        self.load_constant[lane] = plant.load_constant;
        for (rows, column) in n.columns.iter_mut().zip(plant.columns) {
            put(rows, lane, column);
        }
        put(&mut n.travel, lane, plant.travel);
        n.decay_d.0[lane] = plant.decay_d;
        n.gain_d.0[lane] = plant.gain_d;
        n.pole_pairs.0[lane] = plant.pole_pairs;
        n.inductance.0[lane] = plant.inductance;
        n.torque_constant.0[lane] = plant.torque_constant;
        n.offset.0[lane] = plant.offset;
        put(&mut n.friction, lane, plant.friction);
        put(&mut n.shaft, lane, plant.shaft);
        n.third.0[lane] = plant.look.third;
        put(&mut n.range, lane, plant.look.range);
        put(&mut n.push, lane, plant.look.push);
        n.push_margin.0[lane] = plant.look.push_margin;
        put(&mut n.sliding, lane, plant.look.sliding);
        put(&mut n.speed_margin, lane, plant.look.speed_margin);
        put(&mut n.holding, lane, plant.look.holding);
        n.torque_margin.0[lane] = plant.look.torque_margin;
        self.modes[lane] = Some(plant);
        self.any_pushing = self
            .modes
            .iter()
            .flatten()
            .any(|lane| lane.look.push_margin > f64::NEG_INFINITY);
        self.any_stuck = self.modes.iter().flatten().any(|lane| {
            lane.look
                .holding
                .iter()
                .any(|torque| *torque < f64::INFINITY)
        });
        true
    }

    /// Whether an axis is still in the mode it was described in.
    pub(super) fn knows(&self, lane: usize, axis: &CurrentLoop<'_>) -> bool {
        self.modes[lane].is_some_and(|known| known.mode == axis.plant_state.mode)
    }

    /// Takes up what is held over a servo tick.
    pub(super) fn hold(&mut self, lane: usize, axis: &CurrentLoop<'_>) {
        let current = &axis.servo_state.current;
        self.inputs.command.0[lane] = axis.servo_state.velocity.current_command;
        self.inputs.cross.0[lane] = current.electric_speed * self.inductance[lane];
        self.inputs.back_emf.0[lane] = current.back_emf;
        self.inputs.load_torque.0[lane] = self.load_constant[lane] + axis.load_torque;
    }

    /// Takes up the whole drive of an axis; false if it is not a plain one.
    pub(super) fn settle(&mut self, lane: usize, axis: &CurrentLoop<'_>) -> bool {
        self.loops.numbers.inductance.0[lane] = self.inductance[lane];
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

fn put<const N: usize>(rows: &mut [Row; N], lane: usize, values: [f64; N]) {
    for (row, value) in rows.iter_mut().zip(values) {
        row.0[lane] = value;
    }
}
