//! Gauss-Newton over the unknowns of a window, pass by pass.
//!
//! ```text
//! minimise  sum e^2/S/max(0.3, misfit) + (p - p0)' A (p - p0)          e: innovations, S: their variance, A: prior information
//! step      (E' E/scale + A) dp = -(E' e/scale + A (p - p0))         E: differences of e from lane to lane, scale = max(0.3, misfit)
//! ```
//! Each pass runs the eight lanes over the window: the point itself, and the point with one unknown
//! changed, so that derivatives are finite differences. A step that increases the cost is halved, as long as
//! what is left of it promises to lower the cost.
//! The half gap's entry of the inverse normal matrix at the end is its variance (Cramer-Rao).

use super::lanes::{Innovation, Lanes};
use super::prior::{GAP, N, OF_LOAD, Prior, Vector};
use crate::readings::LEAST_PIVOT;
use lostmotion_base::linalg::{cholesky, cholesky_solve};
use serde::{Deserialize, Serialize};

/// Bound of the passes; a search usually ends by `CONVERGED_FALL`. Raised from 6 when derivatives
/// were taken closer together (record 63 of the decisions).
const LARGEST_NUMBER_OF_PASSES: u32 = 12;
/// Fall of the cost, over the scale, below which the search has converged: a fraction of the one
/// that a standard deviation makes; and as much as two make where another search goes on from there.
const CONVERGED_FALL: f64 = 0.3;
const PASSED_ON_FALL: f64 = 4.0;
/// Part of its standard deviation by which the half gap moves at most then. A choice.
const CONVERGED_WAY: f64 = 0.1;
const PASSED_ON_WAY: f64 = 1.0;
/// Least part of a step that is tried before the search ends where it is. A choice: where an eighth of a step
/// does not lower the cost, the derivatives are those of another side of a contact. Half of it where another search
/// goes on: in the last one that let an axis without friction be taken for one with it (20261130-22).
const LEAST_PART: f64 = 0.125;
const PASSED_ON_PART: f64 = 0.5;
/// Least misfit that innovations are scaled by: they are smaller than their supposed variance where nothing is
/// left out of the model. That of the right gap is 0.2 to 0.3 there.
pub(super) const LEAST_SCALE: f64 = 0.3;
/// Part of the half gap that one step changes it at most: beyond it the contact moves out of the
/// linear range. A choice: as far as the next point of the grid.
const LARGEST_GAP_STEP_SHARE: f64 = 0.3;

/// Sums over a pass: weighted squares in all lanes, normal equations from the differences of lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Sums {
    pub(super) cost: Lanes,
    /// Entry of unknown j in lane j + 1, as the lanes that are changed.
    normal: [Lanes; N],
    right: Lanes,
}

impl Sums {
    /// Adds the innovations of a sample; only their squares without `derivatives`.
    #[inline(always)]
    pub(super) fn add(&mut self, innovation: &Innovation, derivatives: bool) {
        let (weight, e) = (1.0 / innovation.variance, &innovation.e);
        for (sum, e) in self.cost.iter_mut().zip(&e.0) {
            *sum += weight * e * e;
        }
        if !derivatives {
            return;
        }
        // lane 0 is the point, lane i + 1 the point with unknown i changed
        let (slope, point) = (e.map(|changed| changed - e[0]), e[0]);
        for (sum, slope) in self.right.iter_mut().zip(&slope.0) {
            *sum -= weight * slope * point;
        }
        for (row, of_row) in self.normal.iter_mut().zip(&slope[1..]) {
            for (sum, slope) in row.iter_mut().zip(&slope.0) {
                *sum += weight * of_row * slope;
            }
        }
    }
}

/// The best point so far: mean square of its innovations over their variance (misfit), variance of
/// its half gap, its cost, and the step from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Accepted {
    pub(super) at: Vector,
    pub(super) misfit: f64,
    pub(super) variance: f64,
    /// Covariance of the load's unknowns in the order of [`OF_LOAD`].
    pub(super) load: [[f64; 4]; 4],
    cost: f64,
    step: Vector,
    /// How much the cost over the scale falls with the whole step, as the derivatives have it.
    promise: f64,
}

/// State of the search.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Newton {
    /// Point of the present pass.
    pub(super) at: Vector,
    pub(super) accepted: Option<Accepted>,
    passes: u32,
    /// Part of the accepted point's step that is tried: 1 and halves of it.
    part: f64,
}

impl Newton {
    pub(super) fn new(at: Vector) -> Newton {
        Newton {
            at,
            accepted: None,
            passes: 0,
            part: 1.0,
        }
    }

