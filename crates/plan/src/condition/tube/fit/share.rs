//! What an interval adds to the system of a step.

use super::banded::SystemRow;
use super::site::Site;
use crate::condition::tube::spline::ORDER;
use lostmotion_base::vec::{Vec3, dot};
use pulp::Simd;

/// Pairs of the coefficients of an interval, the first one not after the second.
const COUNT: usize = ORDER * (ORDER + 1) / 2;
/// The same and as many more as the widest vectors hold.
const PAIRS: usize = 16;

/// The pair of each two coefficients.
const PAIR: [[usize; ORDER]; ORDER] = [[0, 1, 2, 3], [1, 4, 5, 6], [2, 5, 7, 8], [3, 6, 8, 9]];

/// Products of each pair.
#[inline(always)]
fn pairs(a: &[f64; ORDER], b: &[f64; ORDER]) -> [f64; PAIRS] {
    let mut products = [0.0; PAIRS];
    for p in 0..ORDER {
        for q in p..ORDER {
            products[PAIR[p][q]] = a[p] * b[q];
        }
    }
    products
}

/// How much the coefficients of an interval and their pairs count for something that is a sum over the
/// coefficients.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    single: [f64; ORDER],
    pairs: [f64; PAIRS],
}

impl Weights {
    pub(super) fn new(basis: &[f64; ORDER]) -> Weights {
        Weights {
            single: *basis,
            pairs: pairs(basis, basis),
        }
    }

    /// The same over a width.
    pub(super) fn over(width: f64, basis: &[f64; ORDER]) -> Weights {
        let single = basis.map(|weight| width * weight);
        Weights {
            single,
            pairs: pairs(&single, basis),
        }
    }
}

/// How far the spline is off a site.
#[derive(Clone, Copy, Debug)]
pub(super) struct Off {
    /// What of it counts.
    pub(super) counted: Vec3,
    /// Square of the distance.
    pub(super) square: f64,
}

impl Off {
    #[inline(always)]
    pub(super) fn new(site: &Site, coefficients: &[Vec3]) -> Off {
        let off = site.off(coefficients);
        let counted = site.counted(&off);
        Off {
            counted,
            square: dot(off, counted),
        }
    }

    /// By how much the slack is less than what the distance leaves.
    #[inline(always)]
    pub(super) fn missing(&self, site: &Site) -> f64 {
        0.5 * (site.square() - self.square) - site.slack
    }
}

/// What an interval adds to the system of a step.
#[derive(Debug)]
pub(super) struct Share<const N: usize> {
    /// For each pair of axes, the second one not before the first: the matrix by pairs of
    /// coefficients.
    blocks: [[[f64; PAIRS]; N]; N],
    right: [[f64; ORDER]; N],
}

impl<const N: usize> Default for Share<N> {
    fn default() -> Self {
        Share {
            blocks: [[[0.0; PAIRS]; N]; N],
            right: [[0.0; ORDER]; N],
        }
    }
}

impl<const N: usize> Share<N> {
    /// Adds nothing yet.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        for i in 0..N {
            for block in &mut self.blocks[i][i..] {
                *block = [0.0; PAIRS];
            }
        }
        self.right = [[0.0; ORDER]; N];
    }

    /// Adds the square of a derivative.
    #[inline(always)]
    pub(super) fn bend_evenly<S: Simd>(&mut self, simd: S, weights: &Weights, slopes: [f64; N]) {
        for (i, slope) in slopes.into_iter().enumerate() {
            self.add_block(simd, i, i, weights, 1.0);
            self.pull(i, weights, slope);
        }
    }

    /// Adds a function of a derivative by its gradient and its second derivatives.
    // By numbers: iterators of one array hide the others' lengths.
    #[allow(clippy::needless_range_loop)]
    #[inline(always)]
    pub(super) fn bend<S: Simd>(
        &mut self,
        simd: S,
        weights: &Weights,
        (gradient, second): ([f64; N], [[f64; N]; N]),
    ) {
        for i in 0..N {
            for j in i..N {
                self.add_block(simd, i, j, weights, second[i][j]);
            }
            self.pull(i, weights, gradient[i]);
        }
    }

    #[inline(always)]
    fn add_block<S: Simd>(&mut self, simd: S, i: usize, j: usize, weights: &Weights, factor: f64) {
        let factor = simd.splat_f64s(factor);
        let entries = S::as_mut_simd_f64s(&mut self.blocks[i][j]).0;
        let weights = S::as_simd_f64s(&weights.pairs).0;
        for k in 0..COUNT.div_ceil(S::F64_LANES) {
            entries[k] = simd.add_f64s(entries[k], simd.mul_f64s(factor, weights[k]));
        }
    }

    #[inline(always)]
    fn pull(&mut self, i: usize, weights: &Weights, slope: f64) {
        for (entry, weight) in self.right[i].iter_mut().zip(&weights.single) {
            *entry -= weight * slope;
        }
    }

    /// Adds a site with its slack and multiplier eliminated; `target` is what slack times multiplier
    /// should be.
    #[inline(always)]
    pub(super) fn add<S: Simd>(
        &mut self,
        simd: S,
        site: &Site,
        weights: &Weights,
        axes: [usize; N],
        off: &Off,
        target: f64,
    ) {
        let (mut e, mut d) = ([0.0; N], [0.0; N]);
        for i in 0..N {
            (e[i], d[i]) = (off.counted[axes[i]], site.direction[axes[i]]);
        }
        let stiff = site.multiplier / site.slack;
        // The multiplier after the step, but for what the step changes of the slack.
        let pull = target / site.slack - stiff * off.missing(site);
        for i in 0..N {
            for j in i..N {
                let own = if i == j { 1.0 } else { 0.0 };
                let own = site.multiplier * (own - d[i] * d[j]);
                self.add_block(simd, i, j, weights, own + stiff * e[i] * e[j]);
            }
            self.pull(i, weights, pull * e[i]);
        }
    }

    /// How much the interval's coefficient p is held.
    pub(super) fn held(&self, p: usize) -> f64 {
        (0..N)
            .map(|i| self.blocks[i][i][PAIR[p][p]])
            .fold(f64::MIN_POSITIVE, f64::max)
    }

    /// Adds all to the rows of the interval's coefficients, of which the first one has a number.
    // By numbers, as before.
    #[allow(clippy::needless_range_loop)]
    #[inline(always)]
    pub(super) fn gather<const M: usize>(
        &self,
        first: usize,
        rows: &mut [[SystemRow<M>; N]],
        right: &mut [[f64; N]],
    ) {
        let (rows, right) = (&mut rows[..ORDER], &mut right[..ORDER]);
        for p in 0..ORDER {
            for i in 0..N {
                right[p][i] += self.right[i][p];
            }
            for q in p..ORDER {
                let (pair, at) = (PAIR[p][q], (first + q) % ORDER);
                for i in 0..N {
                    let columns = &mut rows[p][i][at];
                    for j in 0..N {
                        columns[j] += self.blocks[i.min(j)][i.max(j)][pair];
                    }
                }
            }
        }
    }
}
