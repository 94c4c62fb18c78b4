//! A record of the motor over some servo periods, and the trajectories that explain it, which are
//! linear in the unknown start and torques; detection of blows.

use super::model::{Shaft, ShaftMotor, ShaftStep};
use lostmotion_drive::Signals;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Unknowns that enter linearly: position, speed, twist, its rate at the start; the load's torque
/// at the start, and how far it goes over the window.
pub(super) const LINEAR: usize = 6;
/// Trajectories: that of the known torque, and those of the unknowns but the position, which only
/// shifts.
const TRAJECTORIES: usize = LINEAR;
/// Part of a column's length that is left after the others are projected out, below which it counts
/// as dependent on them: above rounding.
const DEPENDENT_SHARE: f64 = 1e-11;

/// The motor at the end of a servo period: position (rad), current then, and mean current over the
/// period (A).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct ShaftSample {
    pub(super) position: f64,
    pub(super) current: f64,
    pub(super) mean: f64,
}

/// One number for each linear unknown.
pub(super) type Row = [f64; LINEAR];

/// Residual of the positions after the projection onto the linear unknowns.
#[derive(Clone, Debug)]
pub(super) struct Projected {
    /// Residual, rad.
    pub(super) left: Vec<f64>,
    /// Sum of its squares, rad2.
    pub(super) squares: f64,
    /// The unknowns.
    pub(super) unknowns: Row,
}

/// Positions of a window relative to its start, rad, and the motor's torque over each period as a
/// parabola, N m.
#[derive(Clone, Debug)]
pub(super) struct Excerpt {
    positions: Vec<f64>,
    torques: Vec<[f64; 3]>,
}

impl Excerpt {
    /// Of consecutive samples; `way`: sign of the motor's speed.
    pub(super) fn new(motor: &ShaftMotor, samples: &[ShaftSample], way: f64) -> Excerpt {
        let start = samples.first().map_or(0.0, |first| first.position);
        let positions = samples
            .iter()
            .map(|sample| sample.position - start)
            .collect();
        // parabola over the period with these ends and this mean: from + b t/h + c (t/h)^2
        let parabola = |pair: &[ShaftSample]| {
            let [from, to, mean] = [pair[0].current, pair[1].current, pair[1].mean]
                .map(|current| motor.torque_constant * current);
            let bend = 3.0 * (from + to) - 6.0 * mean;
            [from - motor.coulomb * way, to - from - bend, bend]
        };
        Excerpt {
            positions,
            torques: samples.windows(2).map(parabola).collect(),
        }
    }

    /// Number of positions.
    pub(super) fn len(&self) -> usize {
        self.positions.len()
    }

    /// Residual of a shaft with the best start and load torque.
    pub(super) fn left_by(&self, motor: &ShaftMotor, shaft: &Shaft) -> Projected {
        let step = ShaftStep::new(motor, shaft);
        // trajectories: known torque, speed, twist, its rate, the load's torque and its slope
        let mut x = [[0.0; TRAJECTORIES]; 4];
        let held = shaft.inverse_load <= 0.0;
        // on a held load motor and twist have one speed, and there is no torque to tell from the
        // twist
        (x[1][1], x[3][1], x[2][2], x[3][3]) = (
            1.0,
            f64::from(u8::from(held)),
            1.0,
            f64::from(u8::from(!held)),
        );
        let torque = f64::from(u8::from(!held));
        let slope = torque / self.torques.len().max(1) as f64;
        let mut rows = Vec::with_capacity(self.len());
        let mut left = Vec::with_capacity(self.len());
        // positions are the only measurement; the start position shifts all of them
        let mut put = |x: &[f64; TRAJECTORIES], position: f64| {
            rows.push([1.0, x[1], x[2], x[3], x[4], x[5]]);
            left.push(position - x[0]);
        };
        put(&x[0], 0.0);
        for (n, (parabola, position)) in self
            .torques
            .iter()
            .zip(self.positions.iter().skip(1))
            .enumerate()
        {
            // the known torque acts on the first trajectory, the load's unit torques on the last
            // two
            let drive = parabola.map(|torque| [torque, 0.0, 0.0, 0.0, 0.0, 0.0]);
            let load = [
                [0.0, 0.0, 0.0, 0.0, torque, slope * n as f64],
                [0.0, 0.0, 0.0, 0.0, 0.0, slope],
            ];
            x = step.take(&x, &drive, &load);
            put(&x[0], *position);
        }
        Projected::new(rows, left)
    }

