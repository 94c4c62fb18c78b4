//! Equations of motion of one mode.
//!
//! With penetration `p = theta_b - s b` (s the flank's sign, 0 in the gap), u the voltage, sigma
//! the signs of sliding:
//! ```text
//! L di/dt    = u - R i - K_e w_M
//! dp/dt      = w_M - w_L
//! J_M dw_M/dt = K_t i - b_v w_M - T_c - sigma_M F_M        (0 if the motor is stuck)
//! J_L dw_L/dt = T_c - b_L w_L - sigma_L F_L - T_ext        (0 if the load is stuck)
//! T_c        = 0 | k p + d (w_M - w_L) | 2 k p
//! ```
//! While a mass creeps (Stribeck), its F is the breakaway friction and its b less by
//! `(F_s - F_c)/v_s`.

use super::mode::{Coupling, Friction, MATRICES, Mass, Mode};
use super::params::PlantParams;
use crate::config::ContactLaw;
use crate::number::numbers;
use lostmotion_base::Number;
use lostmotion_base::linalg::{Matrix, expm};

/// Current, penetration, motor speed, load speed.
pub(super) type Vector = [f64; 4];
pub(super) const CURRENT: usize = 0;
pub(super) const PENETRATION: usize = 1;
pub(super) const MOTOR: usize = 2;
pub(super) const LOAD: usize = 3;

/// What drives the plant over a step: everything that is held.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Held {
    /// Voltage in q with the cross-coupling taken off, V.
    pub(super) voltage: f64,
    /// Torque against the load, N m.
    pub(super) load_torque: f64,
}

impl PlantParams {
    /// Stiffness and damping of a coupling.
    #[inline]
    pub(super) fn shaft(&self, coupling: Coupling) -> (f64, f64) {
        match coupling {
            Coupling::Free => (0.0, 0.0),
            Coupling::Spring => (self.stiffness_nm_per_rad, self.damping_nm_s_per_rad),
            Coupling::Doubled => (2.0 * self.stiffness_nm_per_rad, 0.0),
        }
    }

    /// Contact torque of a mode, N m.
    #[inline]
    pub(super) fn contact_torque(&self, mode: Mode, x: &Vector) -> f64 {
        shaft_torque(self.shaft(mode.contact.coupling()), x)
    }

    /// The homogeneous part of the derivative.
    pub(super) fn linear(&self, mode: Mode, x: &Vector) -> Vector {
        let torque = self.contact_torque(mode, x);
        // viscous friction, less the fall over speed while a mass creeps (Stribeck)
        let motor = self.torque_constant_nm_per_a * x[CURRENT]
            - self.viscous(Mass::Motor, mode.motor) * x[MOTOR]
            - torque;
        let load = torque - self.viscous(Mass::Load, mode.load) * x[LOAD];
        [
            (-self.resistance_ohm * x[CURRENT] - self.back_emf_v_s_per_rad * x[MOTOR])
                / self.inductance_h,
            x[MOTOR] - x[LOAD],
            // a stuck mass keeps its speed, zero, whatever acts on it
            if mode.motor.stuck() {
                0.0
            } else {
                motor / self.motor_inertia_kgm2
            },
            if mode.load.stuck() {
                0.0
            } else {
                load / self.load_inertia_kgm2
            },
        ]
    }

    /// The held part of the derivative.
    pub(super) fn forcing(&self, mode: Mode, held: &Held) -> Vector {
        // Coulomb friction of a sliding mass is a constant torque against it
        let motor = self.sliding_torque(Mass::Motor, mode.motor);
        let load = self.sliding_torque(Mass::Load, mode.load) + held.load_torque;
        [
            held.voltage / self.inductance_h,
            0.0,
            if mode.motor.stuck() {
                0.0
            } else {
                -motor / self.motor_inertia_kgm2
            },
            if mode.load.stuck() {
                0.0
            } else {
                -load / self.load_inertia_kgm2
            },
        ]
    }

    /// The states into whose derivatives a voltage and the torques against motor and load enter, with
    /// what one unit adds.
    pub(super) fn inputs(&self, mode: Mode) -> [(usize, f64); 3] {
        let against = |friction: Friction, inertia: f64| {
            if friction.stuck() {
                0.0
            } else {
                -1.0 / inertia
            }
        };
        [
            (CURRENT, 1.0 / self.inductance_h),
            (MOTOR, against(mode.motor, self.motor_inertia_kgm2)),
            (LOAD, against(mode.load, self.load_inertia_kgm2)),
        ]
    }

