//! The least time over a section by a primal-dual interior-point method.
//!
//! Unknown are the coefficients of the spline b(s), the square of the speed, and a slack for each
//! bound, so that the start need not keep the bounds. Since a coefficient touches three intervals,
//! the matrix has two bands on either side. The bound of the jerk is not convex in b; what comes
//! out is judged by who asked for it. (Wright, Primal-Dual Interior-Point Methods, 1997.)
//!
//! Eight intervals are worked on side by side, one in each lane.

use super::spline::Grid;
use crate::wide::{LANES, Lanes, Part, dot, parts, scaled};
use lostmotion_base::linalg::solve_banded;
use lostmotion_base::{Number, Wide};
use pulp::{Arch, Simd, WithSimd};

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
    slack: Lanes,
    dual: Lanes,
}

/// Used part of a bound, and its gradient by b, b' and b'' in the middle of the interval.
#[derive(Clone, Copy, Debug)]
struct BoundUse {
    part: Lanes,
    gradient: [Lanes; 3],
}

/// What does not change in a solution of the intervals of a block.
#[derive(Clone, Debug)]
struct Block {
    basis: [[Lanes; 3]; 3],
    /// Widths, and half of them.
    width: Lanes,
    half: Lanes,
    /// How b, b' and b'' in the middle count for the speed there and at the end, over its cap.
    speed: [Lanes; 3],
    /// The inverses of the goals.
    goals: [Lanes; 2],
}

/// Both ends of an interval: b there by b'' in the middle, by b' there, and its root.
struct IntervalEnds<S: Simd> {
    by_second: Wide<S>,
    by_slope: [Wide<S>; 2],
    roots: [Wide<S>; 2],
}

/// What to solve: free are all coefficients but the first and the last two.
#[derive(Debug)]
pub(super) struct BarrierProblem<'a> {
    grid: &'a Grid,
    /// Largest b in the middle and at the end of each interval.
    pub(super) caps: Vec<f64>,
    /// Parts of the limits of acceleration and jerk in each interval that the solution is to keep.
    pub(super) goals: Vec<[f64; 2]>,
    /// Ends of the rows of an interval, alike in all of them.
    ends: Vec<f64>,
    /// Factors of the rows, block by block.
    rows: Vec<[Lanes; 3]>,
    blocks: Vec<Block>,
    /// Of each block's speed and rows.
    bounds: Vec<Bound>,
    used: Vec<BoundUse>,
    changes: Vec<Bound>,
}

/// No bound: where a block has no interval in a lane, no comparison holds there.
const NO_BOUND: Bound = Bound {
    slack: [f64::NAN; LANES],
    dual: [f64::NAN; LANES],
};