    /// Whether in a fit's solution motor and load stay on one flank and the load does not reverse.
    pub(super) fn stays(&self, motor: &ShaftMotor, shaft: &Shaft, unknowns: &Row) -> bool {
        let (step, damping) = (ShaftStep::new(motor, shaft), shaft.damping(motor));
        let [_, speed, twist, rate, torque, slope] = *unknowns;
        let held = shaft.inverse_load <= 0.0;
        let rate = if held { speed } else { rate };
        let slope = slope / self.torques.len().max(1) as f64;
        let mut x = [[0.0], [speed], [twist], [rate]];
        // torque of the shaft, and speed of the load
        let shown = |x: &[[f64; 1]; 4]| {
            [
                shaft.stiffness * x[2][0] + damping * x[3][0],
                x[1][0] - x[3][0],
            ]
        };
        let first = shown(&x);
        for (n, parabola) in self.torques.iter().enumerate() {
            x = step.take(
                &x,
                &parabola.map(|torque| [torque]),
                &[[torque + slope * n as f64], [slope]],
            );
            let now = shown(&x);
            if now[0] * first[0] <= 0.0 || (!held && now[1] * first[1] <= 0.0) {
                return false;
            }
        }
        true
    }

    /// Squared residual of a rigid mass of any inertia under the known torque and an unknown one that
    /// is a parabola over time, rad2.
    pub(super) fn left_by_a_mass(&self, motor: &ShaftMotor) -> f64 {
        let h = motor.period_s;
        let (mut way, mut speed) = (0.0, 0.0);
        let count = self.torques.len().max(1) as f64;
        // a parabola of torque makes a polynomial of fourth degree; the known torque enters through
        // the unknown inertia
        let row = |n: usize, way: f64| {
            let t = n as f64 / count;
            [1.0, t, t * t, t * t * t, t * t * t * t, way]
        };
        let mut rows = vec![row(0, 0.0)];
        for (n, [a, b, c]) in self.torques.iter().enumerate() {
            // exact integrals of the parabola over a period
            way += h * speed + h * h * (0.5 * a + b / 6.0 + c / 12.0);
            speed += h * (a + 0.5 * b + c / 3.0);
            rows.push(row(n + 1, way));
        }
        Projected::new(rows, self.positions.clone()).squares
    }
}

impl Projected {
    /// Projects `left` onto the complement of the columns of `rows` (Gram-Schmidt, each column twice
    /// against rounding).
    fn new(mut rows: Vec<Row>, mut left: Vec<f64>) -> Projected {
        let mut triangle = [[0.0; LINEAR]; LINEAR];
        for column in 0..LINEAR {
            let before: f64 = rows.iter().map(|row| row[column] * row[column]).sum();
            // once more removes what rounding left of the first projection
            for _ in 0..2 {
                let dots: Row = rows.iter().fold([0.0; LINEAR], |mut dots, row| {
                    (0..column).for_each(|other| dots[other] += row[other] * row[column]);
                    dots
                });
                for row in &mut rows {
                    row[column] -= (0..column)
                        .map(|other| dots[other] * row[other])
                        .sum::<f64>();
                }
                (0..column).for_each(|other| triangle[other][column] += dots[other]);
            }
            // a dependent column gets no unknown of its own
            let squares = rows
                .iter()
                .map(|row| row[column] * row[column])
                .sum::<f64>();
            let says = squares > DEPENDENT_SHARE * DEPENDENT_SHARE * before && squares > 0.0;
            triangle[column][column] = if says { squares.sqrt() } else { 0.0 };
            rows.iter_mut()
                .for_each(|row| row[column] *= if says { 1.0 / squares.sqrt() } else { 0.0 });
        }
        let (first, second) = (take_out(&rows, &mut left), take_out(&rows, &mut left));
        // back substitution gives the linear unknowns
        let mut unknowns = [0.0; LINEAR];
        for i in (0..LINEAR).rev() {
            let others: f64 = (i + 1..LINEAR).map(|j| triangle[i][j] * unknowns[j]).sum();
            unknowns[i] = if triangle[i][i] > 0.0 {
                (first[i] + second[i] - others) / triangle[i][i]
            } else {
                0.0
            };
        }
        Projected {
            squares: left.iter().map(|left| left * left).sum(),
            left,
            unknowns,
        }
    }
}

