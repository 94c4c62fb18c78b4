//! Gauss-Newton over the unknowns of a window, pass by pass.
//!
//! ```text
//! minimise  sum e^2/S/max(0.3, misfit) + (p - p0)' A (p - p0)          e: innovations, S: their variance, A: prior information
//! step      (E' E/scale + A) dp = -(E' e/scale + A (p - p0))         E: differences of e from lane to lane, scale = max(0.3, misfit)
//! ```
//! A pass runs the eight lanes over the window: the point itself, and the point with one unknown
//! changed, so that derivatives are finite differences. The next one looks along the step: all of it, a half, a
//! quarter and an eighth, side by side in four lanes. The largest part that does not increase the cost is the next
//! point, as long as what is left of the step promises to lower the cost.
//! The half gap's entry of the inverse normal matrix at the end is its variance (Cramer-Rao).

use super::lanes::{Innovation, Lanes};
use super::prior::{GAP, N, OF_LOAD, Prior, Vector};
use crate::readings::LEAST_PIVOT;
use lostmotion_base::linalg::{cholesky, cholesky_solve};
use serde::{Deserialize, Serialize};

/// Bound of the passes with derivatives; a search usually ends by `CONVERGED_FALL`. Raised from 6 when
/// derivatives were taken closer together (record 63 of the decisions).
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

/// Parts of a step that are tried side by side: each half of the one before.
pub(super) const PARTS: usize = 4;

/// The best point so far: mean square of its innovations over their variance (misfit), variance of
/// its half gap, its cost, and the step from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Accepted {
    pub(super) at: Vector,
    pub(super) misfit: f64,
    pub(super) variance: f64,
    /// Covariance of the load's unknowns in the order of [`OF_LOAD`].
    pub(super) load: [[f64; 4]; 4],
    pub(super) cost: f64,
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
}

impl Newton {
    pub(super) fn new(at: Vector) -> Newton {
        Newton {
            at,
            accepted: None,
            passes: 0,
        }
    }

    /// Takes the sums of a pass with derivatives over `count` samples; `passed_on`: another search goes on from
    /// where this one ends. Returns whether it was the last one.
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
        let pull = pull(&self.at, &mean, &information);
        let cost = sums.cost[0] + weighed(&pull, &self.at, &mean);
        // A point behind the first one was no worse along the step, where the start of the load is found with the
        // numbers of the step's end. One that is worse with its own ends the search.
        let before = self
            .accepted
            .map_or(f64::INFINITY, |accepted| accepted.cost);
        if !cost.is_finite() || cost > before {
            return true;
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
        self.at = moved;
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

    /// Points along the step of the best point: its end first, then halves of it.
    pub(super) fn along(&self) -> [Vector; PARTS] {
        let mut points = [self.at; PARTS];
        if let Some(accepted) = &self.accepted {
            let mut part = 1.0;
            for point in &mut points[1..] {
                part *= 0.5;
                *point = std::array::from_fn(|i| accepted.at[i] + part * accepted.step[i]);
            }
        }
        points
    }

    /// Takes the innovations' costs of [`Newton::along`], lane by lane, and goes on to the first point that is no worse
    /// than the best one. Returns whether there is none that is worth a pass; `passed_on`: as for [`Newton::take`].
    pub(super) fn choose(&mut self, costs: &Lanes, prior: &Prior, passed_on: bool) -> bool {
        let Some(accepted) = self.accepted else {
            return true;
        };
        let least = if passed_on {
            PASSED_ON_PART
        } else {
            LEAST_PART
        };
        let (mean, information) = (prior.mean(), prior.information());
        let mut part = 1.0;
        for (point, innovations) in self.along().into_iter().zip(costs.0) {
            // along the step the cost falls as a parabola does
            let promises = (2.0 - part) * part * accepted.promise > CONVERGED_FALL;
            if part < 1.0 && (part < least || !promises) {
                return true;
            }
            let cost = innovations + weighed(&pull(&point, &mean, &information), &point, &mean);
            if cost.is_finite() && cost <= accepted.cost {
                self.at = point;
                return false;
            }
            part *= 0.5;
        }
        true
    }
}

/// How far a point is from the mean, but for the gap, which has no prior.
fn off(at: &Vector, mean: &Vector) -> Vector {
    std::array::from_fn(|i| if i == GAP { 0.0 } else { at[i] - mean[i] })
}

/// What the prior pulls a point with.
fn pull(at: &Vector, mean: &Vector, information: &[Vector; N]) -> Vector {
    let off = off(at, mean);
    information.map(|row| row.iter().zip(off).map(|(a, x)| a * x).sum())
}

/// The cost of that.
fn weighed(pull: &Vector, at: &Vector, mean: &Vector) -> f64 {
    let off = off(at, mean);
    pull.iter().zip(off).map(|(a, x)| a * x).sum()
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
