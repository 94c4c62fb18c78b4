//! The load replayed: its motion under the motor's own, against the measured torque.
//!
//! The motor's position is known to an encoder's count, so it is taken for exact and drives the
//! load through gap and shaft, integrated in small steps:
//! ```text
//! T = (z(y) + tau y')/c  where |y| > b,   y = theta_M - theta_L,   J_L x'' = T - b_L x' - T_f sign(x') - T_0
//! ```
//! The contact torque that comes out is averaged with the windows' triangle and compared with the
//! measured one. Gap, compliance, damping time, the load's inertia and friction and the lateness of
//! the current are those of least squares (output error; Gauss and Newton's step with Levenberg and
//! Marquardt's damping). Contact ties the load to the motor, so that no error adds up over the log,
//! and the noise of the current is in the target alone, where it biases nothing. The fit over
//! crossings adds the torque up twice, and with it its noise.
//!
//! The problem is not convex: an impact that comes at another time than the measured one is worse
//! than none. So it is first solved with windows that are longer than an impact's shift, from the
//! best of a grid of gaps and stiffnesses, and from there with short ones.

use lostmotion_base::math;

use crate::{
    huber::{NormalEquations, Piece, Regression, solve_small},
    result::FittedLoad,
    window::WindowSample,
};

/// Places of the coefficients.
pub(super) const HALF_GAP: usize = 0;
pub(super) const COMPLIANCE: usize = 1;
pub(super) const DAMPING_TIME: usize = 2;
const INERTIA: usize = 3;
const COULOMB: usize = 4;
const VISCOUS: usize = 5;
const CONSTANT: usize = 6;
/// How much later than the positions the current was logged, s.
pub(super) const LATENESS: usize = 7;
pub(super) const REPLAYED: usize = 8;

/// Longest steps of the integration with long and with short windows, s. A choice: shafts swing at
/// some 100 to 600 Hz.
pub(super) const LONGEST_STEPS_S: [f64; 2] = [50e-6, 25e-6];
/// Largest product of the shaft's angular frequency and the step. A choice: a tenth of the
/// stability limit of the semi-implicit Euler method.
const MAX_PHASE_STEP: f64 = 0.2;
/// Most rounds of Gauss and Newton, accepted or not, with long and with short windows.
pub(super) const MOST_ROUNDS: [usize; 2] = [12, 20];
/// Valleys of the grid from which the descent is tried. A choice: one is a rigid shaft.
const STARTS: usize = 3;
/// Relative fall of the cost that counts as none.
const SETTLED_SHARE: f64 = 1e-5;
/// Steps of the numeric derivatives, in parts of a coefficient's size. A choice: large enough to
/// average over single impacts that move from one integration step to the next.
const DERIVATIVE_SHARE: f64 = 3e-3;
/// Time from the log's start that is left out, s: nobody knows where in the gap the load stood.
const LEAD_IN_S: f64 = 0.3;
/// Half gaps of the grid, rad at the motor: from 1 um at a lead of 20 mm to 1 mm at one of 5.
const GRID_GAPS: (f64, f64, usize) = (1.5e-4, 0.3, 40);
/// Stiffnesses of the grid, N m/rad.
const GRID_STIFFNESSES: [f64; 3] = [60.0, 300.0, 2000.0];
/// Part of the log on which the grid is tried, s. A choice: a dozen strokes.
const GRID_SPAN_S: f64 = 6.0;
/// Longest damping time d/k, s. Origin as in `uncertainty`, halved: usual shafts have a tenth of it.
const MAX_DAMPING_TIME_S: f64 = 1e-3;
/// Latest and earliest current, s. A choice: more is a filter, whose lag depends on the frequency.
const MAX_LATENESS_S: f64 = 2e-3;
/// Ratio within which the inertia stays to that of the sliding load. A choice: the latter is known
/// to some parts in a hundred.
const INERTIA_DOUBT: f64 = 1.3;
/// Damping time to begin with, s. A choice: usual shafts have 0.01 to 0.2 ms.
const FIRST_DAMPING_TIME_S: f64 = 5e-5;

