//! What an interval adds to the system of a step.

use super::Rail;
use super::site::Site;
use crate::condition::tube::spline::ORDER;
use lostmotion_base::vec::{Vec3, along, dot, sub};

/// Stiffness of a ray, in units of what else holds the coefficient. A choice: it is put on the ray
/// afterwards, and has to be near it.
const RAIL_STIFFNESS: f64 = 1e5;

/// Pairs of the coefficients of an interval, the first one not after the second.
const PAIRS: usize = ORDER * (ORDER + 1) / 2;

/// Products of each pair.
fn pairs(a: &[f64; ORDER], b: &[f64; ORDER]) -> [f64; PAIRS] {
    let mut products = [0.0; PAIRS];
    let mut next = products.iter_mut();
    for (p, a) in a.iter().enumerate() {
        for (b, product) in b[p..].iter().zip(&mut next) {
            *product = a * b;
        }
    }
    products
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
    /// Adds a function of a derivative, given as weights of the coefficients, by its gradient and its
    /// second derivatives.
    #[inline]
    pub(super) fn bend(
        &mut self,
        width: f64,
        derivative: &[f64; ORDER],
        (gradient, second): ([f64; N], [[f64; N]; N]),
    ) {
        let weights = derivative.map(|weight| width * weight);
        let all = pairs(&weights, derivative);
        for (rows, factors) in self.blocks.iter_mut().zip(&second) {
            for (block, factor) in rows.iter_mut().zip(factors) {
                for (entry, weight) in block.iter_mut().zip(&all) {
                    *entry += factor * weight;
                }
            }
        }
        for (right, slope) in self.right.iter_mut().zip(&gradient) {
            for (entry, weight) in right.iter_mut().zip(&weights) {
                *entry -= weight * slope;
            }
        }
    }

    /// Adds a site with its slack and multiplier eliminated; `off` is how far it is off, and `target`
    /// what slack times multiplier should be.
    #[inline]
    pub(super) fn add(&mut self, site: &Site, axes: [usize; N], off: &Vec3, target: f64) {
        let counted = site.counted(off);
        let (e, d) = (
            axes.map(|axis| counted[axis]),
            axes.map(|axis| site.direction[axis]),
        );
        let stiff = site.multiplier / site.slack;
        // The multiplier after the step, but for what the step changes of the slack.
        let pull = target / site.slack - stiff * site.missing(off);
        let weights = pairs(&site.basis, &site.basis);
        for i in 0..N {
            for j in i..N {
                let own = if i == j { 1.0 } else { 0.0 };
                let own = site.multiplier * (own - d[i] * d[j]);
                let factor = own + stiff * e[i] * e[j];
                for (entry, weight) in self.blocks[i][j].iter_mut().zip(&weights) {
                    *entry += factor * weight;
                }
            }
            let pull = pull * e[i];
            for (right, basis) in self.right[i].iter_mut().zip(&site.basis) {
                *right -= pull * basis;
            }
        }
    }

    /// Holds the interval's coefficient p, which is at a place, on a ray.
    pub(super) fn hold(&mut self, rail: &Rail, axes: [usize; N], p: usize, at: &Vec3) {
        // Pairs come row by row.
        let pair = p * ORDER - p * p.saturating_sub(1) / 2;
        let most = (0..N)
            .map(|i| self.blocks[i][i][pair])
            .fold(f64::MIN_POSITIVE, f64::max);
        let stiffness = RAIL_STIFFNESS * most;
        let off = sub(*at, rail.place);
        let aside = along(off, rail.direction, -dot(off, rail.direction));
        for i in 0..N {
            for j in i..N {
                let own = if i == j { 1.0 } else { 0.0 };
                let across = own - rail.direction[axes[i]] * rail.direction[axes[j]];
                self.blocks[i][j][pair] += stiffness * across;
            }
            self.right[i][p] -= stiffness * aside[axes[i]];
        }
    }

    /// Adds all to the rows of the interval's coefficients.
    #[inline]
    pub(super) fn gather<const W: usize>(&self, rows: &mut [[f64; W]], right: &mut [[f64; 1]]) {
        let mut pair = 0;
        for p in 0..ORDER {
            for i in 0..N {
                right[p * N + i][0] += self.right[i][p];
            }
            for q in p..ORDER {
                for i in 0..N {
                    let row = &mut rows[p * N + i];
                    let first = if q == p { i } else { 0 };
                    for j in first..N {
                        row[(q - p) * N + j - i] += self.blocks[i.min(j)][i.max(j)][pair];
                    }
                }
                pair += 1;
            }
        }
    }
}
