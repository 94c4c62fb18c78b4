//! Stiffness, damping and the load's inertia from an excerpt: Gauss-Newton on what the linear
//! unknowns leave (variable projection).
//!
//! ```text
//! minimise  sum r(p)^2/s^2 + ((ln q - ln q0)/sigma)^2       p: ln k, damping ratio, ln q with q = 1/J_L; s: noise, or the residual if it is larger
//! ```
//! Golub, Pereyra, *The differentiation of pseudo-inverses and nonlinear least squares problems
//! whose variables separate*, SIAM J. Numer. Anal. 10, 1973.

use super::model::{Shaft, ShaftMotor};
use super::window::{Excerpt, LINEAR, Projected};
use crate::readings::LEAST_PIVOT;
use lostmotion_base::linalg::{cholesky, cholesky_solve};
use lostmotion_base::math;
use serde::{Deserialize, Serialize};

/// Parameters: ln k, damping ratio, ln 1/J_L.
const N: usize = 3;
type ShaftVector = [f64; N];

/// Differences for the derivatives, in ln k, damping ratio and ln 1/J_L: between rounding and
/// curvature.
const DERIVATIVE_STEP: f64 = 1e-4;
/// Bound of the steps. A choice: bounds the servo ticks of a reading.
const LARGEST_NUMBER_OF_STEPS: u32 = 14;
/// Step below which the search has converged: far below any uncertainty.
const CONVERGED_STEP: f64 = 1e-7;
/// Bound of one step: half a unit of the logarithms. A choice: less than two steps of the grid
/// (0.30 in ln k each).
const LONGEST_STEP: f64 = 0.5;
/// Bound of the damping ratio: above it nothing swings.
const LARGEST_DAMPING_RATIO: f64 = 2.0;
/// Lowest natural frequency of the grid, Hz. A choice: an excerpt of 40 ms holds half a period of
/// it.
const LOWEST_HZ: f64 = 12.0;
/// Highest natural frequency of the grid, Hz: a quarter of the sampling frequency.
const HIGHEST_HZ: f64 = 1000.0;
/// Ratio of consecutive frequencies of the grid: within the reach of Gauss-Newton. A choice: 30
/// frequencies; fewer may miss the valley, more cost as many servo ticks.
const FREQUENCY_RATIO: f64 = 1.16;
/// Damping ratios of the grid. A choice: a ringing shaft and a well damped one; more cost servo
/// ticks in proportion.
const DAMPING_RATIOS: [f64; 2] = [0.05, 0.3];
/// Inertias of the grid over that of the motor: the range of usual axes.
const INERTIA_RATIOS: [f64; 3] = [0.6, 2.0, 6.0];
/// Bounds of the load's inertia over that of the motor. A choice: far beyond any axis, so that the
/// search stays finite.
const INERTIA_LIMITS: [f64; 2] = [0.02, 1000.0];

/// Prior of `1/J_L`: value, and standard deviation of its logarithm.
pub(super) type ShaftPrior = Option<(f64, f64)>;

/// Result of an excerpt.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Found {
    pub(super) shaft: Shaft,
    /// Standard deviations of ln k and of the damping ratio.
    pub(super) doubt: [f64; 2],
    /// Squares of the residual over that of the noise, and their mean.
    pub(super) squares: f64,
    pub(super) misfit: f64,
    /// Structure in the residual (Box and Pierce's sum over the first lags): that of noise is about
    /// the number of lags.
    pub(super) structure: f64,
    /// Whether motor and load stay on one flank and the load goes one way.
    pub(super) stays: bool,
    /// What is left over what a rigid mass leaves, squares.
    pub(super) part: f64,
}

/// Starting points: frequencies in equal ratios, with each damping and inertia.
pub(super) fn grid(motor: &ShaftMotor, held: bool, prior: ShaftPrior) -> Vec<Shaft> {
    let mut list = Vec::new();
    let mut hz = LOWEST_HZ;
    while hz < HIGHEST_HZ {
        for damping_ratio in DAMPING_RATIOS {
            let mut add = |inverse_load: f64| {
                // k = omega^2/(1/J_M + 1/J_L)
                let frequency = std::f64::consts::TAU * hz;
                list.push(Shaft {
                    stiffness: frequency * frequency / (1.0 / motor.inertia + inverse_load),
                    damping_ratio,
                    inverse_load,
                });
            };
            match prior {
                _ if held => add(0.0),
                Some((inverse, _)) => add(inverse),
                None => INERTIA_RATIOS
                    .iter()
                    .for_each(|ratio| add(1.0 / (ratio * motor.inertia))),
            }
        }
        hz *= FREQUENCY_RATIO;
    }
    list
}

