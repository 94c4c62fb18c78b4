//! The least time over a section by a primal-dual interior-point method.
//!
//! Unknown are the coefficients of the spline b(s), the square of the speed, and a slack for each
//! bound, so that the start need not keep the bounds. Since a coefficient touches three intervals,
//! the matrix has two bands on either side. The bound of the jerk is not convex in b; what comes
//! out is judged by who asked for it. (Wright, Primal-Dual Interior-Point Methods, 1997.)

use super::spline::Grid;
use lostmotion_base::linalg::solve_banded;

/// Factor by which the complementarity is to fall in a step. A choice: a faster fall leaves the
/// central path, a slower one takes more steps.
const CENTERING_FACTOR: f64 = 0.25;
/// Part of the way to the nearest bound that a step may go (fraction to the boundary). A choice:
/// nearer to 1 slacks fall to nothing at once, farther takes more steps.
const TO_BOUNDARY: f64 = 0.95;
/// Halvings of a step that leads to no speed in some interval, before the method gives up. A
/// choice: the last is 1/128 of the step, which hardly moves anything.
const STEP_HALVINGS: usize = 8;
/// Least slack at the start, as a part of the bound. A choice: smaller starts near the boundary,
/// where steps are short.
const LEAST_SLACK: f64 = 0.01;
/// Excess of a bound, as a part of it, at which the solution is good enough: the goals leave more
/// than that.
const BOUND_TOLERANCE: f64 = 1e-4;

/// What a row bounds, as an index of goals and rooms.
pub(super) const ACCELERATION: usize = 0;
pub(super) const JERK: usize = 1;

/// A joint's acceleration or jerk to one side at an end of an interval, as a part of its limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// Factors of b, b' and b'' in the middle of the interval.
    pub(super) f: [f64; 3],
    /// For jerk, which is the sum times the root of b there: the end, -1 or 1; 0 for acceleration.
    pub(super) end: f64,
}

/// Slack and dual variable of a bound, or how they change.
#[derive(Clone, Copy, Debug)]
struct Bound {
    slack: f64,
    dual: f64,
}

/// Used part of a bound, and its gradient by b, b' and b'' in the middle of the interval.
#[derive(Clone, Copy, Debug)]
struct BoundUse {
    part: f64,
    gradient: [f64; 3],
}

/// An end of an interval: b there by b, b' and b'' in the middle, and its root.
struct IntervalEnd {
    by: [f64; 3],
    root: f64,
}

/// What to solve: free are all coefficients but the first and the last two.
#[derive(Debug)]
pub(super) struct BarrierProblem<'a> {
    grid: &'a Grid,
    basis: Vec<[[f64; 3]; 3]>,
    /// Largest b in the middle and at the end of each interval.
    pub(super) caps: Vec<f64>,
    /// Rows, `per` to an interval.
    rows: Vec<Row>,
    per: usize,
    /// Parts of the limits of acceleration and jerk in each interval that the solution is to keep.
    pub(super) goals: Vec<[f64; 2]>,
    /// Of each interval's speed and rows.
    bounds: Vec<Bound>,
}