/// A log to replay.
pub(super) struct Replay<'a> {
    pub(super) motor_rad: &'a [f64],
    pub(super) period_s: f64,
    pub(super) windows: &'a [WindowSample],
    /// Samples between windows.
    pub(super) half: usize,
    /// Rate of the motor's torque at each window, N m/s.
    pub(super) rates: Vec<f64>,
    /// Longest step of the integration, s.
    pub(super) longest_step_s: f64,
    /// Largest contact torque, N m, and speed, rad/s: the sizes of friction.
    pub(super) largest_nm: f64,
    pub(super) fastest_rad_s: f64,
}

/// What was found.
pub(super) struct Replayed {
    pub(super) x: [f64; REPLAYED],
    /// Sum of squares of the residuals, (N m)^2.
    pub(super) cost: f64,
    /// The problem about the solution: derivatives as rows, targets that leave these residuals.
    pub(super) about: Regression<REPLAYED>,
    /// Window of each row.
    pub(super) windows: Vec<usize>,
    pub(super) rounds: u32,
    pub(super) settled: bool,
}

impl Replayed {
    /// The load as it was found.
    pub(super) fn load(&self) -> FittedLoad {
        FittedLoad {
            inertia_kgm2: self.x[INERTIA],
            viscous_nm_s_per_rad: self.x[VISCOUS],
            coulomb_nm: self.x[COULOMB],
            constant_nm: self.x[CONSTANT],
        }
    }
}

