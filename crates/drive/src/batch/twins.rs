//! The models that compensators have of their own axes (`twin`), stepped side by side: the laws of
//! the twin on vectors.
//!
//! They stay in their lanes from tick to tick; their compensators are given what these look at (where
//! motor and load are, and the torques), and everything at the end of a command cycle. One whose voltage would be
//! cut is put back to where it was and steps by itself.

use super::lanes::{Row, WIDTH, in_lane};
use super::tick::parts;
use super::vector::{Pair, Part, Reach};
use crate::number::numbers;
use crate::runner::TwinStep;
use crate::servo::{
    CurrentNumbers, CurrentOutput, CurrentPeriod, PlainDrive, TickNumbers, VelocityInput,
    VelocityOutput,
};
use crate::twin::{
    Arrival, BOUNDS, Departure, INPUTS, MotorNumbers, OUTCOMES, Rates, Stride, StrideNumbers,
    Tables, Twin, TwinMasses, TwinState, Twinned,
};
use lostmotion_base::Number;
use pulp::{Arch, Simd, WithSimd};

/// Numbers of drive and motor.
#[derive(Clone, Debug, Default)]
pub(super) struct TwinNumbers {
    tick: TickNumbers<Row>,
    current_loop: CurrentNumbers<Row>,
    motor: MotorNumbers<Row>,
    stride: StrideNumbers<Row>,
    /// Period of the current loop, s.
    period: Row,
}

/// The tables of the twins' strides.
#[derive(Clone, Debug)]
struct StrideRows {
    outcomes: [[Row; INPUTS]; OUTCOMES],
    bounds: [[Row; INPUTS]; BOUNDS],
}

impl Default for StrideRows {
    fn default() -> StrideRows {
        StrideRows {
            outcomes: [[Row::default(); INPUTS]; OUTCOMES],
            bounds: [[Row::default(); INPUTS]; BOUNDS],
        }
    }
}

impl StrideRows {
    fn put(&mut self, lane: usize, tables: &Tables) {
        for at in 0..INPUTS {
            for (rows, value) in self.outcomes.iter_mut().zip(&tables.outcomes[at]) {
                rows[at].0[lane] = *value;
            }
            for (rows, value) in self.bounds.iter_mut().zip(&tables.bounds[at]) {
                rows[at].0[lane] = *value;
            }
        }
    }
}

numbers! {
    /// What a twin carries from tick to tick, but its masses.
    Carried {
        /// Encoder position and position reference at the last tick.
        seen,
        last_position,
        /// Integral of the velocity loop, its command and the two before.
        integral,
        command,
        last_command,
        command_before,
        /// 1 where the voltage was cut in the last tick, else 0.
        limited,
        /// Integrals of the current loops, and voltages computed but not yet applied.
        integral_d,
        integral_q,
        pending_d,
        pending_q,
        current_d,
    }
}

numbers! {
    /// What a tick holds over its periods, and what they leave.
    Held {
        electric_speed,
        back_emf,
        /// Torque of the shaft on the load, and of the motor's friction, N m.
        torque,
        friction,
        /// 1 where the current was at its limit, else 0.
        saturated,
        /// 1 where a voltage would be cut, else 0.
        cut,
    }
}

/// Where twins are.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place<N> {
    carried: Carried<N>,
    masses: TwinMasses<N>,
}

impl<N: Number> Place<N> {
    /// This where the mask holds, else the other one.
    #[inline(always)]
    fn or(&self, mask: N::Mask, other: &Place<N>) -> Place<N> {
        Place {
            carried: self
                .carried
                .zip(&other.carried, |a, b| N::choose(mask, *a, *b)),
            masses: self
                .masses
                .zip(&other.masses, |a, b| N::choose(mask, *a, *b)),
        }
    }
}

impl<N: Number> Held<N> {
    /// The same.
    #[inline(always)]
    fn or(&self, mask: N::Mask, other: &Held<N>) -> Held<N> {
        self.zip(other, |a, b| N::choose(mask, *a, *b))
    }
}

/// What a tick takes, and what it leaves.
#[derive(Clone, Debug, Default)]
pub(super) struct TwinRows {
    rates: Rates<Row>,
    strides: StrideRows,
    /// 1 in the lanes whose twins step, else 0.
    taken: Row,
    place: Place<Row>,
    held: Held<Row>,
}

/// The twins of a group of axes.
#[derive(Clone, Debug, Default)]
pub(super) struct Twins {
    numbers: TwinNumbers,
    states: TwinRows,
    /// Where they were before a tick in which a voltage would be cut.
    before: Place<Row>,
    known: [bool; WIDTH],
    plain: [bool; WIDTH],
    /// Whether a lane has its twin, whose compensator may be behind.
    held: [bool; WIDTH],
    /// The load that a lane's rates are of, with its weight, bit by bit, and what of it its tables follow from.
    loads: [[u64; 7]; WIDTH],
    tables: [Option<[f64; 4]>; WIDTH],
}

