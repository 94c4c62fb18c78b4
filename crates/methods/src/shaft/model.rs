//! The engaged axis as two masses on a spring and a damper, solved exactly over a servo period.
//!
//! ```text
//! theta' = w        w' = (u - b_v w - T)/J_M             u = K_t i - F_M sign(w), a parabola over the period, N m
//! phi'   = r        r' = w' - (T - F)/J_L                T = k phi + d r;  F: friction and force on the load, N m
//! ```
//! `1/J_L = 0` is the motor on a load that is held. With `A` the matrix of the states, an input
//! that goes as `(t/h)^j` adds `j! h sum_m (A h)^m b/(m + j + 1)!` over a period `h`.

use crate::AxisConfig;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Least standard deviation of a measured position, rad: the error of a parabola for the current
/// with an ideal encoder. A choice: half of the rounding of an encoder with 2^23 counts (2.2e-7).
const LEAST_NOISE_RAD: f64 = 1e-7;
/// Terms of the series: a shaft of 1 kHz turns its phase by 1.6 rad in 250 us, and 1.6^33/33! is
/// far below rounding.
const SERIES_TERMS: u32 = 32;

/// What the drive knows of its motor.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShaftMotor {
    pub(super) torque_constant: f64,
    pub(super) inertia: f64,
    pub(super) viscous: f64,
    pub(super) coulomb: f64,
    pub(super) rated_torque: f64,
    /// Standard deviation of a measured position, rad.
    pub(super) noise: f64,
    /// Servo period, s.
    pub(super) period_s: f64,
}

impl ShaftMotor {
    pub(super) fn new(config: &AxisConfig) -> ShaftMotor {
        let (motor, count) = (
            &config.motor,
            config
                .drive
                .encoder_counts_per_rev
                .map_or(0.0, |counts| TAU / f64::from(counts)),
        );
        ShaftMotor {
            torque_constant: motor.torque_constant_nm_per_a,
            inertia: config.motor_side_inertia_kgm2(),
            viscous: motor.viscous_nm_s_per_rad,
            coulomb: motor.coulomb_nm,
            rated_torque: motor.rated_torque_nm,
            noise: (count / 12.0_f64.sqrt()).max(LEAST_NOISE_RAD),
            period_s: config.servo_period_s(),
        }
    }
}

/// A shaft and its load: stiffness (N m/rad), damping over critical damping, and `1/J_L`
/// (0: held).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Shaft {
    pub(super) stiffness: f64,
    pub(super) damping_ratio: f64,
    pub(super) inverse_load: f64,
}

impl Shaft {
    /// Natural frequency with both ends free (or the load's end held), rad/s.
    pub(super) fn frequency(&self, motor: &ShaftMotor) -> f64 {
        (self.stiffness * (1.0 / motor.inertia + self.inverse_load)).sqrt()
    }

    /// Damping, N m s/rad.
    pub(super) fn damping(&self, motor: &ShaftMotor) -> f64 {
        2.0 * self.damping_ratio * self.stiffness / self.frequency(motor)
    }
}

/// States: motor position and speed, twist and its rate.
const N: usize = 4;
/// One number for each state.
type State = [f64; N];

/// Exact step over a servo period: response of the states to states and inputs.
#[derive(Clone, Debug)]
pub(super) struct ShaftStep {
    transition: [State; N],
    /// Response to the motor's torque: constant, linear and quadratic in t/h.
    drive: [State; 3],
    /// Response to the load's torque: constant and linear in t/h.
    load: [State; 2],
}

impl ShaftStep {
    pub(super) fn new(motor: &ShaftMotor, shaft: &Shaft) -> ShaftStep {
        let (h, k, d) = (motor.period_s, shaft.stiffness, shaft.damping(motor));
        let (m, l) = (1.0 / motor.inertia, shaft.inverse_load);
        // equations of motion in motor position and speed, twist and its rate
        let motor_row = [0.0, -motor.viscous * m, -k * m, -d * m];
        let twist_row = [0.0, -motor.viscous * m, -k * (m + l), -d * (m + l)];
        let a = [
            [0.0, 1.0, 0.0, 0.0],
            motor_row,
            [0.0, 0.0, 0.0, 1.0],
            twist_row,
        ]
        .map(|row| row.map(|entry| h * entry));
        // columns of exp(A h): the responses to unit states
        let mut transition = [[0.0; N]; N];
        for column in 0..N {
            let unit: State = std::array::from_fn(|i| if i == column { 1.0 } else { 0.0 });
            for (row, value) in transition.iter_mut().zip(series(&a, &unit)) {
                row[column] = value;
            }
        }
        // responses to inputs that go as powers of t/h; the motor's torque also turns the twist
        let of = |input: State, power: u32| inputs(&a, &input.map(|entry| h * entry), power);
        let (drive, load) = ([0.0, m, 0.0, m], [0.0, 0.0, 0.0, l]);
        ShaftStep {
            transition,
            drive: [of(drive, 0), of(drive, 1), of(drive, 2)],
            load: [of(load, 0), of(load, 1)],
        }
    }

    /// Advances several trajectories at once by a period: `x[state][trajectory]`, with the
    /// drive's parabola and the load's line of each.
    #[inline]
    pub(super) fn take<const C: usize>(
        &self,
        x: &[[f64; C]; N],
        drive: &[[f64; C]; 3],
        load: &[[f64; C]; 2],
    ) -> [[f64; C]; N] {
        std::array::from_fn(|i| {
            let mut sum = [0.0; C];
            // linear combination of responses, all trajectories side by side
            let mut add = |factor: f64, of: &[f64; C]| {
                sum.iter_mut()
                    .zip(of)
                    .for_each(|(sum, value)| *sum += factor * value);
            };
            self.transition[i]
                .iter()
                .zip(x)
                .for_each(|(factor, of)| add(*factor, of));
            self.drive
                .iter()
                .zip(drive)
                .for_each(|(response, of)| add(response[i], of));
            self.load
                .iter()
                .zip(load)
                .for_each(|(response, of)| add(response[i], of));
            sum
        })
    }
}

/// `a x`.
fn times(a: &[State; N], x: &State) -> State {
    a.map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum())
}

/// `exp(a) x` by its power series.
fn series(a: &[State; N], x: &State) -> State {
    let (mut sum, mut term) = (*x, *x);
    for m in 1..=SERIES_TERMS {
        term = times(a, &term).map(|entry| entry / f64::from(m));
        sum = std::array::from_fn(|i| sum[i] + term[i]);
    }
    sum
}

/// Response to an input that goes as the power j of t/h: `j! sum_m a^m b/(m + j + 1)!`.
fn inputs(a: &[State; N], b: &State, power: u32) -> State {
    let mut term = b.map(|entry| entry / f64::from(power + 1));
    let mut sum = term;
    for m in 1..=SERIES_TERMS {
        term = times(a, &term).map(|entry| entry / f64::from(m + power + 1));
        sum = std::array::from_fn(|i| sum[i] + term[i]);
    }
    sum
}