    /// Torque on the motor that its Coulomb friction has to balance, N m.
    #[inline]
    pub(super) fn motor_need(&self, mode: Mode, x: &Vector) -> f64 {
        self.torque_constant_nm_per_a * x[CURRENT] - self.contact_torque(mode, x)
    }

    /// Torque on the load that its Coulomb friction has to balance, N m.
    #[inline]
    pub(super) fn load_need(&self, mode: Mode, x: &Vector, held: &Held) -> f64 {
        self.contact_torque(mode, x) - held.load_torque
    }
}

/// Torque of a shaft of a stiffness and a damping on the load, N m.
#[inline(always)]
pub(crate) fn shaft_torque<N: Number>((stiffness, damping): (N, N), x: &[N; 4]) -> N {
    stiffness * x[PENETRATION] + damping * (x[MOTOR] - x[LOAD])
}

numbers! {
    /// What the electric side of a step computes with.
    Electric {
        /// Pairs of poles.
        pole_pairs,
        /// Of a phase, H.
        inductance,
        /// Part of i_d that is left after a period.
        decay_d,
        /// What a volt in d adds to i_d in a period, A/V.
        gain_d,
    }
}

impl<N: Number> Electric<N> {
    /// The voltage in q with the coupling taken off, held over the period, and i_d at its end.
    #[inline(always)]
    pub(crate) fn step(
        &self,
        motor_velocity: N,
        [current_d, current_q]: [N; 2],
        [voltage_d, voltage_q]: [N; 2],
    ) -> (N, N) {
        // w_e L, the rate at which each axis' current drives the other's voltage
        let cross = self.pole_pairs * motor_velocity * self.inductance;
        let next_d = self.decay_d * current_d + self.gain_d * (voltage_d + cross * current_q);
        (voltage_q - cross * current_d, next_d)
    }
}

/// The states after a period and how far the load went: the product of a [`StepTable`], of which
/// `entry` gives a number by column and row and `along` the row of the travel, with the states, the
/// voltage and the two torques that oppose motion.
#[inline(always)]
pub(crate) fn exact_step<N: Number>(
    entry: impl Fn(usize, usize) -> N,
    along: impl Fn(usize) -> N,
    inputs: [N; 7],
) -> ([N; 4], N) {
    let zero = inputs[0].zero();
    let (mut after, mut travel) = ([zero; 4], zero);
    for (column, input) in inputs.into_iter().enumerate() {
        for (row, sum) in after.iter_mut().enumerate() {
            *sum = *sum + entry(column, row) * input;
        }
        travel = travel + along(column) * input;
    }
    (after, travel)
}

// The exact step of one current period, precomputed per system matrix.

/// States, load travel, then the inputs: voltage, motor friction torque, load torque.
const SIZE: usize = 8;
const TRAVEL: usize = 4;
const INPUTS: usize = 5;

/// `x(h) = sum of column * input`; the inputs are the four states, the voltage and the two torques
/// that oppose motion.
#[derive(Clone, Debug)]
pub(super) struct StepTable {
    columns: [Vector; 7],
    travel: [f64; 7],
}

impl StepTable {
    const EMPTY: StepTable = StepTable {
        columns: [[0.0; 4]; 7],
        travel: [0.0; 7],
    };

    fn new(params: &PlantParams, mode: Mode) -> StepTable {
        // states, travel and held inputs in one system whose exponential is the step (van Loan)
        let mut a: Matrix<SIZE> = [[0.0; SIZE]; SIZE];
        for state in [CURRENT, PENETRATION, MOTOR, LOAD] {
            let mut unit = [0.0; 4];
            unit[state] = 1.0;
            for (row, value) in params.linear(mode, &unit).into_iter().enumerate() {
                a[row][state] = value;
            }
        }
        a[TRAVEL][LOAD] = 1.0;
        for (input, (state, by)) in params.inputs(mode).into_iter().enumerate() {
            a[state][INPUTS + input] = by;
        }
        // columns of the exponential by source, rows by state
        let e = expm(&a, params.period_s, params.rate());
        let sources = [
            CURRENT,
            PENETRATION,
            MOTOR,
            LOAD,
            INPUTS,
            INPUTS + 1,
            INPUTS + 2,
        ];
        StepTable {
            columns: sources.map(|source| [0, 1, 2, 3].map(|row: usize| e[row][source])),
            travel: sources.map(|source| e[TRAVEL][source]),
        }
    }

