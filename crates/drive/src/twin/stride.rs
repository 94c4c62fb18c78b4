//! A servo period of a twin in one stride.
//!
//! While motor and load slide on and no voltage is cut, the equations of the current loop, motor, shaft
//! and load are linear over all periods of the current loop that a servo period has. What they come to
//! is then one product with a table that stays as long as the load's inertia, viscous friction, stiffness
//! and damping do. The same periods one by one differ from it by rounding alone.
//!
//! Whether it is so is known beforehand: a second table bounds how far either speed comes from where it is,
//! how large the current becomes and how large the voltage. A bound adds up sizes, so what mostly cancels
//! is taken together first ([`Departure::inputs`]): the current and its command, the speeds of the shaft's ends, the
//! back-EMF and what is fed forward against it.

use super::law::{MotorNumbers, Rates, TwinMasses};
use super::{LoadModel, Twin};
use crate::number::numbers;
use crate::servo::{CurrentNumbers, CurrentOutput, CurrentPeriod};
use lostmotion_base::{Number, Wide};
use pulp::{Simd, WithSimd};

/// What a stride starts from, see [`Departure::inputs`].
pub(crate) const INPUTS: usize = 11;
/// What it comes to: [`Arrival`].
pub(crate) const OUTCOMES: usize = 8;
/// What is bounded: how far the speeds of motor and load come from where they are, the size of i_q and
/// of the voltage in q.
pub(crate) const BOUNDS: usize = 4;
/// Numbers in a row of tables, a whole vector of any processor.
const ROW: usize = 8;
/// What bounds have to spare for rounding. A choice: far more than a sum of eleven products loses.
const SPARE: f64 = 1.0 + 1e-9;

/// The tables of a stride, by input: a number for each outcome, and the largest size that it gives to each
/// of what is bounded.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tables {
    pub(crate) outcomes: [[f64; ROW]; INPUTS],
    pub(crate) bounds: [[f64; ROW]; INPUTS],
}

/// The tables of the load that a twin was stepped with last. They follow from that load, so a state is the same
/// with them and without.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stride {
    of: Option<[f64; 4]>,
    tables: Tables,
}

impl PartialEq for Stride {
    fn eq(&self, _: &Stride) -> bool {
        true
    }
}

impl Stride {
    /// The tables of a load.
    #[inline(always)]
    pub(crate) fn tables(&mut self, twin: &Twin, load: &LoadModel) -> &Tables {
        let of = Some(Stride::of(load));
        if self.of != of {
            self.tables.fill(twin, load);
            self.of = of;
        }
        &self.tables
    }

    /// What of a load the tables follow from.
    pub(crate) fn of(load: &LoadModel) -> [f64; 4] {
        [load.inertia, load.viscous, load.stiffness, load.damping]
    }
}

numbers! {
    /// What of the winding a stride asks for besides.
    StrideNumbers {
        /// Ohm.
        resistance,
        /// V s/rad.
        back_emf,
    }
}

/// Where a drive is at the start of a servo period, and what is held over it.
pub(crate) struct Departure<N> {
    /// Current command, A.
    pub(crate) command: N,
    /// Integral of the current loop in q, and the voltage computed but not yet applied, V.
    pub(crate) integral: N,
    pub(crate) pending: N,
    /// Integral in d, V.
    pub(crate) integral_d: N,
    /// Electric speed as the drive knows it, rad/s, and the back-EMF with it, V.
    pub(crate) electric_speed: N,
    pub(crate) back_emf: N,
    /// What Coulomb friction takes of the load's speed in a period, rad/s.
    pub(crate) load_most: N,
    /// Constant torque on the load, N m.
    pub(crate) load_constant: N,
}

/// What a stride comes to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrival<N> {
    pub(crate) masses: TwinMasses<N>,
    pub(crate) integral: N,
    pub(crate) pending: N,
    /// Torque of the shaft on the load in the last period, N m.
    pub(crate) shaft: N,
    /// Torque of the motor's Coulomb friction on the motor, N m.
    pub(crate) motor_friction: N,
}

