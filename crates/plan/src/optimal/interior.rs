//! A primal-dual interior point method for the least time over beta = (d sigma / dt)^2.
//!
//! Unknown are the coefficients x of beta as a quadratic spline over equal intervals of the nominal
//! time sigma. The joints' limits of velocity and acceleration are linear in x. That of jerk,
//! divided by sqrt(beta), is |L(x)| <= beta^(-1/2): the right side is convex, so its tangent at the
//! last iterate lies below it, what keeps the tangent keeps the limit, and every iterate is
//! feasible. Each step solves one system with five diagonals.

use super::banded::Banded;
use super::problem::{Local, MIDDLE, Problem, follow, hold};
use lostmotion_base::vec::dot;

/// Part of the way to the nearest limit that a step may go (fraction to the boundary). A choice:
/// nearer to 1 slacks fall to nothing at once, farther takes more steps.
const TO_BOUNDARY: f64 = 0.99;
/// Bounds of the factor by which a step lowers the barrier. A choice: a lower factor falls faster
/// and risks short steps.
const CENTERING: [f64; 2] = [0.08, 0.6];
/// Least slack, as a part of its limit, of a limit that the start does not keep. A choice: smaller
/// starts near the boundary, where steps are short, larger farther from the true slack.
const LEAST_SLACK: f64 = 0.03;

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Goal {
    /// Duality gap as a part of the time.
    pub(super) gap: f64,
    /// Gap to begin with: 1 far from the least time, less near it.
    pub(super) first_gap: f64,
    pub(super) max_steps: usize,
}

/// Slacks and multipliers of a limit to both sides: slack up, slack down, multiplier up, multiplier
/// down.
type Pair = [f64; 4];

/// Working memory, kept between windows.
#[derive(Clone, Debug, Default)]
pub(super) struct Interior {
    matrix: Banded,
    dx: Vec<f64>,
    pairs: Vec<Pair>,
    changes: Vec<Pair>,
    ceilings: Vec<[f64; 2]>,
    ceiling_changes: Vec<[f64; 2]>,
}

/// Weight of each coefficient in the time: the integral of its basis function, in intervals.
fn weight(index: usize, intervals: usize) -> f64 {
    match index.min(intervals + 1 - index) {
        0 => 1.0 / 6.0,
        1 => 5.0 / 6.0,
        _ => 1.0,
    }
}

impl Interior {
    /// Lowers the time from a start `x` (all positive). A start that keeps all limits leads to
    /// results that do. Returns the duality gap as a part of the time, for the limits linearised at
    /// the last iterate; not a number where numbers went out of bounds.
    pub(super) fn solve(&mut self, problem: &Problem, x: &mut [f64], goal: &Goal) -> f64 {
        let count = problem.rows.len() * 4 + problem.inverse_ceilings.len();
        let time = |x: &[f64]| {
            let n = problem.inverse_ceilings.len();
            problem.step_s
                * x.iter()
                    .enumerate()
                    .map(|(i, x)| weight(i, n) / x.sqrt())
                    .sum::<f64>()
        };
        // The barrier that belongs to the duality gap which the start is taken to have.
        let mut mu = goal.first_gap * time(x) / count as f64;
        self.start(problem, x, mu);
        let mut gap = f64::INFINITY;
        for _ in 0..goal.max_steps {
            // Newton's step with slacks and multipliers eliminated.
            self.assemble(problem, x, mu);
            self.matrix.solve(&mut self.dx);
            follow(problem.ends, &mut self.dx);
            let [primal, dual] = self.lengths(problem, x, mu);
            let sum = self.apply(problem, x, [primal, dual]);
            gap = sum / time(x);
            // After a short step the linearised limits are not met yet, whatever the gap.
            if gap <= goal.gap && primal > 0.5 {
                break;
            }
            // The more of the step was taken, the more the barrier falls.
            let missed = 1.0 - primal.min(dual);
            mu = (missed * missed).clamp(CENTERING[0], CENTERING[1]) * sum / count as f64;
        }
        gap
    }