impl Replay<'_> {
    /// The best few of a grid of gaps and stiffnesses with this load, each with another gap.
    pub(super) fn starts(&self, load: &FittedLoad) -> Vec<[f64; REPLAYED]> {
        let span = (GRID_SPAN_S / (self.half as f64 * self.period_s)) as usize;
        let used = self.used(self.windows.len().min(span));
        let (least, most, count) = GRID_GAPS;
        let gap_at = |n: usize| {
            let part = n as f64 / (count - 1) as f64;
            least * math::pow(most / least, part)
        };
        // Of each gap the stiffness that goes best with it.
        let costs: Vec<(f64, [f64; REPLAYED])> = (0..count)
            .filter_map(|n| {
                GRID_STIFFNESSES
                    .into_iter()
                    .map(|stiffness| {
                        let x = [
                            gap_at(n),
                            1.0 / stiffness,
                            FIRST_DAMPING_TIME_S,
                            load.inertia_kgm2,
                            load.coulomb_nm,
                            load.viscous_nm_s_per_rad,
                            load.constant_nm,
                            0.0,
                        ];
                        (square(&self.residuals(&x, &used)), x)
                    })
                    .min_by(|a, b| a.0.total_cmp(&b.0))
            })
            .collect();
        // Valleys of the cost over the gap.
        let mut valleys: Vec<(f64, [f64; REPLAYED])> = (0..costs.len())
            .filter(|&n| {
                let lower = |m: Option<usize>| {
                    m.and_then(|m| costs.get(m))
                        .is_none_or(|other| costs[n].0 <= other.0)
                };
                lower(n.checked_sub(1)) && lower(Some(n + 1))
            })
            .map(|n| costs[n])
            .collect();
        valleys.sort_by(|a, b| a.0.total_cmp(&b.0));
        valleys.into_iter().take(STARTS).map(|(_, x)| x).collect()
    }

    /// Windows that count among the first so many.
    fn used(&self, windows: usize) -> Vec<usize> {
        let first = (LEAD_IN_S / (self.half as f64 * self.period_s)).ceil() as usize;
        (first..windows)
            .filter(|&n| self.windows[n].one_way && self.windows[n].whole)
            .collect()
    }

    /// Size of each coefficient, by which steps are measured.
    fn sizes(&self, x: &[f64; REPLAYED]) -> [f64; REPLAYED] {
        let friction = 0.02 * self.largest_nm;
        [
            x[HALF_GAP].max(1e-5),
            x[COMPLIANCE].max(1e-6),
            FIRST_DAMPING_TIME_S,
            x[INERTIA],
            x[COULOMB].max(friction),
            x[VISCOUS].max(friction / self.fastest_rad_s),
            friction,
            0.1 * self.period_s,
        ]
    }

    /// The minimum that lies downhill of here; `None` if the log has too little to tell.
    pub(super) fn descend(&self, mut x: [f64; REPLAYED], most_rounds: usize) -> Option<Replayed> {
        let used = &self.used(self.windows.len());
        if used.len() < 10 * REPLAYED {
            return None;
        }
        let start = x;
        let mut residuals = self.residuals(&x, used);
        let mut cost = square(&residuals);
        let (mut damping, mut settled, mut rounds) = (1e-2, false, 0);
        let mut rows = self.derivatives(&x, &residuals, used);
        for round in 1..=most_rounds {
            rounds = round as u32;
            let mut normal = NormalEquations::<REPLAYED>::default();
            for (row, residual) in rows.iter().zip(&residuals) {
                normal.add(row, *residual, Piece::Square);
            }
            for (j, line) in normal.matrix.iter_mut().enumerate() {
                // A column without any effect on the log stays where it is.
                line[j] = (line[j] * (1.0 + damping)).max(f64::MIN_POSITIVE.sqrt());
            }
            let step = solve_small(&normal.matrix, &normal.gradient)?;
            let next = bounded(std::array::from_fn(|j| x[j] + step[j]), &x, &start);
            let tried = self.residuals(&next, used);
            let found = square(&tried);
            if found < cost {
                settled = cost - found < SETTLED_SHARE * cost;
                (x, residuals, cost) = (next, tried, found);
                damping = (0.2 * damping).max(1e-9);
                rows = self.derivatives(&x, &residuals, used);
            } else {
                // Impacts make the cost rough: a minimum is also where no step helps any more.
                settled = damping > 1e2;
                damping *= 10.0;
            }
            if settled {
                break;
            }
        }
        let targets = rows
            .iter()
            .zip(&residuals)
            .map(|(row, residual)| residual + lostmotion_base::vec::dot(*row, x))
            .collect();
        Some(Replayed {
            x,
            cost,
            about: Regression {
                rows,
                targets,
                nonnegative: [false; REPLAYED],
            },
            windows: used.to_vec(),
            rounds,
            settled,
        })
    }

    /// How the residuals fall with each coefficient.
    fn derivatives(
        &self,
        x: &[f64; REPLAYED],
        residuals: &[f64],
        used: &[usize],
    ) -> Vec<[f64; REPLAYED]> {
        let sizes = self.sizes(x);
        let mut rows = vec![[0.0; REPLAYED]; used.len()];
        for (j, size) in sizes.into_iter().enumerate() {
            let step = DERIVATIVE_SHARE * size;
            let mut moved = *x;
            moved[j] += step;
            let moved = self.residuals(&moved, used);
            for ((row, at), from) in rows.iter_mut().zip(moved).zip(residuals) {
                row[j] = (from - at) / step;
            }
        }
        rows
    }

    /// Measured less replayed torque of these windows, N m.
    fn residuals(&self, x: &[f64; REPLAYED], used: &[usize]) -> Vec<f64> {
        let last = used.last().map_or(0, |n| (n + 2) * self.half);
        let torques = self.replay(x, last.min(self.motor_rad.len() - 1));
        used.iter()
            .map(|&n| {
                let measured = self.windows[n].torque_nm + x[LATENESS] * self.rates[n];
                measured - self.averaged(&torques, n)
            })
            .collect()
    }

    /// Mean under a window's triangle, whose weights are straight lines within every sample.
    fn averaged(&self, torques: &[[f64; 2]], window: usize) -> f64 {
        let centre = (window + 1) * self.half;
        let area = (self.half * self.half) as f64;
        let weight = |sample: usize| (self.half - sample.abs_diff(centre)) as f64 / area;
        (centre - self.half..centre + self.half)
            .zip(&torques[centre - self.half..])
            .map(|(n, [mean, moment])| weight(n) * (mean - moment) + weight(n + 1) * moment)
            .sum()
    }

    /// Mean and first moment of the contact torque between samples, for so many samples.
    fn replay(&self, x: &[f64; REPLAYED], samples: usize) -> Vec<[f64; 2]> {
        let [
            half_gap,
            compliance,
            damping_time,
            inertia,
            coulomb,
            viscous,
            constant,
            _,
        ] = *x;
        let stiffness = 1.0 / compliance;
        let frequency = (stiffness / inertia).sqrt();
        let longest = self.longest_step_s.min(MAX_PHASE_STEP / frequency);
        let steps = (self.period_s / longest).ceil().max(4.0) as usize;
        let share = 1.0 / steps as f64;
        let (step_s, rate) = (self.period_s * share, 1.0 / self.period_s);
        // A damping that would overshoot within a step is none of a shaft.
        let damping = (damping_time * stiffness).clamp(0.0, 0.5 * inertia / step_s);
        let (gain, held) = (step_s / inertia, step_s / inertia * coulomb);
        let motor = |n: usize| self.motor_rad[n.min(self.motor_rad.len() - 1)];
        let (mut load, mut speed) = (motor(0), 0.0_f64);
        let mut torques = Vec::with_capacity(samples);
        for n in 0..samples {
            // Hermite's cubic between two samples, slopes by central differences.
            let (start, end) = (motor(n), motor(n + 1));
            let slopes = [
                0.5 * (end - motor(n.saturating_sub(1))),
                0.5 * (motor(n + 2) - start),
            ];
            let way = end - start;
            let bend = 3.0 * way - 2.0 * slopes[0] - slopes[1];
            let twist = slopes[0] + slopes[1] - 2.0 * way;
            let (mut mean, mut moment) = (0.0, 0.0);
            for k in 0..steps {
                let s = (k as f64 + 0.5) * share;
                let angle = start + s * (slopes[0] + s * (bend + s * twist)) - load;
                let depth = angle - angle.clamp(-half_gap, half_gap);
                let torque = if depth == 0.0 {
                    0.0
                } else {
                    let motor_speed = rate * (slopes[0] + s * (2.0 * bend + 3.0 * s * twist));
                    stiffness * depth + damping * (motor_speed - speed)
                };
                mean += torque;
                moment += torque * s;
                // Coulomb friction holds what is too slow to overcome it within a step.
                let free = speed + gain * (torque - constant - viscous * speed);
                speed = free - free.clamp(-held, held);
                load += step_s * speed;
            }
            torques.push([mean * share, moment * share]);
        }
        torques
    }
}

/// Coefficients that a shaft can have with a load near the one that slides, `start`, not more than
/// halved or doubled in a step: far from the minimum a step may lead anywhere.
fn bounded(
    next: [f64; REPLAYED],
    from: &[f64; REPLAYED],
    start: &[f64; REPLAYED],
) -> [f64; REPLAYED] {
    std::array::from_fn(|j| match j {
        HALF_GAP | COMPLIANCE => next[j].clamp(0.5 * from[j], 2.0 * from[j]),
        INERTIA => next[j].clamp(start[j] / INERTIA_DOUBT, INERTIA_DOUBT * start[j]),
        DAMPING_TIME => next[j].clamp(0.0, MAX_DAMPING_TIME_S),
        COULOMB | VISCOUS => next[j].max(0.0),
        LATENESS => next[j].clamp(-MAX_LATENESS_S, MAX_LATENESS_S),
        _ => next[j],
    })
}

fn square(residuals: &[f64]) -> f64 {
    residuals.iter().map(|r| r * r).sum()
}