impl<N: Number> Departure<N> {
    /// What the tables are for: the command, how far the current is from it, the lead, the motor's speed, that of
    /// the shaft's ends against each other, the integral without what the command takes, the back-EMF fed forward
    /// without what the motor's speed takes, the voltage not yet applied without what both give, what friction takes of
    /// each speed, and the constant torque.
    #[inline(always)]
    fn inputs(&self, n: &StrideNumbers<N>, motor_most: N, x: &TwinMasses<N>) -> [N; INPUTS] {
        let fed = self.integral + self.back_emf;
        [
            self.command,
            self.command - x.current,
            x.lead,
            x.motor,
            x.motor - x.load,
            self.integral - n.resistance * self.command,
            self.back_emf - n.back_emf * x.motor,
            self.pending - fed,
            motor_most.copysign(x.motor),
            self.load_most.copysign(x.load),
            self.load_constant,
        ]
    }

    /// Whether a servo period is one stride from here, and what it comes to if it is. `products` gives those of the
    /// tables with the inputs.
    #[inline(always)]
    pub(crate) fn stride(
        &self,
        (n, motor_numbers, current_loop): (&StrideNumbers<N>, &MotorNumbers<N>, &CurrentNumbers<N>),
        x: &TwinMasses<N>,
        products: impl FnOnce(&[N; INPUTS]) -> ([N; OUTCOMES], [N; BOUNDS]),
    ) -> (N::Mask, Arrival<N>) {
        let (outcomes, bounds) = products(&self.inputs(n, motor_numbers.motor_most, x));
        let [motor, load, current, voltage] = bounds;
        // the voltage in d holds against the coupling: the twin has no i_d
        let cross = self.electric_speed.abs() * current_loop.inductance;
        let direct = self.integral_d.abs() + cross * current;
        let spare = |size: N| size * size.constant(SPARE);
        let goes_on = spare(motor).less(x.motor.abs())
            & spare(load).less(x.load.abs())
            & spare(direct * direct + voltage * voltage).less(current_loop.limit_squared);
        let [current, lead, motor, load, integral, pending, way, shaft] = outcomes;
        let arrival = Arrival {
            masses: TwinMasses {
                current,
                lead,
                motor,
                load,
                place: x.place + way,
            },
            integral,
            pending,
            shaft,
            motor_friction: -motor_numbers.coulomb.copysign(x.motor),
        };
        (goes_on, arrival)
    }
}

/// The sum of products of a row with the inputs, in their order.
#[inline(always)]
fn sum<N: Number>(entry: impl Fn(usize) -> N, input: impl Fn(usize) -> N, zero: N) -> N {
    (0..INPUTS).fold(zero, |sum, at| sum + entry(at) * input(at))
}

/// The products of tables with the inputs of one twin: rows side by side.
pub(super) struct Products<'a> {
    pub(super) tables: &'a Tables,
    pub(super) inputs: &'a [f64; INPUTS],
}

impl WithSimd for Products<'_> {
    type Output = ([f64; ROW], [f64; ROW]);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Products { tables, inputs } = self;
        let (mut outcomes, mut bounds) = ([0.0; ROW], [0.0; ROW]);
        let (zero, input) = (Wide::all(simd, 0.0), |at: usize| {
            Wide::all(simd, inputs[at])
        });
        for part in 0..OUTCOMES.div_ceil(S::F64_LANES) {
            let entry = |at: usize| Wide::get(simd, &tables.outcomes[at], part);
            sum(entry, input, zero).put(&mut outcomes, part);
        }
        for part in 0..BOUNDS.div_ceil(S::F64_LANES) {
            let entry = |at: usize| Wide::get(simd, &tables.bounds[at], part);
            sum(entry, |at| input(at).abs(), zero).put(&mut bounds, part);
        }
        (outcomes, bounds)
    }
}

impl Tables {
    /// The periods of a servo period one after the other, for one of each input: side by side.
    #[inline(never)]
    fn fill(&mut self, twin: &Twin, load: &LoadModel) {
        // friction and constant torque are inputs
        let bare = LoadModel {
            coulomb: 0.0,
            constant: 0.0,
            ..*load
        };
        let mut rows = Rows::default();
        twin.arch.dispatch(Build {
            twin,
            rates: twin.rates(&bare),
            rows: &mut rows,
        });
        for column in 0..INPUTS {
            for (to, row) in self.outcomes[column].iter_mut().zip(&rows.outcomes) {
                *to = row[column];
            }
            for (to, row) in self.bounds[column].iter_mut().zip(&rows.bounds) {
                *to = row[column];
            }
        }
    }
}

/// Inputs side by side, in as many lanes as whole vectors of any processor hold.
const COLUMNS: usize = 16;