    /// All tables of a plant, by [`Mode::matrix`]. Modes that the plant cannot come to have those
    /// of the mode nearest to them.
    pub(super) fn all(params: &PlantParams) -> [StepTable; MATRICES] {
        let bounded = params.contact == ContactLaw::Bounded;
        // in place: the plant of a drifting axis is made anew while it is stepped
        let mut tables = [StepTable::EMPTY; MATRICES];
        for index in 0..MATRICES {
            let mode = Mode::with_matrix(index);
            // modes that this plant cannot come to take the table of their neighbour
            let idle = |mass| mode.friction(mass).creeps() && !params.friction(mass).creeps();
            // creeping is 6 indices (motor) or 2 (load) above sliding, the doubled spring 9 above
            // the plain one
            let like = match (idle(Mass::Motor), idle(Mass::Load)) {
                (true, _) => index.checked_sub(6),
                (_, true) => index.checked_sub(2),
                _ if mode.contact.coupling() == Coupling::Doubled && !bounded => {
                    index.checked_sub(9)
                }
                _ => None,
            };
            tables[index] = match like {
                Some(like) => tables[like].clone(),
                None => StepTable::new(params, mode),
            };
        }
        tables
    }

    /// Its columns, and the row of the load's travel.
    pub(super) fn numbers(&self) -> ([Vector; 7], [f64; 7]) {
        (self.columns, self.travel)
    }

    /// States after the period under the frictions of motor and load, and how far the load went.
    #[inline]
    pub(super) fn step(&self, [motor, load]: [f64; 2], x: &Vector, held: &Held) -> (Vector, f64) {
        let load = load + held.load_torque;
        let inputs = [x[0], x[1], x[2], x[3], held.voltage, motor, load];
        exact_step(
            |column, row| self.columns[column][row],
            |column| self.travel[column],
            inputs,
        )
    }
}

// The solution within a step as a polynomial of time.

/// Degree of the polynomial. With `rate * span <= 0.5` the remainder is below 0.5^15/15! = 2e-17 of
/// the states.
const DEGREE: usize = 14;
/// Number of its coefficients.
pub(super) const COEFFICIENTS: usize = DEGREE + 1;

/// States over `span` seconds as a polynomial of tau = t/span in [0, 1].
pub(super) struct Taylor {
    coefficients: [Vector; COEFFICIENTS],
}

impl Taylor {
    pub(super) fn new(
        params: &PlantParams,
        mode: Mode,
        x: &Vector,
        held: &Held,
        span: f64,
    ) -> Taylor {
        // x' = A x + f: the nth derivative is A times the one before, f enters the first only
        let mut coefficients = [*x; COEFFICIENTS];
        let mut derivative = params.linear(mode, x);
        for (d, f) in derivative.iter_mut().zip(params.forcing(mode, held)) {
            *d += f;
        }
        for (n, coefficient) in coefficients.iter_mut().enumerate().skip(1) {
            let factor = span / n as f64;
            let term = derivative.map(|d| d * factor);
            *coefficient = term;
            derivative = params.linear(mode, &term);
        }
        Taylor { coefficients }
    }

    /// A linear functional of the states, as a polynomial of tau.
    pub(super) fn functional(&self, offset: f64, row: &Vector) -> [f64; COEFFICIENTS] {
        let mut out = self
            .coefficients
            .map(|c| row[0] * c[0] + row[1] * c[1] + row[2] * c[2] + row[3] * c[3]);
        out[0] += offset;
        out
    }

    /// States at tau, and how far the load went since tau = 0 over the given span.
    pub(super) fn at(&self, tau: f64, span: f64) -> (Vector, f64) {
        let mut x = [0.0; 4];
        let mut travel = 0.0;
        // Horner; the travel integrates the load's speed term by term
        for (n, c) in self.coefficients.iter().enumerate().rev() {
            for (sum, entry) in x.iter_mut().zip(c) {
                *sum = *sum * tau + entry;
            }
            travel = travel * tau + c[LOAD] / (n + 1) as f64;
        }
        (x, travel * (tau * span))
    }
}
