//! What the motor did over some servo periods, and what explains it: trajectories that are linear
//! in the unknown start and torques.

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
/// A column that is smaller than this part of itself after the others are taken out of it says
/// nothing of its own.
const DEPENDENT: f64 = 1e-11;

/// The motor at the end of a servo period: position (rad), current then, and mean current over the
/// period (A).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct ShaftSample {
    pub(super) position: f64,
    pub(super) current: f64,
    pub(super) mean: f64,
}

/// Numbers of a sample: one for each linear unknown.
pub(super) type Row = [f64; LINEAR];

/// What is left of the positions once the linear unknowns are taken out.
#[derive(Clone, Debug)]
pub(super) struct Projected {
    /// What is left, rad.
    pub(super) left: Vec<f64>,
    /// Sum of squares of it.
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
    /// Of samples that follow each other; `way`: sign of the motor's speed.
    pub(super) fn new(motor: &ShaftMotor, samples: &[ShaftSample], way: f64) -> Excerpt {
        let start = samples.first().map_or(0.0, |first| first.position);
        let positions = samples
            .iter()
            .map(|sample| sample.position - start)
            .collect();
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

    /// What a shaft cannot explain, whatever start and torques.
    pub(super) fn left_by(&self, motor: &ShaftMotor, shaft: &Shaft) -> Projected {
        let step = ShaftStep::new(motor, shaft);
        // known torque, speed, twist, its rate, the load's torque and its slope
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

    /// Whether motor and load stay on one flank and the load goes one way, with what a fit has
    /// found.
    pub(super) fn stays(&self, motor: &ShaftMotor, shaft: &Shaft, unknowns: &Row) -> bool {
        let (step, damping) = (ShaftStep::new(motor, shaft), shaft.damping(motor));
        let [_, speed, twist, rate, torque, slope] = *unknowns;
        let held = shaft.inverse_load <= 0.0;
        let rate = if held { speed } else { rate };
        let slope = slope / self.torques.len().max(1) as f64;
        let mut x = [[0.0], [speed], [twist], [rate]];
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

    /// What a rigid mass of whatever inertia cannot explain, under a torque that bends as a
    /// parabola besides the known one: sum of squares, rad2.
    pub(super) fn left_by_a_mass(&self, motor: &ShaftMotor) -> f64 {
        let h = motor.period_s;
        let (mut way, mut speed) = (0.0, 0.0);
        let count = self.torques.len().max(1) as f64;
        let row = |n: usize, way: f64| {
            let t = n as f64 / count;
            [1.0, t, t * t, t * t * t, t * t * t * t, way]
        };
        let mut rows = vec![row(0, 0.0)];
        for (n, [a, b, c]) in self.torques.iter().enumerate() {
            way += h * speed + h * h * (0.5 * a + b / 6.0 + c / 12.0);
            speed += h * (a + 0.5 * b + c / 3.0);
            rows.push(row(n + 1, way));
        }
        Projected::new(rows, self.positions.clone()).squares
    }
}

impl Projected {
    /// Takes out of `left` what the columns of `rows` explain (modified Gram-Schmidt, each column
    /// twice).
    fn new(mut rows: Vec<Row>, mut left: Vec<f64>) -> Projected {
        let mut triangle = [[0.0; LINEAR]; LINEAR];
        for column in 0..LINEAR {
            let before: f64 = rows.iter().map(|row| row[column] * row[column]).sum();
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
            let squares = rows
                .iter()
                .map(|row| row[column] * row[column])
                .sum::<f64>();
            let says = squares > DEPENDENT * DEPENDENT * before && squares > 0.0;
            triangle[column][column] = if says { squares.sqrt() } else { 0.0 };
            rows.iter_mut()
                .for_each(|row| row[column] *= if says { 1.0 / squares.sqrt() } else { 0.0 });
        }
        let (first, second) = (take_out(&rows, &mut left), take_out(&rows, &mut left));
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

/// Takes the columns' part out of `left`; says how much of each it was.
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

// Where something hits the shaft: two momentum observers of the torque behind the motor, a quick
// one and a slow one, part.

/// Corners, rad/s.
const CORNERS_RAD_S: [f64; 2] = [1500.0, 60.0];
/// How far they have to part: part of the rated torque, and standard deviations of the quick one's
/// noise.
const PART: f64 = 0.01;
const NOISES: f64 = 8.0;
/// A blow is a difference so many times what it was, which fades with this time, s.
const JUMP: f64 = 1.5;
const FADES_S: f64 = 0.01;
/// Samples kept from before a blow and in all.
pub(super) const BEFORE: usize = 10;
pub(super) const LENGTH: usize = 250;

/// Observers, the last samples, and the window under way.
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
    /// One tick. Gives a window that is complete.
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
        for ((momentum, torque), corner) in self
            .momentum
            .iter_mut()
            .zip(&mut self.torque)
            .zip(CORNERS_RAD_S)
        {
            *momentum += motor.period_s * (drive - *torque);
            *torque = corner * (*momentum - motor.inertia * speed);
        }
        let apart = (self.torque[0] - self.torque[1]).abs();
        let noise = CORNERS_RAD_S[0] * motor.inertia * motor.noise * std::f64::consts::SQRT_2
            / motor.period_s;
        let blow =
            apart > (PART * motor.rated_torque).max(NOISES * noise) && apart > JUMP * self.envelope;
        self.envelope = apart.max(self.envelope * (1.0 - motor.period_s / FADES_S));
        let sample = ShaftSample {
            position: signals.motor_position,
            current: signals.current,
            mean: signals.mean_current,
        };
        if self.recent.len() >= BEFORE {
            self.recent.pop_front();
        }
        self.recent.push_back(sample);
        self.ticks = self.ticks.saturating_add(1);
        if blow {
            self.window = Some(self.recent.iter().copied().collect());
            return None;
        }
        let window = self.window.as_mut()?;
        window.push(sample);
        if window.len() < LENGTH {
            return None;
        }
        self.window.take()
    }
}