impl<'a> BarrierProblem<'a> {
    pub(super) fn new(
        grid: &'a Grid,
        caps: Vec<f64>,
        rows: Vec<Row>,
        goals: Vec<[f64; 2]>,
    ) -> BarrierProblem<'a> {
        let n = grid.len();
        let basis = (0..n).map(|interval| grid.basis(interval)).collect();
        BarrierProblem {
            grid,
            basis,
            caps,
            per: rows.len() / n.max(1),
            rows,
            goals,
            bounds: Vec::new(),
        }
    }

    /// b, b' and b'' in the middle of an interval.
    fn middle(&self, c: &[f64], interval: usize) -> [f64; 3] {
        let c = &c[interval..interval + 3];
        self.basis[interval].map(|row| row[0] * c[0] + row[1] * c[1] + row[2] * c[2])
    }

    fn rows(&self, interval: usize) -> &[Row] {
        &self.rows[interval * self.per..(interval + 1) * self.per]
    }

    /// Both ends of an interval in which b, b' and b'' in the middle are as given.
    fn ends(&self, interval: usize, x: &[f64; 3]) -> [IntervalEnd; 2] {
        [-1.0, 1.0].map(|end| {
            let half = 0.5 * end * self.grid.width(interval);
            let by = [1.0, half, 0.5 * half * half];
            let b = (by[0] * x[0] + by[1] * x[1] + by[2] * x[2]).max(f64::MIN_POSITIVE);
            IntervalEnd { by, root: b.sqrt() }
        })
    }

    /// Used part of each bound in an interval, with its gradient by b, b' and b'': first two for
    /// the speed, then one for each row.
    fn used(&self, c: &[f64], interval: usize, out: &mut Vec<BoundUse>) {
        let x = self.middle(c, interval);
        let cap = 1.0 / self.caps[interval];
        let goals = self.goals[interval].map(|goal| 1.0 / goal);
        let half = 0.5 * self.grid.width(interval);
        // The square of the speed is bounded in the middle and at the end of the interval.
        let speed = [cap, half * cap, 0.5 * half * half * cap];
        out.push(BoundUse {
            part: x[0] * cap,
            gradient: [cap, 0.0, 0.0],
        });
        out.push(BoundUse {
            part: speed[0] * x[0] + speed[1] * x[1] + speed[2] * x[2],
            gradient: speed,
        });
        let ends = self.ends(interval, &x);
        out.extend(self.rows(interval).iter().map(|row| {
            let sum = row.f[0] * x[0] + row.f[1] * x[1] + row.f[2] * x[2];
            let by = goals[if row.end == 0.0 { ACCELERATION } else { JERK }];
            if row.end == 0.0 {
                return BoundUse {
                    part: sum * by,
                    gradient: row.f.map(|f| f * by),
                };
            }
            // The jerk is the sum times sqrt(b): the product rule adds the slope of the root.
            let IntervalEnd { by: place, root } = &ends[usize::from(row.end > 0.0)];
            let slope = 0.5 * sum / root;
            BoundUse {
                part: sum * root * by,
                gradient: [0, 1, 2].map(|k| (row.f[k] * root + slope * place[k]) * by),
            }
        }));
    }

    /// The same in all intervals.
    fn all_used(&self, c: &[f64]) -> Vec<BoundUse> {
        let mut used = Vec::with_capacity(self.rows.len() + 2 * self.grid.len());
        for interval in 0..self.grid.len() {
            self.used(c, interval, &mut used);
        }
        used
    }

    /// Gradient and matrix of Newton's step.
    fn system(&self, c: &[f64], used: &[BoundUse], weight: f64) -> (Vec<f64>, Vec<[f64; 3]>) {
        let n = c.len();
        let (mut right, mut bands) = (vec![0.0; n], vec![[0.0; 3]; n]);
        let per = self.per + 2;
        for interval in 0..self.grid.len() {
            let b = self.middle(c, interval)[0];
            // The time by the midpoint rule is h / sqrt(b); its derivatives by b follow.
            let time = self.grid.width(interval) / b.sqrt();
            let mut g = [-0.5 * time / b, 0.0, 0.0];
            let mut h = [[0.75 * time / (b * b), 0.0, 0.0], [0.0; 3], [0.0; 3]];
            let these = interval * per..(interval + 1) * per;
            for (used, bound) in used[these.clone()].iter().zip(&self.bounds[these]) {
                // With slack and dual eliminated each bound adds a term of rank one.
                let d = &used.gradient;
                let over = used.part + bound.slack - 1.0;
                let (first, second) = (
                    (weight + bound.dual * over) / bound.slack,
                    bound.dual / bound.slack,
                );
                for i in 0..3 {
                    g[i] += first * d[i];
                    for k in i..3 {
                        h[i][k] += second * d[i] * d[k];
                    }
                }
            }
            gather(
                &self.basis[interval],
                &g,
                &h,
                &mut right[interval..interval + 3],
                &mut bands[interval..interval + 3],
            );
        }
        (right, bands)
    }

    /// How slacks and duals change with a step of the coefficients, and how much of both changes is
    /// taken at most.
    fn changes(&self, used: &[BoundUse], step: &[f64], weight: f64) -> (Vec<Bound>, f64, f64) {
        let (mut primal, mut dual) = (1.0_f64, 1.0_f64);
        let mut changes = Vec::with_capacity(self.bounds.len());
        let per = self.per + 2;
        for (interval, (used, bounds)) in used
            .chunks_exact(per)
            .zip(self.bounds.chunks_exact(per))
            .enumerate()
        {
            let dx = self.middle(step, interval);
            for (used, old) in used.iter().zip(bounds) {
                let d = &used.gradient;
                // Newton's changes of slack and dual: the linearised bound holds, and slack times
                // dual is the weight.
                let slack =
                    1.0 - used.part - old.slack - (d[0] * dx[0] + d[1] * dx[1] + d[2] * dx[2]);
                let change = (weight - old.dual * slack) / old.slack - old.dual;
                // Neither may reach zero.
                if slack < -TO_BOUNDARY * old.slack {
                    primal = primal.min(-TO_BOUNDARY * old.slack / slack);
                }
                if change < -TO_BOUNDARY * old.dual {
                    dual = dual.min(-TO_BOUNDARY * old.dual / change);
                }
                changes.push(Bound {
                    slack,
                    dual: change,
                });
            }
        }
        (changes, primal, dual)
    }

    /// One step; the mean product of slacks and duals after it.
    fn step(&mut self, c: &mut Vec<f64>, used: &[BoundUse], weight: f64) -> Option<f64> {
        // Schur complement in the coefficients: two bands on either side.
        let (right, mut bands) = self.system(c, used, weight);
        let mut step: Vec<f64> = right.iter().map(|g| -g).collect();
        solve_inner(&mut bands, &mut step);
        let (changes, mut primal, dual) = self.changes(used, &step, weight);
        let mut tried = c.clone();
        // The time has no meaning unless b is positive in the middle of every interval.
        for _ in 0..STEP_HALVINGS {
            tried
                .iter_mut()
                .zip(c.iter())
                .zip(&step)
                .for_each(|((tried, c), d)| *tried = c + primal * d);
            if (0..self.grid.len()).all(|interval| self.middle(&tried, interval)[0] > 0.0) {
                *c = tried;
                let mut sum = 0.0;
                for (bound, change) in self.bounds.iter_mut().zip(&changes) {
                    bound.slack += primal * change.slack;
                    bound.dual += dual * change.dual;
                    sum += bound.slack * bound.dual;
                }
                return Some(sum / self.bounds.len() as f64);
            }
            primal *= 0.5;
        }
        None
    }

    /// Lowers the time until the mean product of slacks and duals, which begins with `first`, is at
    /// most `last` and the bounds are kept within a tolerance; takes at most `steps` steps.
    pub(super) fn solve(&mut self, c: &mut Vec<f64>, first: f64, last: f64, steps: usize) {
        // The start need not keep the bounds: a raised slack is an infeasibility, which the steps
        // take away.
        let bound = |used: BoundUse| {
            let slack = (1.0 - used.part).max(LEAST_SLACK);
            Bound {
                slack,
                dual: first / slack,
            }
        };
        let mut used = self.all_used(c);
        self.bounds = used.iter().copied().map(bound).collect();
        let mut mean = first;
        for _ in 0..steps {
            let Some(reached) = self.step(c, &used, CENTERING_FACTOR * mean) else {
                return;
            };
            // At its goal the complementarity is held until the bounds are kept, too.
            mean = reached.max(last);
            used = self.all_used(c);
            // The slacks may hide an excess.
            if reached <= last && used.iter().all(|used| used.part - 1.0 <= BOUND_TOLERANCE) {
                return;
            }
        }
    }
}