/// Gauss-Newton, step by step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ShaftNewton {
    at: ShaftVector,
    held: bool,
    /// The best so far with its cost, and the step that led away from it.
    best: Option<(ShaftVector, f64)>,
    step: ShaftVector,
    steps: u32,
}

impl ShaftNewton {
    pub(super) fn new(start: &Shaft) -> ShaftNewton {
        let held = start.inverse_load <= 0.0;
        let inverse = if held {
            0.0
        } else {
            math::log(start.inverse_load)
        };
        ShaftNewton {
            at: [math::log(start.stiffness), start.damping_ratio, inverse],
            held,
            best: None,
            step: [0.0; N],
            steps: 0,
        }
    }

    /// The shaft of a parameter vector; logarithms keep stiffness and inertia positive.
    fn shaft(&self, at: &ShaftVector) -> Shaft {
        Shaft {
            stiffness: math::exp(at[0]),
            damping_ratio: at[1],
            inverse_load: if self.held { 0.0 } else { math::exp(at[2]) },
        }
    }

    /// One step. At the end the result, if there is one.
    pub(super) fn work(
        &mut self,
        motor: &ShaftMotor,
        excerpt: &Excerpt,
        prior: ShaftPrior,
    ) -> Option<Option<Found>> {
        self.steps += 1;
        let here = excerpt.left_by(motor, &self.shaft(&self.at));
        // worse than the best point: back to it, with a shorter step
        if let Some((best, least)) = self
            .best
            .filter(|(_, least)| here.squares >= *least || here.squares.is_nan())
        {
            self.step = self.step.map(|step| 0.3 * step);
            if self.steps >= LARGEST_NUMBER_OF_STEPS
                || self.step.iter().all(|step| step.abs() < CONVERGED_STEP)
            {
                (self.at, self.best) = (best, Some((best, least)));
                return Some(self.end(motor, excerpt, prior));
            }
            self.at = self.bounded(motor, std::array::from_fn(|i| best[i] + self.step[i]));
            return None;
        }
        self.best = Some((self.at, here.squares));
        // better: a new Gauss-Newton step, its length bounded
        let step = self.gauss_newton(motor, excerpt, prior, &here);
        let most = step
            .iter()
            .fold(0.0, |most: f64, step| most.max(step.abs()));
        self.step = step.map(|step| step * (LONGEST_STEP / most).min(1.0));
        if self.steps >= LARGEST_NUMBER_OF_STEPS || most < CONVERGED_STEP {
            return Some(self.end(motor, excerpt, prior));
        }
        self.at = self.bounded(motor, std::array::from_fn(|i| self.at[i] + self.step[i]));
        None
    }

    /// Solves the normal equations of the projected residual, with the prior of the inertia.
    fn gauss_newton(
        &self,
        motor: &ShaftMotor,
        excerpt: &Excerpt,
        prior: ShaftPrior,
        here: &Projected,
    ) -> ShaftVector {
        // an error of the model counts as noise
        let noise = (motor.noise * motor.noise).max(here.squares / excerpt.len() as f64);
        let columns = self.derivatives(motor, excerpt, &here.left);
        let mut right: ShaftVector = columns.each_ref().map(|column| {
            -column
                .iter()
                .zip(&here.left)
                .map(|(a, b)| a * b)
                .sum::<f64>()
                / noise
        });
        if let Some((inverse, doubt)) = prior.filter(|_| !self.held) {
            right[2] -= (self.at[2] - math::log(inverse)) / (doubt * doubt);
        }
        cholesky_solve(
            &cholesky(&self.normal(&columns, noise, prior), LEAST_PIVOT),
            &right,
        )
    }

