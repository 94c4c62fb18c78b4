//! The exact step of one current period, precomputed per system matrix.

use super::dynamics::{CURRENT, Held, LOAD, MOTOR, PENETRATION, Vector};
use super::matrix::{Matrix, exponential};
use super::mode::{Coupling, MATRICES, Mass, Mode};
use super::params::PlantParams;
use crate::config::ContactLaw;

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
    fn new(params: &PlantParams, mode: Mode) -> StepTable {
        let mut a: Matrix<SIZE> = [[0.0; SIZE]; SIZE];
        for state in [CURRENT, PENETRATION, MOTOR, LOAD] {
            let mut unit = [0.0; 4];
            unit[state] = 1.0;
            for (row, value) in params.linear(mode, &unit).into_iter().enumerate() {
                a[row][state] = value;
            }
        }
        a[TRAVEL][LOAD] = 1.0;
        a[CURRENT][INPUTS] = 1.0 / params.inductance_h;
        if !mode.motor.stuck() {
            a[MOTOR][INPUTS + 1] = -1.0 / params.motor_inertia_kgm2;
        }
        if !mode.load.stuck() {
            a[LOAD][INPUTS + 2] = -1.0 / params.load_inertia_kgm2;
        }
        let e = exponential(&a, params.period_s, params.rate());
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
        let mut tables: Vec<StepTable> = Vec::with_capacity(MATRICES);
        for index in 0..MATRICES {
            let mode = Mode::with_matrix(index);
            let idle = |mass| mode.friction(mass).creeps() && !params.friction(mass).creeps();
            let like = match (idle(Mass::Motor), idle(Mass::Load)) {
                (true, _) => index.checked_sub(6),
                (_, true) => index.checked_sub(2),
                _ if mode.contact.coupling() == Coupling::Doubled && !bounded => {
                    index.checked_sub(9)
                }
                _ => None,
            };
            let table = like
                .and_then(|like| tables.get(like).cloned())
                .unwrap_or_else(|| StepTable::new(params, mode));
            tables.push(table);
        }
        std::array::from_fn(|index| tables[index].clone())
    }

    /// Its columns, and the row of the load's travel.
    pub(super) fn numbers(&self) -> ([Vector; 7], [f64; 7]) {
        (self.columns, self.travel)
    }

    /// States after the period, and how far the load went.
    #[inline]
    pub(super) fn step(
        &self,
        params: &PlantParams,
        mode: Mode,
        x: &Vector,
        held: &Held,
    ) -> (Vector, f64) {
        let motor = params.sliding_torque(Mass::Motor, mode.motor);
        let load = params.sliding_torque(Mass::Load, mode.load) + held.load_torque;
        let inputs = [x[0], x[1], x[2], x[3], held.voltage, motor, load];
        let mut out = [0.0; 4];
        let mut travel = 0.0;
        for ((column, along), input) in self.columns.iter().zip(self.travel).zip(inputs) {
            for (sum, entry) in out.iter_mut().zip(column) {
                *sum += entry * input;
            }
            travel += along * input;
        }
        (out, travel)
    }
}
