//! Gauss-Newton over the unknowns of a window, pass by pass.
//!
//! ```text
//! least of  sum e^2/S / max(1, misfit) + (p - p0)' A (p - p0)         e: innovations, S: their variance, A: information beforehand
//! (E' E / scale + A) dp = -(E' e / scale + A (p - p0))               E: differences of e from lane to lane
//! ```
//! A step that makes it worse is halved. The half gap's entry of the inverse at the end is its
//! variance.

use super::lanes::{Innovation, Lanes};
use super::prior::{GAP, N, Prior, Vector};
use crate::readings::LEAST_PIVOT;
use lostmotion_base::linalg::{cholesky, cholesky_solve};
use serde::{Deserialize, Serialize};

/// Passes at most.
const MOST_STEPS: u32 = 12;
/// By how much the cost over the scale still falls where no more is to be found.
const CONVERGED: f64 = 0.3;
/// Part of the half gap that a step moves it at most.
const FARTHEST: f64 = 0.3;

/// Sums over a pass: squares in all lanes, normal equations from their differences.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Sums {
    pub(super) cost: Lanes,
    normal: [Vector; N],
    right: Vector,
}

impl Sums {
    /// Takes the innovations of a sample; only their squares where no derivatives are wanted.
    pub(super) fn add(&mut self, innovation: &Innovation, derivatives: bool) {
        let (weight, e) = (1.0 / innovation.variance, &innovation.e);
        for (sum, e) in self.cost.iter_mut().zip(e) {
            *sum += weight * e * e;
        }
        if !derivatives {
            return;
        }
        let slope: Vector = std::array::from_fn(|i| e[i + 1] - e[0]);
        for i in 0..N {
            self.right[i] -= weight * slope[i] * e[0];
            for j in 0..=i {
                self.normal[i][j] += weight * slope[i] * slope[j];
            }
        }
    }
}

/// A point that was better than those before: its cost, mean square of its innovations over their
/// variance, step from it, variance of its half gap.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Accepted {
    pub(super) at: Vector,
    pub(super) misfit: f64,
    pub(super) variance: f64,
    cost: f64,
    step: Vector,
}

/// The search.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Newton {
    /// Point of the present pass.
    pub(super) at: Vector,
    pub(super) accepted: Option<Accepted>,
    passes: u32,
}

impl Newton {
    pub(super) fn new(at: Vector) -> Newton {
        Newton {
            at,
            accepted: None,
            passes: 0,
        }
    }

    /// Takes up a pass over `count` samples; says whether it was the last.
    pub(super) fn take(&mut self, sums: &Sums, count: f64, prior: &Prior, step: &Vector) -> bool {
        self.passes += 1;
        let last = self.passes >= MOST_STEPS;
        let (mean, information) = (prior.mean(), prior.information());
        let off: Vector =
            std::array::from_fn(|i| if i == GAP { 0.0 } else { self.at[i] - mean[i] });
        let pull: Vector = information.map(|row| row.iter().zip(off).map(|(a, x)| a * x).sum());
        let cost = sums.cost[0] + pull.iter().zip(off).map(|(a, x)| a * x).sum::<f64>();
        let before = self
            .accepted
            .map_or(f64::INFINITY, |accepted| accepted.cost);
        if !cost.is_finite() || cost > before {
            return !self.halve() || last;
        }
        let misfit = sums.cost[0] / count;
        let (moves, variance) = solve_step(sums, misfit.max(1.0), &information, &pull, step);
        let at = self.at;
        let moved: Vector = std::array::from_fn(|i| {
            let most = if i == GAP {
                FARTHEST * at[GAP]
            } else {
                f64::INFINITY
            };
            (at[i] + moves[i].max(-most).min(most)).max(prior.least()[i])
        });
        self.accepted = Some(Accepted {
            at,
            misfit,
            variance,
            cost,
            step: std::array::from_fn(|i| moved[i] - at[i]),
        });
        self.at = moved;
        let small =
            (moved[GAP] - at[GAP]).abs() < (0.1 * variance.max(0.0).sqrt()).max(1e-3 * at[GAP]);
        small && before - cost < CONVERGED * misfit.max(1.0) || last
    }

    /// Goes half as far from the last good point; says whether there is one.
    fn halve(&mut self) -> bool {
        let Some(accepted) = &mut self.accepted else {
            return false;
        };
        accepted.step = accepted.step.map(|step| 0.5 * step);
        self.at = std::array::from_fn(|i| accepted.at[i] + accepted.step[i]);
        true
    }
}

/// Step of the unknowns and variance of the half gap.
fn solve_step(
    sums: &Sums,
    scale: f64,
    information: &[Vector; N],
    pull: &Vector,
    step: &Vector,
) -> (Vector, f64) {
    let mut a = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..=i {
            a[i][j] = sums.normal[i][j] / scale + information[i][j] * step[i] * step[j];
        }
        a[i][i] = a[i][i] * (1.0 + 1e-9) + 1e-12;
    }
    let right: Vector = std::array::from_fn(|i| sums.right[i] / scale - pull[i] * step[i]);
    let (l, mut unit) = (cholesky(&a, LEAST_PIVOT), [0.0; N]);
    unit[GAP] = 1.0;
    let x = cholesky_solve(&l, &right);
    (
        std::array::from_fn(|i| x[i] * step[i]),
        cholesky_solve(&l, &unit)[GAP] * step[GAP] * step[GAP],
    )
}
