//! Where the load is at the start of a window: a Kalman filter over the samples before its crossing.
//!
//! A load of some hundred kilograms on a screw swings at 10 to 150 Hz, and 50 ms before a crossing it may
//! be anywhere in that swing. What the motor's motion says of it is taken in by gains on the innovation:
//! ```text
//! x' = u - w_L               w_L' = (k x + d x')/J_L        x: lead past the flank, w_L: speed of the load, u: measured speed of the motor
//! w' = -(k x + d x')/J_M     theta' = w                     e: measured less predicted position of the motor
//! P  = F P F' + Q            K = P_theta/(P_theta,theta + R)        (x, w_L, theta, w) += K e
//! ```
//! Gains are those of the first hypothesis, for all of them. A load that stands has no speed, and one
//! between its flanks no spring.

use super::lanes::{Hypotheses, Known, STEPS_PER_SAMPLE, Step};
use lostmotion_base::linalg::Matrix;
use serde::{Deserialize, Serialize};

/// Part of the observed torque that the one at the start may be off by. A choice: what is observed is
/// low-passed at 30 Hz.
const TORQUE_DOUBT: f64 = 0.3;
/// The least that it may be off by, over the torque that nothing models. A choice.
const LEAST_TORQUE_DOUBT: f64 = 10.0;

/// Unknowns: lead (rad) and speed (rad/s) of the load, position (rad) and speed (rad/s) of the motor.
const N: usize = 4;
const LOAD_SPEED: usize = 1;
const MOTOR: usize = 2;
const MOTOR_SPEED: usize = 3;

/// What an innovation adds to each unknown, over the innovation.
pub(super) type Gains = [f64; N];

/// How well the unknowns are known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct StartFilter {
    covariance: Matrix<N>,
}

impl StartFilter {
    /// Before the first sample, which lasts `span` (s). `torque`: what the shaft seems to carry, N m; a load that
    /// does not stand moves as its motor does but for what it swings.
    pub(super) fn new(
        known: &Known,
        p: &Hypotheses,
        torque: f64,
        stands: bool,
        span: f64,
    ) -> StartFilter {
        let (stiffness, inertia) = (p.stiffness[0], p.inertia[0]);
        let least = LEAST_TORQUE_DOUBT * known.unmodelled;
        let swings = (torque.abs() + least) / (stiffness * inertia).sqrt();
        let deviations = [
            (TORQUE_DOUBT * torque.abs() + least) / stiffness,
            if stands { 0.0 } else { swings },
            known.noise,
            known.noise / span,
        ];
        let mut covariance = [[0.0; N]; N];
        for (i, deviation) in deviations.into_iter().enumerate() {
            covariance[i][i] = deviation * deviation;
        }
        StartFilter { covariance }
    }

    /// Gains of the next sample.
    #[inline(always)]
    pub(super) fn step(&mut self, known: &Known, rates: &StartRates) -> Gains {
        let mut foreseen = carried(&rates.turned, &self.covariance);
        foreseen[LOAD_SPEED][LOAD_SPEED] += rates.noise[0];
        foreseen[MOTOR_SPEED][MOTOR_SPEED] += rates.noise[1];
        let variance = foreseen[MOTOR][MOTOR] + square(known.noise);
        let gains: Gains = foreseen.map(|row| row[MOTOR] / variance);
        let motor = foreseen[MOTOR];
        self.covariance = foreseen;
        for (row, gain) in self.covariance.iter_mut().zip(gains) {
            for (entry, of_motor) in row.iter_mut().zip(motor) {
                *entry -= gain * of_motor;
            }
        }
        gains
    }
}

/// What stays from sample to sample of a load that goes on as it does.
#[derive(Default)]
pub(super) struct StartRates {
    /// Whether it is on a flank, and whether it has no speed; `None` before the first.
    pub(super) of: Option<[bool; 2]>,
    /// F', and the diagonal entries of Q at the two speeds.
    turned: Matrix<N>,
    noise: [f64; 2],
}

impl StartRates {
    /// `is_pressed`: the load is on a flank; `stands`: it has no speed.
    #[inline(always)]
    pub(super) fn new(
        known: &Known,
        p: &Hypotheses,
        [is_pressed, stands]: [bool; 2],
        step: Step,
    ) -> StartRates {
        let span = STEPS_PER_SAMPLE as f64 * step.time_s;
        let mobility = if stands { 0.0 } else { 1.0 / p.inertia[0] };
        let shaft = if is_pressed {
            [p.stiffness[0], p.damping[0]]
        } else {
            [0.0; 2]
        };
        let (load, torque) = over_sample(shaft, mobility, stands, step);
        let gain = span / known.inertia;
        // the motor's speed falls by the mean torque, its position by half of that over the sample
        let transition: Matrix<N> = [
            [load[0][0], load[0][1], 0.0, 0.0],
            [load[1][0], load[1][1], 0.0, 0.0],
            [
                -0.5 * span * gain * torque[0],
                -0.5 * span * gain * torque[1],
                1.0,
                span,
            ],
            [-gain * torque[0], -gain * torque[1], 0.0, 1.0],
        ];
        let mut turned = Matrix::default();
        for (j, row) in transition.into_iter().enumerate() {
            for (i, entry) in row.into_iter().enumerate() {
                turned[i][j] = entry;
            }
        }
        StartRates {
            of: Some([is_pressed, stands]),
            turned,
            noise: [
                square(span * known.unmodelled * mobility),
                square(gain * known.unmodelled),
            ],
        }
    }
}