/// Adds the share of one interval: gradient and upper triangle of the second derivatives by three
/// values that are sums over three coefficients.
fn gather(
    basis: &[[f64; 3]; 3],
    g: &[f64; 3],
    h: &[[f64; 3]; 3],
    right: &mut [f64],
    bands: &mut [[f64; 3]],
) {
    let full = |i: usize, k: usize| if i <= k { h[i][k] } else { h[k][i] };
    // Chain rule through the basis B: the gradient B' g, and the matrix B' H B.
    let mut product = [[0.0; 3]; 3];
    for (i, row) in product.iter_mut().enumerate() {
        for (q, value) in row.iter_mut().enumerate() {
            *value = full(i, 0) * basis[0][q] + full(i, 1) * basis[1][q] + full(i, 2) * basis[2][q];
        }
    }
    for p in 0..3 {
        right[p] += g[0] * basis[0][p] + g[1] * basis[1][p] + g[2] * basis[2][p];
        for q in p..3 {
            bands[p][q - p] += basis[0][p] * product[0][q]
                + basis[1][p] * product[1][q]
                + basis[2][p] * product[2][q];
        }
    }
}

/// Solves for all unknowns but the first and the last two, which become 0.
fn solve_inner(bands: &mut [[f64; 3]], x: &mut [f64]) {
    let n = bands.len();
    // What is given becomes a row of identity; the rows before lose their couplings to the last
    // two.
    for fixed in [0, 1, n - 2, n - 1] {
        x[fixed] = 0.0;
        bands[fixed] = [1.0, 0.0, 0.0];
    }
    bands[n - 4][2] = 0.0;
    bands[n - 3][1] = 0.0;
    bands[n - 3][2] = 0.0;
    solve_banded(bands, x.as_chunks_mut::<1>().0);
}