    /// Differences of the projected residual for each parameter.
    fn derivatives(&self, motor: &ShaftMotor, excerpt: &Excerpt, left: &[f64]) -> [Vec<f64>; N] {
        std::array::from_fn(|i| {
            if self.held && i == 2 {
                return vec![0.0; left.len()];
            }
            // one-sided differences of the projected residual: the linear unknowns follow each
            // change
            let mut at = self.at;
            at[i] += DERIVATIVE_STEP;
            let there = excerpt.left_by(motor, &self.shaft(&at));
            there
                .left
                .iter()
                .zip(left)
                .map(|(there, here)| (there - here) / DERIVATIVE_STEP)
                .collect()
        })
    }

    /// Information matrix: of the excerpt with that noise, and of the prior.
    fn normal(&self, columns: &[Vec<f64>; N], noise: f64, prior: ShaftPrior) -> [ShaftVector; N] {
        let dot = |i: usize, j: usize| {
            columns[i]
                .iter()
                .zip(&columns[j])
                .map(|(a, b)| a * b)
                .sum::<f64>()
                / noise
        };
        let mut normal = std::array::from_fn(|i| std::array::from_fn(|j| dot(i, j)));
        // a held load has no inertia to estimate: any pivot keeps the system regular
        normal[2][2] += if self.held {
            1.0
        } else {
            prior.map_or(0.0, |(_, doubt)| 1.0 / (doubt * doubt))
        };
        normal
    }

    /// Parameters within the bounds of damping, inertia and frequency.
    fn bounded(&self, motor: &ShaftMotor, at: ShaftVector) -> ShaftVector {
        let [least, most] = INERTIA_LIMITS.map(|ratio| -math::log(ratio * motor.inertia));
        let [_, damping, inverse] = at;
        let inverse = if self.held {
            0.0
        } else {
            inverse.clamp(most, least)
        };
        // bounds of the frequency are bounds of ln k at this inertia: ln k = 2 ln omega - ln(1/J_M
        // + 1/J_L)
        let softest = math::log(self.shaft(&[0.0, 0.0, inverse]).frequency(motor));
        let [low, high] = [LOWEST_HZ, 2.0 * HIGHEST_HZ]
            .map(|hz| 2.0 * (math::log(std::f64::consts::TAU * hz) - softest));
        [
            at[0].clamp(low, high),
            damping.clamp(0.0, LARGEST_DAMPING_RATIO),
            inverse,
        ]
    }

    /// Uncertainty and tests at the best point; `None` where the uncertainty is not finite.
    fn end(&self, motor: &ShaftMotor, excerpt: &Excerpt, prior: ShaftPrior) -> Option<Found> {
        let shaft = self.shaft(&self.at);
        let here = excerpt.left_by(motor, &shaft);
        let noise = motor.noise * motor.noise;
        // misfit: squared residual over the noise, a degree of freedom
        let (squares, free) = (
            here.squares / noise,
            excerpt.len().saturating_sub(LINEAR + N),
        );
        let misfit = squares / free.max(1) as f64;
        let columns = self.derivatives(motor, excerpt, &here.left);
        let l = cholesky(
            &self.normal(&columns, noise * misfit.max(1.0), prior),
            LEAST_PIVOT,
        );
        // diagonal of the inverse information: Cramer-Rao bound, widened by the misfit
        let variance = |i: usize| {
            cholesky_solve(&l, &std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))[i]
        };
        let found = Found {
            shaft,
            doubt: [variance(0), variance(1)].map(f64::sqrt),
            squares,
            misfit,
            structure: structure(&here.left),
            stays: excerpt.stays(motor, &shaft, &here.unknowns),
            part: here.squares / excerpt.left_by_a_mass(motor).max(f64::MIN_POSITIVE),
        };
        found
            .doubt
            .iter()
            .all(|doubt| doubt.is_finite())
            .then_some(found)
    }
}

/// Lags over which structure is searched for. A choice that `LARGEST_STRUCTURE` depends on.
const STRUCTURE_LAGS: usize = 6;

/// Box and Pierce's sum, J. Amer. Statist. Assoc. 65 (1970): samples times the squared
/// autocorrelations.
fn structure(left: &[f64]) -> f64 {
    // autocorrelation at a lag; white noise has none
    let product = |lag: usize| {
        left.iter()
            .zip(left.iter().skip(lag))
            .map(|(a, b)| a * b)
            .sum::<f64>()
    };
    let squares = product(0).max(f64::MIN_POSITIVE);
    let lags = (1..=STRUCTURE_LAGS).map(|lag| product(lag) / squares);
    left.len() as f64 * lags.map(|part| part * part).sum::<f64>()
}