    fn start(&mut self, problem: &Problem, x: &[f64], mu: f64) {
        self.pairs.clear();
        self.ceilings.clear();
        for (interval, inverse) in problem.inverse_ceilings.iter().enumerate() {
            let local = Local::at(x, interval);
            let slack = (1.0 - inverse * local.beta).max(LEAST_SLACK);
            self.ceilings.push([slack, mu / slack]);
            for rows in &problem.rows[interval * problem.joints..(interval + 1) * problem.joints] {
                for (kind, row) in rows.iter().enumerate() {
                    let (right, _) = local.right(kind);
                    let left = dot(*row, local.x);
                    let [up, down] =
                        [right - left, right + left].map(|slack| slack.max(LEAST_SLACK));
                    self.pairs.push([up, down, mu / up, mu / down]);
                }
            }
        }
        self.changes.resize(self.pairs.len(), [0.0; 4]);
        self.ceiling_changes.resize(self.ceilings.len(), [0.0; 2]);
        self.dx.resize(x.len(), 0.0);
    }

    /// The matrix and the right side of the step.
    fn assemble(&mut self, problem: &Problem, x: &[f64], mu: f64) {
        let n = problem.inverse_ceilings.len();
        self.matrix.reset(x.len());
        // Gradient and Hessian of the time, the sum of weight / sqrt(x), are diagonal.
        for (i, (dx, x)) in self.dx.iter_mut().zip(x).enumerate() {
            let slope = problem.step_s * weight(i, n) * 0.5 / (*x * x.sqrt());
            *dx = slope;
            self.matrix.add_diagonal(i, 1.5 * slope / *x);
        }
        let mut pairs = self.pairs.iter();
        for (interval, (inverse, [slack, multiplier])) in problem
            .inverse_ceilings
            .iter()
            .zip(&self.ceilings)
            .enumerate()
        {
            let local = Local::at(x, interval);
            let per = 1.0 / slack;
            let residual = 1.0 - inverse * local.beta - slack;
            // Sums over all limits of this interval: w G G', w G, with G = slope of beta; and rows
            // apart.
            let mut middle = [
                inverse * inverse * multiplier * per,
                -inverse * (mu - multiplier * residual) * per,
            ];
            let mut block = [0.0; 6];
            let mut push = [0.0; 3];
            for rows in &problem.rows[interval * problem.joints..(interval + 1) * problem.joints] {
                for (kind, row) in rows.iter().enumerate() {
                    let Some([up, down, more, less]) = pairs.next() else {
                        return;
                    };
                    let (right, slope) = local.right(kind);
                    let left = dot(*row, local.x);
                    let (per_up, per_down) = (1.0 / up, 1.0 / down);
                    // Multiplier by slack is the weight of a limit in the Schur complement.
                    let [w, u] = [more * per_up, less * per_down];
                    let pull_up = mu * per_up - w * (right - left - up);
                    let pull_down = mu * per_down - u * (right + left - down);
                    let sum = w + u;
                    let cross = (u - w) * slope;
                    middle[0] += sum * slope * slope;
                    middle[1] += slope * (pull_up + pull_down);
                    let pull = pull_down - pull_up;
                    // sum l l' + cross (l e' + e l'), by rows.
                    let [a, b, c] = *row;
                    let half = [cross * MIDDLE[0], cross * MIDDLE[1]];
                    block[0] += a * (sum * a + 2.0 * half[0]);
                    block[1] += b * (sum * a + half[0]) + half[1] * a;
                    block[2] += b * (sum * b + 2.0 * half[1]);
                    block[3] += c * (sum * a + half[0]) + half[0] * a;
                    block[4] += c * (sum * b + half[1]) + half[0] * b;
                    block[5] += c * (sum * c + 2.0 * half[0]);
                    push[0] += pull * a;
                    push[1] += pull * b;
                    push[2] += pull * c;
                }
            }
            // The slope of beta is the same for all limits of the interval, so that its terms are
            // added once.
            let [e, f] = [MIDDLE[0], MIDDLE[1]];
            for (entry, product) in block
                .iter_mut()
                .zip([e * e, e * f, f * f, e * e, e * f, e * e])
            {
                *entry += middle[0] * product;
            }
            self.matrix.add_block(interval, &block);
            for (k, push) in push.iter().enumerate() {
                self.dx[interval + k] += push + middle[1] * MIDDLE[k];
            }
        }
        hold(problem.ends, &mut self.matrix, &mut self.dx);
    }

