//! The models that compensators have of their own axes (`twin`), stepped side by side: the laws of
//! the twin on vectors.
//!
//! Each tick they are taken up from their compensators and given back, so these need not know that
//! they have company. One whose voltage would be cut is left as it was and steps by itself.

use super::lanes::{Row, WIDTH, in_lane};
use super::tick::parts;
use super::vector::Part;
use crate::runner::TwinStep;
use crate::servo::{
    CurrentNumbers, CurrentOutput, CurrentPeriod, PlainDrive, TickNumbers, VelocityInput,
    VelocityOutput,
};
use crate::twin::{LoadModel, MotorNumbers, Rates, Twin, TwinMasses, TwinState};
use lostmotion_base::Number;
use lostmotion_base::Wide;
use pulp::{Arch, Simd, WithSimd};

/// Numbers of drive and motor.
#[derive(Clone, Debug, Default)]
pub(super) struct TwinNumbers {
    tick: TickNumbers<Row>,
    current_loop: CurrentNumbers<Row>,
    motor: MotorNumbers<Row>,
    /// Period of the current loop, s.
    period: Row,
}

/// What comes with a tick, and what a twin carries.
#[derive(Clone, Debug, Default)]
pub(super) struct TwinRows {
    /// Position, velocity, next velocity.
    pub(super) reference: [Row; 3],
    pub(super) rates: Rates<Row>,
    pub(super) seen: Row,
    pub(super) last_position: Row,
    pub(super) integral: Row,
    pub(super) command: Row,
    pub(super) limited: Row,
    pub(super) electric_speed: Row,
    pub(super) back_emf: Row,
    pub(super) fast_integral: [Row; 2],
    pub(super) pending: [Row; 2],
    pub(super) sum: Row,
    pub(super) current_d: Row,
    pub(super) masses: TwinMasses<Row>,
    pub(super) torque: Row,
    pub(super) friction: Row,
    pub(super) saturated: Row,
    /// 1 where a voltage would be cut, else 0.
    pub(super) cut: Row,
}

/// The twins of a group of axes.
#[derive(Clone, Debug, Default)]
pub(super) struct Twins {
    pub(super) numbers: TwinNumbers,
    pub(super) states: TwinRows,
    known: [bool; WIDTH],
    plain: [bool; WIDTH],
    /// The load that a lane's rates are of.
    loads: [Option<LoadModel>; WIDTH],
}

impl Twins {
    /// The axis of a lane may be another one from now on.
    pub(super) fn forget(&mut self, lane: usize) {
        self.known[lane] = false;
        self.loads[lane] = None;
    }

    /// Steps all that there are.
    pub(super) fn step(
        &mut self,
        arch: Arch,
        steps: &mut [Option<TwinStep<'_>>; WIDTH],
        periods: u32,
    ) {
        let mut taken = [false; WIDTH];
        for (lane, step) in steps.iter().enumerate() {
            let Some(step) = step else { continue };
            // numbers of drive and motor are taken once
            if !self.known[lane] {
                (self.plain[lane], self.known[lane]) =
                    (self.numbers.put(lane, step.twin.twin), true);
            }
            if self.plain[lane] {
                // the load may have been learned anew, which few ticks bring
                let load = step.twin.weighed();
                if self.loads[lane] != Some(load) {
                    self.loads[lane] = Some(load);
                    let rates = step.twin.twin.rates(&load);
                    self.states.rates.put(&rates, in_lane(lane));
                }
                self.states.take(lane, step);
                taken[lane] = true;
            }
        }
        if taken.iter().any(|taken| *taken) {
            arch.dispatch(Steps {
                twins: self,
                taken,
                periods,
            });
        }
        for (lane, step) in steps.iter_mut().enumerate() {
            let Some(step) = step.take() else { continue };
            // a cut voltage is not in the vector law: that twin has its old state and steps by
            // itself
            if taken[lane] && self.states.cut.0[lane] <= 0.0 {
                self.states
                    .give(lane, step.twin.state, step.reference.position);
            } else {
                step.run();
            }
        }
    }
}

impl TwinNumbers {
    /// Takes up a twin; false if its drive is not a plain one.
    fn put(&mut self, lane: usize, twin: &Twin) -> bool {
        let (Some(tick), Some(current)) =
            (twin.servo().tick_numbers(), twin.servo().current_numbers())
        else {
            return false;
        };
        self.tick.put(tick, in_lane(lane));
        self.current_loop.put(current, in_lane(lane));
        self.motor.put(twin.numbers(), in_lane(lane));
        self.period.0[lane] = twin.period_s();
        // the vector law reads the motor's position itself; a twin with counts steps alone
        tick.encoder_step <= 0.0
    }
}

fn fill<const N: usize>(rows: &mut [Row; N], lane: usize, values: [f64; N]) {
    for (row, value) in rows.iter_mut().zip(values) {
        row.0[lane] = value;
    }
}

impl TwinRows {
    fn take(&mut self, lane: usize, step: &TwinStep<'_>) {
        let state: &TwinState = step.twin.state;
        fill(
            &mut self.reference,
            lane,
            [
                step.reference.position,
                step.reference.velocity,
                step.next.velocity,
            ],
        );
        let (velocity, current, plant) =
            (&state.servo.velocity, &state.servo.current, &state.plant);
        self.seen.0[lane] = velocity.position;
        self.last_position.0[lane] = velocity.reference;
        self.integral.0[lane] = velocity.integral;
        self.command.0[lane] = velocity.current_command;
        self.limited.0[lane] = f64::from(u8::from(current.limited));
        fill(
            &mut self.fast_integral,
            lane,
            [current.integral_d, current.integral_q],
        );
        fill(&mut self.pending, lane, current.pending);
        // of this servo period alone, as in `Twin::step`
        self.sum.0[lane] = 0.0;
        self.current_d.0[lane] = plant.current_d;
        self.masses.put(&plant.masses(), in_lane(lane));
        // raised by any period of the tick whose voltage would be cut
        self.cut.0[lane] = 0.0;
    }