/// A servo tick of a command cycle.
pub(super) struct TwinTick<'a> {
    /// Position and velocity references of all lanes at the tick, and at the next one.
    pub(super) references: [&'a [Row; 2]; 2],
    /// Periods of the current loop.
    pub(super) periods: u32,
    /// Whether it is the last of its command cycle.
    pub(super) is_last: bool,
}

impl Twins {
    /// The axis of a lane may be another one from now on, or elsewhere.
    pub(super) fn forget(&mut self, lane: usize) {
        (self.known[lane], self.held[lane]) = (false, false);
        self.tables[lane] = None;
    }

    /// Steps all that there are.
    pub(super) fn step(
        &mut self,
        arch: Arch,
        steps: &mut [Option<TwinStep<'_>>; WIDTH],
        tick: &TwinTick<'_>,
    ) {
        let mut taken = [false; WIDTH];
        for (lane, step) in steps.iter_mut().enumerate() {
            let Some(step) = step else { continue };
            // the load may have been learned anew, which few ticks bring
            if step.twin.differs(&self.loads[lane]) || !self.held[lane] {
                self.take_up(lane, step);
            }
            taken[lane] = self.held[lane];
        }
        self.states.taken = Row(taken.map(|taken| f64::from(u8::from(taken))));
        if taken.iter().any(|taken| *taken) {
            arch.dispatch(Steps {
                twins: self,
                taken,
                tick,
            });
        }
        for (lane, step) in steps.iter_mut().enumerate() {
            let Some(step) = step.take() else { continue };
            if !taken[lane] {
                step.run();
            } else if self.states.held.cut.0[lane] > 0.0 {
                self.by_itself(lane, step);
            } else {
                self.states.show(lane, step.twin.state);
                if tick.is_last {
                    self.states.give(lane, step.twin.state);
                }
            }
        }
    }

    /// Takes up a twin that comes into its lane, if it is a plain one, or whose load has changed.
    #[cold]
    fn take_up(&mut self, lane: usize, step: &mut TwinStep<'_>) {
        // numbers of drive and motor are taken once
        if !self.known[lane] {
            (self.plain[lane], self.known[lane]) = (self.numbers.put(lane, step.twin.twin), true);
        }
        if !self.plain[lane] {
            return;
        }
        self.loads[lane] = step.twin.bits();
        let load = step.twin.weighed();
        let rates = step.twin.twin.rates(&load);
        self.states.rates.put(&rates, in_lane(lane));
        let of = Some(Stride::of(&load));
        if self.tables[lane] != of {
            self.tables[lane] = of;
            let tables = step.twin.state.stride.tables(step.twin.twin, &load);
            self.states.strides.put(lane, tables);
        }
        if !self.held[lane] {
            self.states.place.take(lane, step.twin.state);
            self.held[lane] = true;
        }
    }

    /// A cut voltage is not in the vector law: the twin goes back to where it was, and steps as a single one
    /// does.
    #[cold]
    fn by_itself(&mut self, lane: usize, step: TwinStep<'_>) {
        let state = step.twin.state;
        self.before.put_back(lane, state);
        let twin = Twinned {
            state: &mut *state,
            ..step.twin
        };
        TwinStep { twin, ..step }.run();
        self.states.place.take(lane, state);
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
        self.stride.put(twin.stride(), in_lane(lane));
        self.period.0[lane] = twin.period_s();
        // the vector law reads the motor's position itself; a twin with counts steps alone
        tick.encoder_step <= 0.0
    }
}

impl Place<Row> {
    /// Takes up a twin.
    fn take(&mut self, lane: usize, state: &TwinState) {
        let (velocity, current, plant) =
            (&state.servo.velocity, &state.servo.current, &state.plant);
        let carried = Carried {
            seen: velocity.position,
            last_position: velocity.reference,
            integral: velocity.integral,
            command: velocity.current_command,
            last_command: velocity.earlier_commands[0],
            command_before: velocity.earlier_commands[1],
            limited: f64::from(u8::from(current.limited)),
            integral_d: current.integral_d,
            integral_q: current.integral_q,
            pending_d: current.pending[0],
            pending_q: current.pending[1],
            current_d: plant.current_d,
        };
        self.carried.put(&carried, in_lane(lane));
        self.masses.put(&plant.masses(), in_lane(lane));
    }