/// Tables by outcome and bound.
#[derive(Clone, Copy, Default)]
struct Rows {
    outcomes: [[f64; COLUMNS]; OUTCOMES],
    bounds: [[f64; COLUMNS]; BOUNDS],
}

/// Fills them.
struct Build<'a> {
    twin: &'a Twin,
    rates: Rates<f64>,
    rows: &'a mut Rows,
}

impl WithSimd for Build<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Build { twin, rates, rows } = self;
        let all = |value: &f64| Wide::all(simd, *value);
        let (numbers, rates) = (twin.numbers.map(all), rates.map(all));
        let (current_loop, stride) = (twin.servo.current_loop().map(all), twin.stride.map(all));
        let h = all(&twin.period_s);
        for part in 0..INPUTS.div_ceil(S::F64_LANES) {
            let units = std::array::from_fn(|input| {
                let mut unit = [0.0; COLUMNS];
                unit[input] = 1.0;
                Wide::get(simd, &unit, part)
            });
            let mut point = Point::of(&stride, &units);
            let start = point;
            let mut shaft = h.zero();
            let mut bounds = [h.zero(); BOUNDS];
            for _ in 0..twin.servo.current_steps() {
                let voltage = point.voltage(&current_loop);
                shaft = point.advance(&numbers, &rates, h, voltage.acts);
                let sizes = [
                    point.x.motor - start.x.motor,
                    point.x.load - start.x.load,
                    voltage.current,
                    voltage.free,
                ];
                for (most, size) in bounds.iter_mut().zip(sizes) {
                    *most = most.larger(size.abs());
                }
            }
            let outcomes = [
                point.x.current,
                point.x.lead,
                point.x.motor,
                point.x.load,
                point.integral,
                point.pending,
                point.x.place,
                shaft,
            ];
            let put = |rows: &mut [[f64; COLUMNS]], values: &[Wide<S>]| {
                for (row, value) in rows.iter_mut().zip(values) {
                    value.put(row, part);
                }
            };
            put(&mut rows.outcomes, &outcomes);
            put(&mut rows.bounds, &bounds);
        }
    }
}

/// Where the linear equations are.
#[derive(Clone, Copy)]
struct Point<N> {
    x: TwinMasses<N>,
    command: N,
    integral: N,
    pending: N,
    back_emf: N,
    /// What friction takes of the speeds in a period.
    friction: [N; 2],
    constant: N,
}

/// What the current loop does in a period.
struct Voltage<N> {
    /// The current that it saw, A.
    current: N,
    /// What it computed, V.
    free: N,
    /// What acts, V.
    acts: N,
}

impl<N: Number> Point<N> {
    /// That of these [`Departure::inputs`].
    #[inline(always)]
    fn of(n: &StrideNumbers<N>, inputs: &[N; INPUTS]) -> Point<N> {
        let [
            command,
            short,
            lead,
            motor,
            apart,
            integral,
            back_emf,
            pending,
            motor_friction,
            load_friction,
            constant,
        ] = *inputs;
        let integral = integral + n.resistance * command;
        let back_emf = back_emf + n.back_emf * motor;
        Point {
            x: TwinMasses {
                current: command - short,
                lead,
                motor,
                load: motor - apart,
                place: lead.zero(),
            },
            command,
            integral,
            pending: pending + integral + back_emf,
            back_emf,
            friction: [motor_friction, load_friction],
            constant,
        }
    }

    /// A period of the current loop in q.
    #[inline(always)]
    fn voltage(&mut self, current_loop: &CurrentNumbers<N>) -> Voltage<N> {
        let (current, zero) = (self.x.current, self.x.current.zero());
        let period = CurrentPeriod {
            command: self.command,
            // without i_d the coupling is one in d alone
            cross: zero,
            back_emf: self.back_emf,
            current: [zero, current],
            integral: [zero, self.integral],
            pending: [zero, self.pending],
        };
        let free = current_loop.free_voltage(&period);
        let CurrentOutput {
            voltage: [_, acts],
            integral: [_, integral],
        } = current_loop.output(&period, free, free);
        (self.integral, self.pending) = (integral, free[1]);
        Voltage {
            current,
            free: free[1],
            acts,
        }
    }

