//! The load replayed: its motion under the motor's own, against the measured torque.
//!
//! The motor's position is known to an encoder's count, so it is taken for exact and drives the
//! load through gap and shaft, integrated in small steps:
//! ```text
//! T = (z(y) + tau y')/c  where |y| > b,   y = theta_M - theta_L,   J_L x'' = T - b_L x' - T_f sign(x') - T_0
//! ```
//! The contact torque that comes out is averaged with the windows' triangle and compared with the
//! measured one, the current less what the motor itself takes. Contact ties the load to the motor,
//! so that no error adds up over the log, and the noise of the current is in the target alone,
//! where it biases nothing. The fit over crossings adds the torque up twice, and with it its noise.

use lostmotion_base::math;

use crate::{huber::Regression, result::FittedLoad, window::WindowSample};

/// Places of the coefficients.
pub(super) const HALF_GAP: usize = 0;
pub(super) const COMPLIANCE: usize = 1;
pub(super) const DAMPING_TIME: usize = 2;
pub(super) const INERTIA: usize = 3;
pub(super) const COULOMB: usize = 4;
pub(super) const VISCOUS: usize = 5;
const CONSTANT: usize = 6;
/// How much later than the positions the current was logged, s.
pub(super) const LATENESS: usize = 7;
/// Number of coefficients.
pub(super) const REPLAYED: usize = 8;

/// Largest product of the shaft's angular frequency and the integration's step. A choice: a tenth
/// of the stability limit of the leapfrog method.
const MAX_PHASE_STEP: f64 = 0.2;
/// Steps of the numeric derivatives, in parts of a coefficient's size. A choice: large enough to
/// average over single impacts that move from one integration step to the next.
const DERIVATIVE_SHARE: f64 = 3e-3;
/// Points that are replayed side by side: one for each derivative, and the point itself.
pub(super) const LANES: usize = 8;
/// Most steps of the integration between two samples. A choice: bounds the work.
const MAX_STEPS: f64 = 400.0;
/// Time from the log's start that is left out, s: where in the gap the load stood is not known.
const LEAD_IN_S: f64 = 0.3;
/// Damping time whose changes count, s. A choice: usual shafts have 0.01 to 0.2 ms.
const USUAL_DAMPING_TIME_S: f64 = 5e-5;
/// Damping ratio of the shaft to begin with. A choice: those of feed drives are 0.02 to 0.1.
const USUAL_DAMPING_RATIO: f64 = 0.05;
/// Friction in parts of the largest torque that counts as a change. A choice.
const FRICTION_SHARE: f64 = 0.02;

/// A log to replay.
pub(super) struct Replay<'a> {
    motor_rad: &'a [f64],
    /// Change of the motor's position at each sample, rad per sample, of the cubic spline.
    slopes: &'a [f64],
    period_s: f64,
    windows: &'a [WindowSample],
    /// Samples between windows.
    pub(super) half: usize,
    /// Rate of the motor's torque at each window, N m/s.
    rates: Vec<f64>,
    /// Longest step of the integration, s.
    longest_step_s: f64,
    /// Largest contact torque, N m, and speed, rad/s: the sizes of friction.
    largest_nm: f64,
    fastest_rad_s: f64,
}

/// Gap, shaft and load, by their places.
pub(super) type Coefficients = [f64; REPLAYED];

/// The problem about a point.
pub(super) struct Linearised {
    pub(super) residuals: Vec<f64>,
    pub(super) problem: Regression<REPLAYED>,
}

/// A first guess for a gap and a compliance; `motor_inertia_kgm2` swings against the load's.
pub(super) fn guess(
    half_gap_rad: f64,
    compliance: f64,
    load: &FittedLoad,
    motor_inertia_kgm2: f64,
) -> Coefficients {
    let both = load.inertia_kgm2 * motor_inertia_kgm2 / (load.inertia_kgm2 + motor_inertia_kgm2);
    [
        half_gap_rad,
        compliance,
        2.0 * USUAL_DAMPING_RATIO * (compliance * both).sqrt(),
        load.inertia_kgm2,
        load.coulomb_nm,
        load.viscous_nm_s_per_rad,
        load.constant_nm,
        0.0,
    ]
}

/// The load that goes with coefficients.
pub(super) fn load_of(x: &Coefficients) -> FittedLoad {
    FittedLoad {
        inertia_kgm2: x[INERTIA],
        viscous_nm_s_per_rad: x[VISCOUS],
        coulomb_nm: x[COULOMB],
        constant_nm: x[CONSTANT],
    }
}