impl<'a> BarrierProblem<'a> {
    /// Rows interval by interval, of the same kinds in each.
    pub(super) fn new(
        grid: &'a Grid,
        caps: Vec<f64>,
        rows: &[Row],
        goals: Vec<[f64; 2]>,
    ) -> BarrierProblem<'a> {
        let n = grid.len();
        let per = rows.len() / n.max(1);
        let blocks = n.div_ceil(LANES);
        let mut by_block = vec![[[0.0; LANES]; 3]; blocks * per];
        for (interval, rows) in rows.chunks_exact(per.max(1)).enumerate() {
            let (block, lane) = (interval / LANES, interval % LANES);
            for (row, lanes) in rows.iter().zip(&mut by_block[block * per..]) {
                for (f, lanes) in row.f.iter().zip(lanes) {
                    lanes[lane] = *f;
                }
            }
        }
        BarrierProblem {
            grid,
            caps,
            goals,
            ends: rows[..per].iter().map(|row| row.end).collect(),
            rows: by_block,
            blocks: Vec::with_capacity(blocks),
            bounds: Vec::new(),
            used: Vec::new(),
            changes: Vec::new(),
        }
    }

    /// Bounds of an interval.
    fn per(&self) -> usize {
        self.ends.len() + 2
    }

    /// What a block has while caps and goals stay.
    fn block(&self, block: usize) -> Block {
        let mut out = Block {
            // In a lane without an interval b is the coefficient beyond all, which is 1.
            basis: [[0.0, 0.0, 1.0], [0.0; 3], [0.0; 3]].map(|row| row.map(|value| [value; LANES])),
            width: [1.0; LANES],
            half: [0.5; LANES],
            speed: [[0.0; LANES]; 3],
            goals: [[1.0; LANES]; 2],
        };
        let first = block * LANES;
        for lane in 0..LANES.min(self.grid.len() - first) {
            let interval = first + lane;
            let basis = self.grid.basis(interval);
            for (lanes, row) in out.basis.iter_mut().zip(basis) {
                for (lanes, value) in lanes.iter_mut().zip(row) {
                    lanes[lane] = value;
                }
            }
            let width = self.grid.width(interval);
            let (half, cap) = (0.5 * width, 1.0 / self.caps[interval]);
            (out.width[lane], out.half[lane]) = (width, half);
            let speed = [cap, half * cap, 0.5 * half * half * cap];
            for (lanes, value) in out.speed.iter_mut().zip(speed) {
                lanes[lane] = value;
            }
            for (lanes, goal) in out.goals.iter_mut().zip(self.goals[interval]) {
                lanes[lane] = 1.0 / goal;
            }
        }
        out
    }

    /// Lowers the time until the mean product of slacks and duals, which begins with `first`, is at
    /// most `last` and the bounds are kept within a tolerance; takes at most `steps` steps.
    pub(super) fn solve(&mut self, c: &mut Vec<f64>, first: f64, last: f64, steps: usize) {
        let (n, blocks) = (self.grid.len(), self.grid.len().div_ceil(LANES));
        self.blocks = (0..blocks).map(|block| self.block(block)).collect();
        c.resize(blocks * LANES + 2, 1.0);
        Arch::new().dispatch(Solution {
            problem: self,
            c,
            first,
            last,
            steps,
        });
        c.truncate(n + 2);
    }

    /// Used part of each bound, with its gradient by b, b' and b'': first two for the speed, then one for
    /// each row.
    #[inline(always)]
    fn use_all<S: Simd>(&mut self, simd: S, c: &[f64]) {
        let per = self.per();
        let rows = self.rows.chunks_exact(self.ends.len().max(1));
        let blocks = self.blocks.iter().zip(rows);
        for (k, ((block, rows), out)) in blocks.zip(self.used.chunks_exact_mut(per)).enumerate() {
            let (speeds, out) = out.split_at_mut(2);
            for at in parts(simd) {
                let x = middle(at, block, &c[k * LANES..]);
                // The square of the speed is bounded in the middle and at the end of the interval.
                let speed = at.get_three(&block.speed);
                at.put(x[0] * speed[0], &mut speeds[0].part);
                at.put(speed[0], &mut speeds[0].gradient[0]);
                at.put(dot(speed, x), &mut speeds[1].part);
                at.put_three(speed, &mut speeds[1].gradient);
                let ends = IntervalEnds::new(at, block, x);
                let goals = [at.get(&block.goals[0]), at.get(&block.goals[1])];
                for ((row, end), out) in rows.iter().zip(&self.ends).zip(&mut *out) {
                    let f = at.get_three(row);
                    let sum = dot(f, x);
                    if *end == 0.0 {
                        let by = goals[ACCELERATION];
                        at.put(sum * by, &mut out.part);
                        at.put_three(scaled(f, by), &mut out.gradient);
                        continue;
                    }
                    // The jerk is the sum times sqrt(b): the product rule adds the slope of the root.
                    let (side, by) = (usize::from(*end > 0.0), goals[JERK]);
                    let root = ends.roots[side];
                    let slope = at.all(0.5) * sum / root;
                    at.put(sum * root * by, &mut out.part);
                    let gradient = [
                        f[0] * root + slope,
                        f[1] * root + slope * ends.by_slope[side],
                        f[2] * root + slope * ends.by_second,
                    ];
                    at.put_three(scaled(gradient, by), &mut out.gradient);
                }
            }
        }
    }

    /// Gradient and matrix of Newton's step.
    #[inline(always)]
    fn system<S: Simd>(&self, simd: S, c: &[f64], weight: f64) -> (Vec<f64>, Vec<[f64; 3]>) {
        let n = self.grid.len();
        let (mut right, mut bands) = (vec![0.0; n + 2], vec![[0.0; 3]; n + 2]);
        let per = self.per();
        let these = self
            .used
            .chunks_exact(per)
            .zip(self.bounds.chunks_exact(per));
        for (k, (block, (used, bounds))) in self.blocks.iter().zip(these).enumerate() {
            let mut share = BlockShare::default();
            for at in parts(simd) {
                share.put(at, block, &c[k * LANES..], used.iter().zip(bounds), weight);
            }
            let first = k * LANES;
            for lane in 0..LANES.min(n - first) {
                let interval = first + lane;
                let right = &mut right[interval..interval + 3];
                for (right, lanes) in right.iter_mut().zip(&share.right) {
                    *right += lanes[lane];
                }
                let bands = &mut bands[interval..interval + 3];
                for (p, (row, lanes)) in bands.iter_mut().zip(&share.rows).enumerate() {
                    for (entry, lanes) in row[..3 - p].iter_mut().zip(lanes) {
                        *entry += lanes[lane];
                    }
                }
            }
        }
        (right, bands)
    }

    /// How slacks and duals change with a step of the coefficients; returns how much of both changes is
    /// taken at most.
    #[inline(always)]
    fn change_all<S: Simd>(&mut self, simd: S, step: &[f64], weight: f64) -> [f64; 2] {
        let per = self.per();
        let one = Wide::all(simd, 1.0);
        let (weight, nearest) = (Wide::all(simd, weight), Wide::all(simd, -TO_BOUNDARY));
        let (mut primal, mut dual) = (one, one);
        let these = self
            .used
            .chunks_exact(per)
            .zip(self.bounds.chunks_exact(per));
        let blocks = self.blocks.iter().zip(these);
        for (k, ((block, (used, bounds)), out)) in
            blocks.zip(self.changes.chunks_exact_mut(per)).enumerate()
        {
            for at in parts(simd) {
                let dx = middle(at, block, &step[k * LANES..]);
                for ((used, old), out) in used.iter().zip(bounds).zip(&mut *out) {
                    let d = at.get_three(&used.gradient);
                    let (old_slack, old_dual) = (at.get(&old.slack), at.get(&old.dual));
                    // Newton's changes of slack and dual: the linearised bound holds, and slack times
                    // dual is the weight.
                    let slack = one - at.get(&used.part) - old_slack - dot(d, dx);
                    let change = (weight - old_dual * slack) / old_slack - old_dual;
                    // Neither may reach zero.
                    let least = nearest * old_slack;
                    let kept = Wide::choose(slack.less(least), least / slack, one);
                    primal = kept.lesser(primal);
                    let least = nearest * old_dual;
                    let kept = Wide::choose(change.less(least), least / change, one);
                    dual = kept.lesser(dual);
                    at.put(slack, &mut out.slack);
                    at.put(change, &mut out.dual);
                }
            }
        }
        [primal.least(), dual.least()]
    }

    /// Whether b is positive in the middle of every interval.
    #[inline(always)]
    fn advances<S: Simd>(&self, simd: S, c: &[f64]) -> bool {
        let (one, least_b) = (Wide::all(simd, 1.0), Wide::all(simd, f64::from_bits(1)));
        let mut all = one;
        for (k, block) in self.blocks.iter().enumerate() {
            for at in parts(simd) {
                let b = middle(at, block, &c[k * LANES..])[0];
                all = all.lesser(one.flag(least_b.at_most(b)));
            }
        }
        all.least() > 0.0
    }

    /// Takes changes of slacks and duals; returns the mean of their products.
    #[inline(always)]
    fn take<S: Simd>(&mut self, simd: S, [primal, dual]: [f64; 2]) -> f64 {
        let (primal, dual) = (Wide::all(simd, primal), Wide::all(simd, dual));
        let (n, per) = (self.grid.len(), self.per());
        let mut products = vec![[0.0; LANES]; per];
        let mut sum = 0.0;
        let these = self.bounds.chunks_exact_mut(per);
        for (k, (bounds, changes)) in these.zip(self.changes.chunks_exact(per)).enumerate() {
            for ((bound, change), product) in bounds.iter_mut().zip(changes).zip(&mut products) {
                for at in parts(simd) {
                    let slack = at.get(&bound.slack) + primal * at.get(&change.slack);
                    let dual = at.get(&bound.dual) + dual * at.get(&change.dual);
                    at.put(slack, &mut bound.slack);
                    at.put(dual, &mut bound.dual);
                    at.put(slack * dual, product);
                }
            }
            for lane in 0..LANES.min(n - k * LANES) {
                for product in &products {
                    sum += product[lane];
                }
            }
        }
        sum / (n * per) as f64
    }

    /// Whether all bounds are kept within the tolerance.
    #[inline(always)]
    fn are_kept<S: Simd>(&self, simd: S) -> bool {
        let (one, most) = (Wide::all(simd, 1.0), Wide::all(simd, BOUND_TOLERANCE));
        let mut all = one;
        for used in &self.used {
            for at in parts(simd) {
                all = all.lesser(one.flag((at.get(&used.part) - one).at_most(most)));
            }
        }
        all.least() > 0.0
    }

    /// One step; the mean product of slacks and duals after it.
    #[inline(always)]
    fn step<S: Simd>(&mut self, simd: S, c: &mut Vec<f64>, weight: f64) -> Option<f64> {
        // Schur complement in the coefficients: two bands on either side.
        let (right, mut bands) = self.system(simd, c, weight);
        let mut step: Vec<f64> = right.iter().map(|g| -g).collect();
        solve_inner(&mut bands, &mut step);
        step.resize(c.len(), 0.0);
        let [mut primal, dual] = self.change_all(simd, &step, weight);
        let mut tried = c.clone();
        // The time has no meaning unless b is positive in the middle of every interval.
        for _ in 0..STEP_HALVINGS {
            tried
                .iter_mut()
                .zip(c.iter())
                .zip(&step)
                .for_each(|((tried, c), d)| *tried = c + primal * d);
            if self.advances(simd, &tried) {
                *c = tried;
                return Some(self.take(simd, [primal, dual]));
            }
            primal *= 0.5;
        }
        None
    }

    /// Steps until the mean is reached and the bounds are kept.
    #[inline(always)]
    fn go<S: Simd>(&mut self, simd: S, c: &mut Vec<f64>, first: f64, last: f64, steps: usize) {
        let (n, per) = (self.grid.len(), self.per());
        let nothing = BoundUse {
            part: [0.0; LANES],
            gradient: [[0.0; LANES]; 3],
        };
        self.used.clear();
        self.used.resize(self.blocks.len() * per, nothing);
        self.use_all(simd, c);
        // The start need not keep the bounds: a raised slack is an infeasibility, which the steps
        // take away.
        self.bounds.clear();
        self.bounds.resize(self.used.len(), NO_BOUND);
        self.changes.clear();
        self.changes.resize(self.used.len(), NO_BOUND);
        for (k, (bound, used)) in self.bounds.iter_mut().zip(&self.used).enumerate() {
            for lane in 0..LANES.min(n - k / per * LANES) {
                let slack = (1.0 - used.part[lane]).max(LEAST_SLACK);
                (bound.slack[lane], bound.dual[lane]) = (slack, first / slack);
            }
        }
        let mut mean = first;
        for _ in 0..steps {
            let Some(reached) = self.step(simd, c, CENTERING_FACTOR * mean) else {
                return;
            };
            // At its goal the complementarity is held until the bounds are kept, too.
            mean = reached.max(last);
            self.use_all(simd, c);
            // The slacks may hide an excess.
            if reached <= last && self.are_kept(simd) {
                return;
            }
        }
    }
}