    /// A period of motor, shaft and load; returns the shaft's torque.
    #[inline(always)]
    fn advance(&mut self, numbers: &MotorNumbers<N>, bare: &Rates<N>, h: N, voltage: N) -> N {
        let rates = Rates {
            load_constant: self.constant,
            ..*bare
        };
        let free = numbers.frictionless(&rates, &self.x, voltage, &rates.free());
        let [motor, load] = [free.motor - self.friction[0], free.load - self.friction[1]];
        self.x = self.x.moved(h, free.current, motor, load);
        free.shaft
    }
}

#[cfg(test)]
mod tests {
    use super::super::TwinState;
    use super::*;
    use crate::config::{AxisConfig, Load};
    use lostmotion_base::random::Random;

    /// A twin whose drive and load are drawn, on its way.
    fn drawn(random: &mut Random) -> (Twin, TwinState, LoadModel) {
        let mut config = AxisConfig::<()>::paper();
        config.drive.voltage_delay_periods = random.below(2) as u32;
        config.drive.velocity_gain_a_s_per_rad *= random.log_between(0.2, 5.0);
        config.motor.coulomb_nm = [0.0, random.log_between(0.01, 0.5)][random.below(2)];
        if let Load::Reflected(load) = &mut config.load {
            load.stiffness_nm_per_rad *= random.log_between(0.1, 30.0);
            load.inertia_kgm2 *= random.log_between(0.1, 10.0);
        }
        let wave = |random: &mut Random| random.between(-1.0, 1.0);
        let load = LoadModel {
            viscous: random.log_between(1e-5, 1e-2),
            coulomb: [0.0, random.log_between(0.01, 2.0)][random.below(2)],
            constant: wave(random),
            ..LoadModel::told(&config)
        };
        let twin = Twin::new(&config);
        let mut state = twin.initial(0.0, &load);
        let speed = wave(random) * random.log_between(1e-3, 200.0);
        let x = TwinMasses {
            current: 5.0 * wave(random),
            lead: 2.0 * wave(random) / load.stiffness,
            motor: speed,
            load: speed * (1.0 + 0.1 * wave(random)),
            place: 100.0 * wave(random),
        };
        state.plant.take(&x);
        let back_emf = config.motor.back_emf_v_s_per_rad() * (speed + 0.1 * wave(random));
        let servo = &mut state.servo;
        servo.velocity.current_command = x.current + wave(random);
        servo.current.integral_q = 20.0 * wave(random);
        servo.current.back_emf = back_emf;
        servo.current.electric_speed = config.motor.pole_pairs() * speed;
        servo.current.pending = [0.0, servo.current.integral_q + back_emf];
        (twin, state, load)
    }

    #[test]
    fn a_stride_is_its_periods_one_after_the_other() {
        let mut random = Random::new(158);
        let (mut strides, mut drawn_states) = ([0; 2], [0; 2]);
        for _ in 0..20_000 {
            let (twin, start, load) = drawn(&mut random);
            let (mut at_once, mut alone) = (start, start);
            let fast = usize::from(start.plant.motor_velocity.abs() > 5.0);
            drawn_states[fast] += 1;
            if !twin.strides(&mut at_once, &load) {
                assert_eq!(at_once, start);
                continue;
            }
            strides[fast] += 1;
            twin.periods(&mut alone, &load);
            assert!(!alone.servo.current.limited);
            let numbers = |state: &TwinState| {
                let (x, current) = (state.plant.masses(), &state.servo.current);
                let twist = x.lead * load.stiffness;
                let (friction, pending) = (state.motor_friction, current.pending[1]);
                let voltages = [current.integral_q, pending];
                (
                    [x.current, twist, x.motor, x.load, x.place],
                    [state.torque, friction],
                    voltages,
                )
            };
            let (a, b) = (numbers(&at_once), numbers(&alone));
            let all = |(x, torques, voltages): ([f64; 5], [f64; 2], [f64; 2])| {
                x.into_iter().chain(torques).chain(voltages)
            };
            for (at, (a, b)) in all(a).zip(all(b)).enumerate() {
                assert!(
                    (a - b).abs() < 1e-11 * (1.0 + b.abs()),
                    "{at}: {a} {b} from {start:?} with {load:?}"
                );
            }
        }
        // axes on their way mostly stride, also slow ones
        assert!(
            10 * strides[1] > 9 * drawn_states[1],
            "{strides:?} of {drawn_states:?}"
        );
        assert!(strides[0] > 0, "{strides:?} of {drawn_states:?}");
    }
}