/// What lead and speed of a load become over a sample, and the mean torque of its shaft meanwhile, in both:
/// the steps of the hypotheses, without friction.
#[inline(always)]
fn over_sample(
    [stiffness, damping]: [f64; 2],
    mobility: f64,
    stands: bool,
    step: Step,
) -> ([[f64; 2]; 2], [f64; 2]) {
    let (h, ahead) = (step.time_s, step.part * step.time_s);
    let give = 1.0 + (ahead * ahead * stiffness + ahead * damping) * mobility;
    let by = [stiffness / give, -(stiffness * ahead + damping) / give];
    let [mut lead, mut speed] = [[1.0, 0.0], [0.0, if stands { 0.0 } else { 1.0 }]];
    let mut mean = [0.0; 2];
    for _ in 0..STEPS_PER_SAMPLE {
        for i in 0..2 {
            let torque = by[0] * lead[i] + by[1] * speed[i];
            let gained = h * torque * mobility;
            lead[i] -= h * (speed[i] + step.part * gained);
            speed[i] += gained;
            mean[i] += torque / STEPS_PER_SAMPLE as f64;
        }
    }
    ([lead, speed], mean)
}

/// F P F' of F': row by row, so that rows are vectors.
#[inline(always)]
fn carried(turned: &Matrix<N>, covariance: &Matrix<N>) -> Matrix<N> {
    let mut carried = [[0.0; N]; N];
    for (i, row) in carried.iter_mut().enumerate() {
        let mut half = [0.0; N];
        for (of, line) in turned.iter().zip(covariance) {
            for (sum, entry) in half.iter_mut().zip(line) {
                *sum += of[i] * entry;
            }
        }
        for (by, line) in half.iter().zip(turned) {
            for (sum, entry) in row.iter_mut().zip(line) {
                *sum += by * entry;
            }
        }
    }
    carried
}

#[inline(always)]
fn square(x: f64) -> f64 {
    x * x
}

#[cfg(test)]
mod tests {
    use super::super::lanes::{LANES, Progress, Stays, WARM_UP};
    use super::super::prior::uniform;
    use super::super::window::{Sample, Window};
    use super::*;
    use lostmotion_base::Clock;
    use std::f64::consts::TAU;

    const KNOWN: Known = Known {
        torque_constant: 1.0,
        inertia: 1e-3,
        viscous: 0.0,
        noise: 3e-7,
        unmodelled: 0.01,
    };

    /// A motor with a steady torque of 1 N m and a load of 0.002 kg m2 with friction of 0.1 N m that swings behind
    /// it at `frequency` Hz, in steps of 0.5 us: what a drive sees, whose observed torque is 0.2 N m off, and
    /// torque of the shaft (N m) and speed of the load (rad/s) at its end.
    fn swinging(frequency: f64) -> (Window, Hypotheses, [f64; 2]) {
        let (inertia, friction, half_gap) = (2e-3, 0.1, 1e-3);
        let stiffness = inertia * (TAU * frequency) * (TAU * frequency);
        let (mut torque, mut motor, mut position) = (0.3, 10.0, 0.0);
        let mut load = motor + 0.2 / (stiffness * inertia).sqrt();
        let sample = |position: f64| Sample {
            position,
            current: 1.0,
            fall: 0.0,
            ticks: 1,
        };
        let mut samples = vec![sample(position)];
        let h = 5e-7;
        let steps = (Clock::SERVO.period_s() / h).round() as u32;
        while samples.len() < WARM_UP {
            for _ in 0..steps {
                motor += h * (1.0 - torque) / KNOWN.inertia;
                load += h * (torque - friction) / inertia;
                torque += h * stiffness * (motor - load);
                position += h * motor;
            }
            samples.push(sample(position));
        }
        let mut window = Window::default();
        (window.side, window.torque, window.samples) = (1, 0.5, samples);
        let at = [half_gap, friction, 0.0, inertia, 0.0, stiffness, 0.0];
        (window, uniform(&at, 0.0), [torque, load])
    }

    #[test]
    fn a_load_that_swings_is_found_where_it_is() {
        for frequency in [12.0, 30.0, 80.0, 200.0] {
            let (window, p, [torque, speed]) = swinging(frequency);
            let mut progress = Progress::start(&window, &p);
            let mut stays = Stays::default();
            while progress
                .step(
                    pulp::Scalar::new(),
                    (&KNOWN, &p),
                    &mut stays,
                    &window,
                    LANES,
                )
                .is_some()
            {}
            let found = p.stiffness[0] * (progress.lead[0] - p.half_gap[0]);
            // an error of the speed as the torque that it swings to
            let swings = (progress.load_speed[0] - speed) * (p.stiffness[0] * p.inertia[0]).sqrt();
            let off = (found - torque).abs().max(swings.abs());
            assert!(off < 0.01, "{frequency} Hz: {off}");
        }
    }
}