/// Subtracts the part of the orthonormal columns from `left`; returns the coefficients.
fn take_out(rows: &[Row], left: &mut [f64]) -> Row {
    let dots: Row = rows
        .iter()
        .zip(left.iter())
        .fold([0.0; LINEAR], |dots, (row, left)| {
            std::array::from_fn(|i| dots[i] + row[i] * left)
        });
    for (row, left) in rows.iter().zip(left) {
        *left -= row
            .iter()
            .zip(dots)
            .map(|(row, dot)| row * dot)
            .sum::<f64>();
    }
    dots
}

/// Corners of the fast and the slow momentum observer, rad/s: 240 Hz and 10 Hz. A choice: the slow
/// one lies below the lowest frequency searched for (12 Hz), a faster one would be louder with the
/// encoder's steps.
const CORNERS_RAD_S: [f64; 2] = [1500.0, 60.0];
/// Least difference of both that is a blow, part of the rated torque. A choice: smaller blows
/// hardly excite a shaft, and each costs a reading.
const BLOW_SHARE: f64 = 0.01;
/// The same in standard deviations of the fast observer's noise. A choice: normally distributed
/// noise exceeds it with a probability of 1e-15.
const BLOW_DEVIATIONS: f64 = 8.0;
/// Ratio of a blow to the envelope of the differences before it: the ringing after a blow is none.
/// A choice: higher misses a blow during the ringing, lower takes the ringing for one.
const BLOW_RATIO: f64 = 1.5;
/// Time constant of the envelope, s. A choice: two periods of a shaft that rings at 200 Hz.
const ENVELOPE_S: f64 = 0.01;
/// Samples kept from before a blow: 2.5 ms, more than the fast observer's delay.
pub(super) const SAMPLES_BEFORE: usize = 10;
/// Samples of a window: 62.5 ms.
pub(super) const WINDOW_SAMPLES: usize = 250;

/// Detection of blows on the shaft: a fast and a slow momentum observer of the torque behind the
/// motor, the last samples, and the window under way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct ShaftWatch {
    momentum: [f64; 2],
    torque: [f64; 2],
    envelope: f64,
    recent: VecDeque<ShaftSample>,
    window: Option<Vec<ShaftSample>>,
    ticks: u32,
}

impl ShaftWatch {
    /// One servo tick. Returns a window that is complete.
    pub(super) fn step(
        &mut self,
        motor: &ShaftMotor,
        signals: &Signals,
    ) -> Option<Vec<ShaftSample>> {
        let speed = signals.motor_velocity;
        let friction = motor.viscous * speed
            + if speed == 0.0 {
                0.0
            } else {
                motor.coulomb * speed.signum()
            };
        let drive = motor.torque_constant * signals.mean_current - friction;
        // momentum observer: torque = omega (z - J_M w), low pass of the shaft's torque
        for ((momentum, torque), corner) in self
            .momentum
            .iter_mut()
            .zip(&mut self.torque)
            .zip(CORNERS_RAD_S)
        {
            *momentum += motor.period_s * (drive - *torque);
            *torque = corner * (*momentum - motor.inertia * speed);
        }
        // a blow reaches the fast observer first
        let apart = (self.torque[0] - self.torque[1]).abs();
        // noise of the fast observer: velocity is a difference of two readings
        let noise = CORNERS_RAD_S[0] * motor.inertia * motor.noise * std::f64::consts::SQRT_2
            / motor.period_s;
        let blow = apart > (BLOW_SHARE * motor.rated_torque).max(BLOW_DEVIATIONS * noise)
            && apart > BLOW_RATIO * self.envelope;
        self.envelope = apart.max(self.envelope * (1.0 - motor.period_s / ENVELOPE_S));
        let sample = ShaftSample {
            position: signals.motor_position,
            current: signals.current,
            mean: signals.mean_current,
        };
        if self.recent.len() >= SAMPLES_BEFORE {
            self.recent.pop_front();
        }
        self.recent.push_back(sample);
        self.ticks = self.ticks.saturating_add(1);
        // a new blow discards the window under way: a solution has to begin behind it
        if blow {
            self.window = Some(self.recent.iter().copied().collect());
            return None;
        }
        let window = self.window.as_mut()?;
        window.push(sample);
        if window.len() < WINDOW_SAMPLES {
            return None;
        }
        self.window.take()
    }
}