    /// How far the step may go, for x with the slacks and for the multipliers.
    fn lengths(&mut self, problem: &Problem, x: &[f64], mu: f64) -> [f64; 2] {
        // The largest rates of falling to zero.
        let mut rates = [TO_BOUNDARY; 2];
        // The coefficients have to stay positive.
        for (x, dx) in x.iter().zip(&self.dx) {
            rates[0] = rates[0].max(-dx / x);
        }
        let mut index = 0;
        for (interval, inverse) in problem.inverse_ceilings.iter().enumerate() {
            let local = Local::at(x, interval);
            let dx = [
                self.dx[interval],
                self.dx[interval + 1],
                self.dx[interval + 2],
            ];
            let dbeta = dot(MIDDLE, dx);
            let [slack, multiplier] = self.ceilings[interval];
            let change = 1.0 - inverse * (local.beta + dbeta) - slack;
            let dual = (mu - multiplier * (slack + change)) / slack;
            self.ceiling_changes[interval] = [change, dual];
            rates = [
                rates[0].max(-change / slack),
                rates[1].max(-dual / multiplier),
            ];
            for rows in &problem.rows[interval * problem.joints..(interval + 1) * problem.joints] {
                for (kind, row) in rows.iter().enumerate() {
                    let [up, down, more, less] = self.pairs[index];
                    let (right, slope) = local.right(kind);
                    // The right side of the jerk's limit along its tangent.
                    let right = right + slope * dbeta;
                    let left = dot(*row, local.x) + dot(*row, dx);
                    let (dup, ddown) = (right - left - up, right + left - down);
                    let (per_up, per_down) = (1.0 / up, 1.0 / down);
                    let dmore = mu * per_up - more * (up + dup) * per_up;
                    let dless = mu * per_down - less * (down + ddown) * per_down;
                    self.changes[index] = [dup, ddown, dmore, dless];
                    rates[0] = rates[0].max(-dup * per_up).max(-ddown * per_down);
                    rates[1] = rates[1].max(-dmore / more).max(-dless / less);
                    index += 1;
                }
            }
        }
        rates.map(|rate| (TO_BOUNDARY / rate).min(1.0))
    }

    /// Goes the step; returns the sum of slacks times multipliers.
    fn apply(&mut self, problem: &Problem, x: &mut [f64], [primal, dual]: [f64; 2]) -> f64 {
        for (x, dx) in x.iter_mut().zip(&self.dx) {
            *x += primal * dx;
        }
        let mut sum = 0.0;
        let mut index = 0;
        for (interval, inverse) in problem.inverse_ceilings.iter().enumerate() {
            let local = Local::at(x, interval);
            let [slack, multiplier] = &mut self.ceilings[interval];
            let change = self.ceiling_changes[interval];
            *slack = kept(1.0 - inverse * local.beta, *slack + primal * change[0]);
            *multiplier += dual * change[1];
            sum += *slack * *multiplier;
            for rows in &problem.rows[interval * problem.joints..(interval + 1) * problem.joints] {
                for (kind, row) in rows.iter().enumerate() {
                    let (right, _) = local.right(kind);
                    let left = dot(*row, local.x);
                    let pair = &mut self.pairs[index];
                    let change = &self.changes[index];
                    pair[0] = kept(right - left, pair[0] + primal * change[0]);
                    pair[1] = kept(right + left, pair[1] + primal * change[1]);
                    pair[2] += dual * change[2];
                    pair[3] += dual * change[3];
                    sum += pair[0] * pair[2] + pair[1] * pair[3];
                    index += 1;
                }
            }
        }
        sum
    }
}

/// The true slack where the limit is kept by more than the step said, which convexity promises once
/// it is kept at all.
fn kept(real: f64, predicted: f64) -> f64 {
    if real >= predicted { real } else { predicted }
}