impl<'a> Replay<'a> {
    pub(super) fn new(
        (motor_rad, slopes): (&'a [f64], &'a [f64]),
        period_s: f64,
        (windows, half): (&'a [WindowSample], usize),
        motor_inertia_kgm2: f64,
        largest_nm: f64,
        longest_step_s: f64,
    ) -> Self {
        // What the motor gives beyond its own friction: it is this that comes late.
        let torque = |n: usize| {
            let window = &windows[n.min(windows.len() - 1)];
            window.torque_nm + motor_inertia_kgm2 * window.acceleration_rad_s2
        };
        let spacing_s = half as f64 * period_s;
        Replay {
            motor_rad,
            slopes,
            period_s,
            windows,
            half,
            rates: (0..windows.len())
                .map(|n| (torque(n + 1) - torque(n.saturating_sub(1))) / (2.0 * spacing_s))
                .collect(),
            longest_step_s,
            largest_nm,
            fastest_rad_s: windows
                .iter()
                .map(|window| window.velocity_rad_s.abs())
                .fold(0.0, f64::max),
        }
    }

    /// Windows that count up to a time, s.
    pub(super) fn used(&self, until_s: f64) -> Vec<usize> {
        let spacing_s = self.half as f64 * self.period_s;
        let first = (LEAD_IN_S / spacing_s).ceil() as usize;
        let last = (until_s / spacing_s) as usize;
        (first..self.windows.len().min(last))
            .filter(|&n| self.windows[n].one_way && self.windows[n].whole)
            .collect()
    }

    /// Size of each coefficient, by which steps are measured.
    pub(super) fn sizes(&self, x: &Coefficients) -> Coefficients {
        let friction = FRICTION_SHARE * self.largest_nm;
        [
            x[HALF_GAP].max(1e-5),
            x[COMPLIANCE].max(1e-6),
            USUAL_DAMPING_TIME_S,
            x[INERTIA],
            x[COULOMB].max(friction),
            x[VISCOUS].max(friction / self.fastest_rad_s),
            friction,
            0.1 * self.period_s,
        ]
    }

    /// Residuals at a point, and the problem about it: derivatives as rows, targets that leave the
    /// residuals.
    pub(super) fn about(&self, x: &Coefficients, used: &[usize]) -> Linearised {
        let sizes = self.sizes(x);
        // The last lane is the point itself; what a lateness does is known without a replay.
        let points: [Coefficients; LANES] = std::array::from_fn(|lane| {
            let mut moved = *x;
            if lane < LATENESS {
                moved[lane] += DERIVATIVE_SHARE * sizes[lane];
            }
            moved
        });
        let all = self.residuals(&points, used);
        let rows: Vec<Coefficients> = all
            .iter()
            .zip(used)
            .map(|(at, &n)| {
                std::array::from_fn(|j| {
                    if j == LATENESS {
                        -self.rates[n]
                    } else {
                        (at[LATENESS] - at[j]) / (DERIVATIVE_SHARE * sizes[j])
                    }
                })
            })
            .collect();
        let residuals: Vec<f64> = all.iter().map(|at| at[LATENESS]).collect();
        let targets = rows
            .iter()
            .zip(&residuals)
            .map(|(row, residual)| residual + lostmotion_base::vec::dot(*row, *x))
            .collect();
        Linearised {
            residuals,
            problem: Regression {
                rows,
                targets,
                nonnegative: [false; REPLAYED],
            },
        }
    }

    /// Measured less replayed torque of these windows at each point, N m.
    pub(super) fn residuals(
        &self,
        points: &[Coefficients; LANES],
        used: &[usize],
    ) -> Vec<[f64; LANES]> {
        let last = used.last().map_or(0, |n| (n + 2) * self.half);
        let torques = self.replay(points, last.min(self.motor_rad.len() - 1));
        used.iter()
            .map(|&n| {
                let replayed = self.averaged(&torques, n);
                std::array::from_fn(|lane| {
                    let late = points[lane][LATENESS] * self.rates[n];
                    self.windows[n].torque_nm + late - replayed[lane]
                })
            })
            .collect()
    }

    /// Mean under a window's triangle, whose weights are straight lines within every sample.
    fn averaged(&self, torques: &[[[f64; LANES]; 2]], window: usize) -> [f64; LANES] {
        let centre = (window + 1) * self.half;
        let area = (self.half * self.half) as f64;
        let weight = |sample: usize| (self.half - sample.abs_diff(centre)) as f64 / area;
        let mut sums = [0.0; LANES];
        let inside = (centre - self.half..centre + self.half).zip(&torques[centre - self.half..]);
        for (n, [mean, moment]) in inside {
            let (start, end) = (weight(n), weight(n + 1));
            for lane in 0..LANES {
                sums[lane] += start * mean[lane] + (end - start) * moment[lane];
            }
        }
        sums
    }

    /// Mean and first moment of the contact torque between samples, for this many samples.
    fn replay(&self, points: &[Coefficients; LANES], samples: usize) -> Vec<[[f64; LANES]; 2]> {
        let lanes = |of: &dyn Fn(&Coefficients) -> f64| -> [f64; LANES] {
            std::array::from_fn(|lane| of(&points[lane]))
        };
        let stiffness = lanes(&|x| 1.0 / x[COMPLIANCE]);
        // One step for all, short enough for the stiffest shaft.
        let longest = points
            .iter()
            .map(|x| MAX_PHASE_STEP * (x[COMPLIANCE] * x[INERTIA]).sqrt())
            .fold(self.longest_step_s, f64::min);
        let steps = (self.period_s / longest).ceil().clamp(4.0, MAX_STEPS) as usize;
        let share = 1.0 / steps as f64;
        let (step_s, rate) = (self.period_s * share, 1.0 / self.period_s);
        let half_step_s = 0.5 * step_s;
        let half_gap = lanes(&|x| x[HALF_GAP]);
        // A damping that would overshoot within a step is none of a shaft.
        let damping =
            lanes(&|x| (x[DAMPING_TIME] / x[COMPLIANCE]).clamp(0.0, 0.5 * x[INERTIA] / step_s));
        let gain = lanes(&|x| step_s / x[INERTIA]);
        let held = lanes(&|x| step_s / x[INERTIA] * x[COULOMB].max(0.0));
        let (viscous, constant) = (lanes(&|x| x[VISCOUS]), lanes(&|x| x[CONSTANT]));
        let start = self.motor_rad.first().copied().unwrap_or(0.0);
        let (mut load, mut speed) = ([start; LANES], [0.0; LANES]);
        let mut torques = Vec::with_capacity(samples);
        for (ends, slopes) in self
            .motor_rad
            .windows(2)
            .zip(self.slopes.windows(2))
            .take(samples)
        {
            // The spline's cubic between two samples.
            let (start, way) = (ends[0], ends[1] - ends[0]);
            let bend = 3.0 * way - 2.0 * slopes[0] - slopes[1];
            let twist = slopes[0] + slopes[1] - 2.0 * way;
            let (mut mean, mut moment) = ([0.0; LANES], [0.0; LANES]);
            for k in 0..steps {
                let s = (k as f64 + 0.5) * share;
                let motor = start + s * (slopes[0] + s * (bend + s * twist));
                let motor_speed = rate * (slopes[0] + s * (2.0 * bend + 3.0 * s * twist));
                for lane in 0..LANES {
                    // Half a step of drift, the torque there, half a step of drift: leapfrog.
                    let middle = load[lane] + half_step_s * speed[lane];
                    let angle = motor - middle;
                    let inside = angle.max(-half_gap[lane]).min(half_gap[lane]);
                    let depth = angle - inside;
                    let pressed =
                        stiffness[lane] * depth + damping[lane] * (motor_speed - speed[lane]);
                    let torque = if depth == 0.0 { 0.0 } else { pressed };
                    mean[lane] += torque;
                    moment[lane] += torque * s;
                    // Coulomb friction holds what is too slow to overcome it within a step.
                    let free = speed[lane]
                        + gain[lane] * (torque - constant[lane] - viscous[lane] * speed[lane]);
                    speed[lane] = free - free.max(-held[lane]).min(held[lane]);
                    load[lane] = middle + half_step_s * speed[lane];
                }
            }
            torques.push([mean.map(|sum| sum * share), moment.map(|sum| sum * share)]);
        }
        torques
    }
}

/// Slopes per sample of the natural cubic spline through these values.
pub(super) fn spline_slopes(values: &[f64]) -> Vec<f64> {
    let count = values.len();
    let at = |n: usize| values[n.min(count - 1)];
    // d(n-1) + 4 d(n) + d(n+1) = 3 (y(n+1) - y(n-1)), at the ends 2 d(0) + d(1) = 3 (y(1) - y(0)).
    let mut ratios = Vec::with_capacity(count);
    let mut slopes = Vec::with_capacity(count);
    let (mut ratio, mut slope) = (0.0, 0.0);
    for n in 0..count {
        let end = n == 0 || n + 1 == count;
        let right = 3.0 * (at(n + 1) - at(n.saturating_sub(1)));
        let pivot = if end { 2.0 } else { 4.0 } - ratio;
        slope = (right - slope) / pivot;
        ratio = 1.0 / pivot;
        ratios.push(ratio);
        slopes.push(slope);
    }
    // Back substitution.
    for n in (0..count.saturating_sub(1)).rev() {
        slopes[n] -= ratios[n] * slopes[n + 1];
    }
    slopes
}

/// Values from `least` to `most` at one ratio.
pub(super) fn geometric(least: f64, most: f64, count: usize) -> Vec<f64> {
    (0..count)
        .map(|n| least * math::pow(most / least, n as f64 / (count.max(2) - 1) as f64))
        .collect()
}

/// Share of a vibration that the natural cubic spline through its samples loses, at this frequency
/// in cycles per sample: one less the response of the cardinal spline, `3 sinc^4(x)/(2 + cos 2 pi x)`
/// (Unser, Splines: a perfect fit, 1999).
pub(super) fn spline_loss(cycles: f64) -> f64 {
    let phase = std::f64::consts::PI * cycles;
    if phase < 1e-3 {
        return 0.0;
    }
    let sinc = math::sin(phase) / phase;
    1.0 - 3.0 * sinc * sinc * sinc * sinc / (2.0 + math::cos(2.0 * phase))
}