/// A solution, in vectors as wide as the processor has them.
struct Solution<'a, 'b> {
    problem: &'a mut BarrierProblem<'b>,
    c: &'a mut Vec<f64>,
    first: f64,
    last: f64,
    steps: usize,
}

impl WithSimd for Solution<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.problem
            .go(simd, self.c, self.first, self.last, self.steps);
    }
}

/// b, b' and b'' in the middle of the intervals of a block, given the coefficients from its first one on.
#[inline(always)]
fn middle<S: Simd>(at: Part<S>, block: &Block, c: &[f64]) -> [Wide<S>; 3] {
    let c = at.get_following(c);
    let [b, slope, second] = &block.basis;
    [
        dot(at.get_three(b), c),
        dot(at.get_three(slope), c),
        dot(at.get_three(second), c),
    ]
}

impl<S: Simd> IntervalEnds<S> {
    /// Of intervals in which b, b' and b'' in the middle are as given.
    #[inline(always)]
    fn new(at: Part<S>, block: &Block, x: [Wide<S>; 3]) -> IntervalEnds<S> {
        let half = at.get(&block.half);
        let by_slope = [at.all(0.0) - half, half];
        let by_second = at.all(0.5) * half * half;
        let least = at.all(f64::MIN_POSITIVE);
        let left = x[0] + by_slope[0] * x[1] + by_second * x[2];
        let right = x[0] + by_slope[1] * x[1] + by_second * x[2];
        IntervalEnds {
            by_second,
            by_slope,
            roots: [left.larger(least).sqrt(), right.larger(least).sqrt()],
        }
    }
}