    /// Puts a twin there, with all that its next step asks for.
    fn put_back(&self, lane: usize, state: &mut TwinState) {
        let (velocity, current, plant) = (
            &mut state.servo.velocity,
            &mut state.servo.current,
            &mut state.plant,
        );
        let carried = self.carried.map(|row| row.0[lane]);
        velocity.position = carried.seen;
        velocity.reference = carried.last_position;
        velocity.integral = carried.integral;
        velocity.earlier_commands = [carried.last_command, carried.command_before];
        velocity.current_command = carried.command;
        current.limited = carried.limited > 0.0;
        (current.integral_d, current.integral_q) = (carried.integral_d, carried.integral_q);
        current.pending = [carried.pending_d, carried.pending_q];
        plant.take(&self.masses.map(|row| row.0[lane]));
    }
}

impl TwinRows {
    /// Shows a compensator what it looks at.
    fn show(&self, lane: usize, state: &mut TwinState) {
        state.plant.take(&self.place.masses.map(|row| row.0[lane]));
        let held = &self.held;
        (state.torque, state.motor_friction) = (held.torque.0[lane], held.friction.0[lane]);
    }

    /// Gives a compensator its twin.
    fn give(&self, lane: usize, state: &mut TwinState) {
        self.place.put_back(lane, state);
        let (current, held) = (&mut state.servo.current, self.held.map(|row| row.0[lane]));
        current.electric_speed = held.electric_speed;
        current.back_emf = held.back_emf;
        state.servo.saturated = held.saturated > 0.0;
    }
}

// A servo period of all twins.

/// Steps the twins that are taken.
pub(super) struct Steps<'a> {
    pub(super) twins: &'a mut Twins,
    pub(super) taken: [bool; WIDTH],
    pub(super) tick: &'a TwinTick<'a>,
}

impl WithSimd for Steps<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Twins {
            numbers,
            states,
            before,
            ..
        } = self.twins;
        let (parts, tick) = (parts::<S>(&self.taken), self.tick);
        // two vectors at a time, step by step, so that the processor has another one to go on with while one
        // waits for its own results
        for part in (0..parts).step_by(2) {
            let first = Part { simd, part };
            if part + 1 < parts {
                tick.take(Pair(first), numbers, states, before);
            } else {
                tick.take(first, numbers, states, before);
            }
        }
    }
}

impl TwinTick<'_> {
    /// Takes it for the twins of some lanes.
    #[inline(always)]
    fn take<R: Reach>(
        &self,
        lanes: R,
        numbers: &TwinNumbers,
        states: &mut TwinRows,
        before: &mut Place<Row>,
    ) {
        let mut place = Place {
            carried: states.place.carried.map(|row| lanes.get(row)),
            masses: states.place.masses.map(|row| lanes.get(row)),
        };
        let mut held = drive(lanes, numbers, &mut place, self.references);
        let zero = lanes.all(0.0);
        let taken = zero.less(lanes.get(&states.taken));
        let moves = zero.less(place.masses.motor.abs()) & zero.less(place.masses.load.abs());
        let periods = |place: &mut Place<R::Value>, held: &mut Held<R::Value>| {
            for _ in 0..self.periods {
                advance(lanes, numbers, &states.rates, place, held);
            }
        };
        if R::Value::none(taken & moves) {
            periods(&mut place, &mut held);
        } else {
            let (goes_on, arrival) = stride(lanes, numbers, states, &place, &held);
            let (mut there, mut over) = (place, held);
            arrive(&mut there, &mut over, &arrival);
            // those that do not go on take the periods one after the other
            let left = R::Value::choose(goes_on, zero, zero.flag(taken));
            if !R::Value::none(zero.less(left)) {
                periods(&mut place, &mut held);
                there = there.or(goes_on, &place);
                over = over.or(goes_on, &held);
            }
            (place, held) = (there, over);
        }
        // where a voltage would be cut its twin goes back to where it was
        if !R::Value::none(lanes.all(0.0).less(held.cut)) {
            let copy = |to: &mut Row, from: &Row| lanes.put(to, lanes.get(from));
            before.carried.put(&states.place.carried, copy);
            before.masses.put(&states.place.masses, copy);
        }
        let put = |row: &mut Row, value: &R::Value| lanes.put(row, *value);
        states.place.carried.put(&place.carried, put);
        states.place.masses.put(&place.masses, put);
        states.held.put(&held, put);
    }
}