    /// Takes the sums of a pass over `count` samples; `passed_on`: another search goes on from where this one ends.
    /// Returns whether it was the last one.
    pub(super) fn take(
        &mut self,
        sums: &Sums,
        count: f64,
        prior: &Prior,
        step: &Vector,
        passed_on: bool,
    ) -> bool {
        self.passes += 1;
        let last = self.passes >= LARGEST_NUMBER_OF_PASSES;
        let (mean, information) = (prior.mean(), prior.information());
        // cost of the point: innovations and prior; the gap has no prior
        let off: Vector =
            std::array::from_fn(|i| if i == GAP { 0.0 } else { self.at[i] - mean[i] });
        let pull: Vector = information.map(|row| row.iter().zip(off).map(|(a, x)| a * x).sum());
        let cost = sums.cost[0] + pull.iter().zip(off).map(|(a, x)| a * x).sum::<f64>();
        // worse than the best point: half the step from there
        let before = self
            .accepted
            .map_or(f64::INFINITY, |accepted| accepted.cost);
        if !cost.is_finite() || cost > before {
            let least = if passed_on {
                PASSED_ON_PART
            } else {
                LEAST_PART
            };
            return !self.halve(least) || last;
        }
        let misfit = sums.cost[0] / count;
        // scaled by its misfit, a window that the model does not explain loses weight against the prior, and the
        // variance grows
        let (moves, promise, variance, load) =
            solve_step(sums, misfit.max(LEAST_SCALE), &information, &pull, step);
        let at = self.at;
        // trust region for the gap, and physical bounds: no negative friction, gap or inertia
        let moved: Vector = std::array::from_fn(|i| {
            let most = if i == GAP {
                LARGEST_GAP_STEP_SHARE * at[GAP]
            } else {
                f64::INFINITY
            };
            (at[i] + moves[i].max(-most).min(most)).max(prior.least()[i])
        });
        self.accepted = Some(Accepted {
            at,
            misfit,
            variance,
            load,
            cost,
            step: std::array::from_fn(|i| moved[i] - at[i]),
            promise,
        });
        (self.at, self.part) = (moved, 1.0);
        // converged: the gap moves by less than its uncertainty, and the cost hardly falls
        let [way, fall] = if passed_on {
            [PASSED_ON_WAY, PASSED_ON_FALL]
        } else {
            [CONVERGED_WAY, CONVERGED_FALL]
        };
        let small =
            (moved[GAP] - at[GAP]).abs() < (way * variance.max(0.0).sqrt()).max(1e-3 * at[GAP]);
        small && before - cost < fall * misfit.max(1.0) || last
    }

    /// Halves the step from the best point. Returns whether what it promises is worth a pass.
    fn halve(&mut self, least: f64) -> bool {
        let Some(accepted) = &self.accepted else {
            return false;
        };
        self.part *= 0.5;
        let part = self.part;
        self.at = std::array::from_fn(|i| accepted.at[i] + part * accepted.step[i]);
        // along the step the cost falls as a parabola does
        part >= least && (2.0 - part) * part * accepted.promise > CONVERGED_FALL
    }
}

/// Step of the unknowns, how much the cost over the scale falls with it, and variance of the half gap.
fn solve_step(
    sums: &Sums,
    scale: f64,
    information: &[Vector; N],
    pull: &Vector,
    step: &Vector,
) -> (Vector, f64, f64, [[f64; 4]; 4]) {
    // in units of the differences, so that the unknowns are of like size; a small ridge for what
    // the window does not determine
    let mut a = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..=i {
            a[i][j] = sums.normal[i][j + 1] / scale + information[i][j] * step[i] * step[j];
        }
        a[i][i] = a[i][i] * (1.0 + 1e-9) + 1e-12;
    }
    let right: Vector = std::array::from_fn(|i| sums.right[i + 1] / scale - pull[i] * step[i]);
    // the variance is the gap's diagonal entry of the inverse
    let (l, mut unit) = (cholesky(&a, LEAST_PIVOT), [0.0; N]);
    unit[GAP] = 1.0;
    let x = cholesky_solve(&l, &right);
    // the load's part of the inverse, column by column
    let columns = OF_LOAD.map(|unknown| {
        let unit: Vector = std::array::from_fn(|i| if i == unknown { 1.0 } else { 0.0 });
        let column = cholesky_solve(&l, &unit);
        OF_LOAD.map(|i| column[i] * step[i] * step[unknown])
    });
    (
        std::array::from_fn(|i| x[i] * step[i]),
        x.iter().zip(right).map(|(x, right)| x * right).sum(),
        cholesky_solve(&l, &unit)[GAP] * step[GAP] * step[GAP],
        columns,
    )
}