    fn give(&self, lane: usize, state: &mut TwinState, reference: f64) {
        let (velocity, current, plant) = (
            &mut state.servo.velocity,
            &mut state.servo.current,
            &mut state.plant,
        );
        velocity.position = self.seen.0[lane];
        velocity.reference = reference;
        velocity.integral = self.integral.0[lane];
        // the newest command moves the others back, as in `VelocityState::command`
        velocity.earlier_commands = [velocity.current_command, velocity.earlier_commands[0]];
        velocity.current_command = self.command.0[lane];
        // twins whose voltage would have been cut do not come here
        current.limited = false;
        current.electric_speed = self.electric_speed.0[lane];
        current.back_emf = self.back_emf.0[lane];
        (current.integral_d, current.integral_q) =
            (self.fast_integral[0].0[lane], self.fast_integral[1].0[lane]);
        current.pending = [self.pending[0].0[lane], self.pending[1].0[lane]];
        current.sum = self.sum.0[lane];
        plant.take(&self.masses.map(|row| row.0[lane]));
        state.servo.saturated = self.saturated.0[lane] > 0.0;
        (state.torque, state.motor_friction) = (self.torque.0[lane], self.friction.0[lane]);
    }
}

// A servo period of all twins.

/// Steps the twins that are taken.
pub(super) struct Steps<'a> {
    pub(super) twins: &'a mut Twins,
    pub(super) taken: [bool; WIDTH],
    pub(super) periods: u32,
}

impl WithSimd for Steps<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Twins {
            numbers, states, ..
        } = self.twins;
        for part in 0..parts::<S>(&self.taken) {
            let vector = Part { simd, part };
            vector.drive(numbers, states);
            for _ in 0..self.periods {
                vector.advance(numbers, states);
            }
        }
    }
}

impl<S: Simd> Part<S> {
    /// Measuring, position and velocity loop.
    #[inline(always)]
    fn drive(self, n: &TwinNumbers, x: &mut TwinRows) {
        let (zero, numbers) = (self.all(0.0), n.tick.map(|row| self.get(row)));
        // a twin's encoder is ideal: load and lead of the motor, not rounded
        let seen = self.get(&x.masses.place) + self.get(&x.masses.lead);
        let measured = numbers.speed(seen, self.get(&x.seen));
        let [position, velocity, next_velocity] = &x.reference;
        // without a correction: the twin shows what the axis would do if it had no gap
        let input = VelocityInput {
            position: self.get(position),
            velocity: self.get(velocity),
            next_velocity: self.get(next_velocity),
            last_position: self.get(&x.last_position),
            measured_position: seen,
            measured_velocity: measured,
            correction: [zero; 4],
            integral: self.get(&x.integral),
            voltage_limited: zero.less(self.get(&x.limited)),
        };
        let VelocityOutput {
            command,
            within_limit,
            integral,
        } = numbers.command(&input, &mut PlainDrive);
        self.put(&mut x.seen, seen);
        self.put(&mut x.integral, integral);
        self.put(&mut x.command, command);
        self.put(&mut x.saturated, zero.unless(within_limit));
        // held over the periods that follow
        self.put(&mut x.electric_speed, numbers.pole_pairs * measured);
        self.put(&mut x.back_emf, numbers.back_emf * measured);
    }

    /// A period of the current loop, and motor, shaft and load.
    #[inline(always)]
    fn advance(self, n: &TwinNumbers, x: &mut TwinRows) {
        let masses = x.masses.map(|row| self.get(row));
        let current_loop = n.current_loop.map(|row| self.get(row));
        // the current loops, d and q, with the coupling of this tick's speed
        let period = CurrentPeriod {
            command: self.get(&x.command),
            cross: self.get(&x.electric_speed) * current_loop.inductance,
            back_emf: self.get(&x.back_emf),
            current: [self.get(&x.current_d), masses.current],
            integral: [self.get(&x.fast_integral[0]), self.get(&x.fast_integral[1])],
            pending: [self.get(&x.pending[0]), self.get(&x.pending[1])],
        };
        let free = current_loop.free_voltage(&period);
        let limited = current_loop.exceeds_limit(free);
        let CurrentOutput {
            voltage: [_, voltage],
            integral,
        } = current_loop.output(&period, free, free);
        // the law here has no cut: a lane past the limit is marked and later stepped by itself from
        // its old state
        let cut = Wide::choose(limited, self.all(1.0), self.get(&x.cut));
        let sum = self.get(&x.sum) + masses.current;
        // motor, shaft and load under the voltage that acts in this period
        let (next, torques) = n.motor.map(|row| self.get(row)).advance(
            &x.rates.map(|row| self.get(row)),
            &masses,
            self.get(&n.period),
            voltage,
        );
        self.put(&mut x.cut, cut);
        self.put(&mut x.sum, sum);
        for which in 0..2 {
            self.put(&mut x.fast_integral[which], integral[which]);
            self.put(&mut x.pending[which], free[which]);
        }
        x.masses.put(&next, |row, value| self.put(row, *value));
        self.put(&mut x.torque, torques.shaft);
        self.put(&mut x.friction, torques.motor_friction);
    }
}