/// The shares of a block's intervals in gradient and upper triangle of the second derivatives.
#[derive(Default)]
struct BlockShare {
    right: [Lanes; 3],
    /// From the diagonal on.
    rows: [[Lanes; 3]; 3],
}

impl BlockShare {
    /// Some of the lanes, given the used parts of their bounds.
    #[inline(always)]
    fn put<'a, S: Simd>(
        &mut self,
        at: Part<S>,
        block: &Block,
        c: &[f64],
        bounds: impl Iterator<Item = (&'a BoundUse, &'a Bound)>,
        weight: f64,
    ) {
        let (weight, zero, one) = (at.all(weight), at.all(0.0), at.all(1.0));
        let b = middle(at, block, c)[0];
        // The time by the midpoint rule is h / sqrt(b); its derivatives by b follow.
        let time = at.get(&block.width) / b.sqrt();
        let mut g = [at.all(-0.5) * time / b, zero, zero];
        // By pairs: 00 01 02 11 12 22.
        let mut h = [zero; 6];
        h[0] = at.all(0.75) * time / (b * b);
        for (used, bound) in bounds {
            // With slack and dual eliminated each bound adds a term of rank one.
            let d = at.get_three(&used.gradient);
            let (slack, dual) = (at.get(&bound.slack), at.get(&bound.dual));
            let over = at.get(&used.part) + slack - one;
            let (first, second) = ((weight + dual * over) / slack, dual / slack);
            g = [
                g[0] + first * d[0],
                g[1] + first * d[1],
                g[2] + first * d[2],
            ];
            let bent = scaled(d, second);
            h = [
                h[0] + bent[0] * d[0],
                h[1] + bent[0] * d[1],
                h[2] + bent[0] * d[2],
                h[3] + bent[1] * d[1],
                h[4] + bent[1] * d[2],
                h[5] + bent[2] * d[2],
            ];
        }
        // Chain rule through the basis B: the gradient B' g, and the matrix B' H B.
        let h = [[h[0], h[1], h[2]], [h[1], h[3], h[4]], [h[2], h[4], h[5]]];
        for p in 0..3 {
            at.put(dot(g, column(at, block, p)), &mut self.right[p]);
        }
        for q in 0..3 {
            let by = column(at, block, q);
            let product = [dot(h[0], by), dot(h[1], by), dot(h[2], by)];
            for p in 0..=q {
                let entry = dot(column(at, block, p), product);
                at.put(entry, &mut self.rows[p][q - p]);
            }
        }
    }
}

/// How a coefficient counts for b, b' and b'' in the middle.
#[inline(always)]
fn column<S: Simd>(at: Part<S>, block: &Block, k: usize) -> [Wide<S>; 3] {
    let [b, slope, second] = &block.basis;
    [at.get(&b[k]), at.get(&slope[k]), at.get(&second[k])]
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