/// Measuring, position and velocity loop.
#[inline(always)]
fn drive<R: Reach>(
    lanes: R,
    n: &TwinNumbers,
    place: &mut Place<R::Value>,
    references: [&[Row; 2]; 2],
) -> Held<R::Value> {
    let (zero, numbers) = (lanes.all(0.0), n.tick.map(|row| lanes.get(row)));
    let (masses, carried) = (&place.masses, &mut place.carried);
    // a twin's encoder is ideal: load and lead of the motor, not rounded
    let seen = masses.place + masses.lead;
    let measured = numbers.speed(seen, carried.seen);
    let [[position, velocity], [_, next_velocity]] = references;
    let position = lanes.get(position);
    // without a correction: the twin shows what the axis would do if it had no gap
    let input = VelocityInput {
        position,
        velocity: lanes.get(velocity),
        next_velocity: lanes.get(next_velocity),
        last_position: carried.last_position,
        measured_position: seen,
        measured_velocity: measured,
        correction: [zero; 4],
        integral: carried.integral,
        voltage_limited: zero.less(carried.limited),
    };
    let VelocityOutput {
        command,
        within_limit,
        integral,
    } = numbers.command(&input, &mut PlainDrive);
    carried.seen = seen;
    carried.last_position = position;
    carried.integral = integral;
    carried.command_before = carried.last_command;
    carried.last_command = carried.command;
    carried.command = command;
    // the mean current is of this servo period alone, and so is a cut voltage
    carried.limited = zero;
    Held {
        // held over the periods that follow
        electric_speed: numbers.pole_pairs * measured,
        back_emf: numbers.back_emf * measured,
        torque: zero,
        friction: zero,
        saturated: zero.unless(within_limit),
        cut: zero,
    }
}

/// All periods of the current loop in one stride: where that can be, and what it comes to there.
#[inline(always)]
fn stride<R: Reach>(
    lanes: R,
    n: &TwinNumbers,
    states: &TwinRows,
    place: &Place<R::Value>,
    held: &Held<R::Value>,
) -> (<R::Value as Number>::Mask, Arrival<R::Value>) {
    let carried = &place.carried;
    let departure = Departure {
        command: carried.command,
        integral: carried.integral_q,
        pending: carried.pending_q,
        integral_d: carried.integral_d,
        electric_speed: held.electric_speed,
        back_emf: held.back_emf,
        load_most: lanes.get(&states.rates.load_most),
        load_constant: lanes.get(&states.rates.load_constant),
    };
    let (tables, zero) = (&states.strides, lanes.all(0.0));
    let products = |inputs: &[R::Value; INPUTS]| {
        let mut sums = ([zero; OUTCOMES], [zero; BOUNDS]);
        // row by row: the inputs stay in the processor's registers
        for (sum, row) in sums.0.iter_mut().zip(&tables.outcomes) {
            for (input, entry) in inputs.iter().zip(row) {
                *sum = *sum + lanes.get(entry) * *input;
            }
        }
        for (sum, row) in sums.1.iter_mut().zip(&tables.bounds) {
            for (input, entry) in inputs.iter().zip(row) {
                *sum = *sum + lanes.get(entry) * input.abs();
            }
        }
        sums
    };
    let stride = n.stride.map(|row| lanes.get(row));
    let motor = n.motor.map(|row| lanes.get(row));
    let current_loop = n.current_loop.map(|row| lanes.get(row));
    departure.stride((&stride, &motor, &current_loop), &place.masses, products)
}

/// Puts twins where a stride brings them.
#[inline(always)]
fn arrive<N: Number>(place: &mut Place<N>, held: &mut Held<N>, arrival: &Arrival<N>) {
    place.masses = arrival.masses;
    place.carried.integral_q = arrival.integral;
    place.carried.pending_q = arrival.pending;
    (held.torque, held.friction) = (arrival.shaft, arrival.motor_friction);
}

/// A period of the current loop, and motor, shaft and load.
#[inline(always)]
fn advance<R: Reach>(
    lanes: R,
    n: &TwinNumbers,
    rates: &Rates<Row>,
    place: &mut Place<R::Value>,
    held: &mut Held<R::Value>,
) {
    let (masses, carried) = (&mut place.masses, &mut place.carried);
    let current_loop = n.current_loop.map(|row| lanes.get(row));
    // the current loops, d and q, with the coupling of this tick's speed
    let period = CurrentPeriod {
        command: carried.command,
        cross: held.electric_speed * current_loop.inductance,
        back_emf: held.back_emf,
        current: [carried.current_d, masses.current],
        integral: [carried.integral_d, carried.integral_q],
        pending: [carried.pending_d, carried.pending_q],
    };
    let free = current_loop.free_voltage(&period);
    let limited = current_loop.exceeds_limit(free);
    let CurrentOutput {
        voltage: [_, voltage],
        integral,
    } = current_loop.output(&period, free, free);
    // the law here has no cut: a lane past the limit is marked and later stepped by itself from
    // its old state
    held.cut = R::Value::choose(limited, lanes.all(1.0), held.cut);
    // motor, shaft and load under the voltage that acts in this period
    let (next, torques) = n.motor.map(|row| lanes.get(row)).advance(
        &rates.map(|row| lanes.get(row)),
        masses,
        lanes.get(&n.period),
        voltage,
    );
    (carried.integral_d, carried.integral_q) = (integral[0], integral[1]);
    (carried.pending_d, carried.pending_q) = (free[0], free[1]);
    *masses = next;
    (held.torque, held.friction) = (torques.shaft, torques.motor_friction);
}
