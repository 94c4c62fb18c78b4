//! The smoothest spline that passes within given distances of given places.
//!
//! The integral of the squared third derivative is least, subject to |e| <= r at each site, with e
//! the distance of the spline from the site. A primal-dual interior-point method: each site has a
//! slack s = (r^2 - |e|^2) / 2 and a multiplier, which are eliminated, so that each step solves one
//! banded system in the coefficients, the axes coupled. Slack times multiplier is aimed at the same
//! part of the bending around each site, so that gentle stretches are found as well as sharp ones.

use super::spline::{Breaks, ORDER, combined};
use lostmotion_base::linalg::solve_banded;
use lostmotion_base::vec::{Vec3, dot, sub};
use std::ops::Range;

/// Most steps of one fit. A choice: 6 to 15 are needed.
const MAX_STEPS: usize = 40;
/// Slack times multiplier at which the steps end, as a part of the bending around a site. A choice:
/// a tenth of it changes no time by more than 0.2 %.
const GAP_PART: f64 = 0.02;
/// Square of the distance from a site, in units of its radius, at which the steps may end. A choice:
/// the radius is aimed at with more room than that.
const KEPT_SQUARE: f64 = 1.01;
/// Part of the way to the nearest bound that a step goes at most. A choice, as usual.
const STEP_PART: f64 = 0.98;
/// Factor on slack times multiplier that a step aims at where the last one went its full length. A
/// choice.
const CENTERING: f64 = 0.15;
/// Length of a step, as a part of the full one, from which on it counts as full. A choice.
const FULL_STEP: f64 = 0.9;
/// Part of an interval's bending that counts on the next one. A choice.
const SPREAD: f64 = 0.3;
/// Least bending of an interval, as a part of all. A choice: keeps a straight stretch regular.
const LEAST_BENDING: f64 = 1e-9;
/// Slack of a site that begins outside of its radius, in units of r^2. A choice.
const FIRST_SLACK: f64 = 0.1;

/// A place near which the spline has to pass.
#[derive(Clone, Copy, Debug)]
pub(super) struct Site {
    pub(super) w: f64,
    pub(super) interval: usize,
    basis: [f64; ORDER],
    pub(super) place: Vec3,
    radius: f64,
    multiplier: f64,
    slack: f64,
}

impl Site {
    pub(super) fn new(breaks: &Breaks, interval: usize, w: f64, place: Vec3, radius: f64) -> Site {
        Site {
            w,
            interval,
            basis: breaks.basis(interval, w),
            place,
            radius,
            multiplier: 0.0,
            slack: 0.0,
        }
    }

    /// Allows less.
    pub(super) fn narrow(&mut self, factor: f64) {
        self.radius *= factor;
        self.slack *= factor * factor;
    }

    fn square(&self) -> f64 {
        self.radius * self.radius
    }

    fn off(&self, coefficients: &[Vec3]) -> Vec3 {
        sub(self.at(coefficients), self.place)
    }

    /// Value of the spline with these coefficients.
    fn at(&self, coefficients: &[Vec3]) -> Vec3 {
        combined(
            &coefficients[self.interval..self.interval + ORDER],
            &self.basis,
        )
    }

    /// By how much the slack is less than what the distance leaves.
    fn missing(&self, off: &Vec3) -> f64 {
        0.5 * (self.square() - dot(*off, *off)) - self.slack
    }
}

/// What a step changes at a site.
#[derive(Clone, Copy, Debug)]
struct Change {
    slack: f64,
    multiplier: f64,
}

/// The spline to be found, but for its coefficients.
#[derive(Debug)]
pub(super) struct Fit<'a> {
    breaks: &'a Breaks,
    /// Coefficients that may move; the others are given.
    free: Range<usize>,
    /// The third derivative on each interval as weights of its coefficients.
    thirds: Vec<[f64; ORDER]>,
}

impl Fit<'_> {
    pub(super) fn new(breaks: &Breaks, free: Range<usize>) -> Fit<'_> {
        Fit {
            breaks,
            free,
            thirds: (0..breaks.intervals()).map(|k| breaks.third(k)).collect(),
        }
    }

    /// Improves the coefficients from where they are; returns whether they settled.
    pub(super) fn solve(&self, coefficients: &mut [Vec3], sites: &mut [Site]) -> bool {
        // What is flat stays flat, at half of the cost.
        let moves = |axis: usize| {
            let first = coefficients.first().map_or(0.0, |c| c[axis]);
            coefficients.iter().any(|c| c[axis] != first)
                || sites.iter().any(|site| site.place[axis] != first)
        };
        match [0, 1, 2].map(moves) {
            [_, _, false] => self.steps::<2, 8>([0, 1], coefficients, sites),
            [_, false, _] => self.steps::<2, 8>([0, 2], coefficients, sites),
            [false, _, _] => self.steps::<2, 8>([1, 2], coefficients, sites),
            _ => self.steps::<3, 12>([0, 1, 2], coefficients, sites),
        }
    }

    /// The same over the axes that move; W is N times the order.
    fn steps<const N: usize, const W: usize>(
        &self,
        axes: [usize; N],
        coefficients: &mut [Vec3],
        sites: &mut [Site],
    ) -> bool {
        let mut bending = self.bending(coefficients);
        let mut offs: Vec<Vec3> = sites.iter().map(|site| site.off(coefficients)).collect();
        for (site, off) in sites.iter_mut().zip(&offs) {
            // What is new begins with the bending around it.
            if site.multiplier == 0.0 {
                site.multiplier = bending[site.interval] / site.square();
                site.slack = site.missing(off).max(FIRST_SLACK * site.square());
            }
        }
        let count = coefficients.len() * N;
        let (mut rows, mut right) = (vec![[0.0; W]; count], vec![[0.0; 1]; count]);
        let free = self.free.start * N..self.free.end * N;
        let mut step = vec![[0.0; 3]; coefficients.len()];
        let mut changes = Vec::with_capacity(sites.len());
        let mut last_length = 1.0_f64;
        for _ in 0..MAX_STEPS {
            let (mut sum, mut all, mut farthest) = (0.0, 0.0, 0.0_f64);
            for (site, off) in sites.iter().zip(&offs) {
                sum += site.multiplier * site.slack;
                all += bending[site.interval];
                farthest = farthest.max(dot(*off, *off) / site.square());
            }
            let gap = sum / all;
            if gap <= GAP_PART && farthest <= KEPT_SQUARE {
                return true;
            }
            // The gap closes no faster than the steps get on.
            let target = gap
                * if last_length > FULL_STEP {
                    CENTERING
                } else {
                    (1.0 - last_length).max(CENTERING)
                };
            rows.fill([0.0; W]);
            right.fill([0.0]);
            let mut these = sites.iter().zip(&offs).peekable();
            for (k, bending) in bending.iter().enumerate() {
                let mut share = self.bent::<N>(axes, k, &coefficients[k..k + ORDER]);
                while let Some((site, off)) = these.next_if(|(site, _)| site.interval == k) {
                    share.add(site, axes.map(|axis| off[axis]), off, target * bending);
                }
                share.gather(&mut rows[k * N..], &mut right[k * N..]);
            }
            // What is given takes no step: its rows and columns are left out.
            solve_banded(&mut rows[free.clone()], &mut right[free.clone()]);
            for (step, solved) in step[self.free.clone()]
                .iter_mut()
                .zip(right[free.clone()].chunks_exact(N))
            {
                for (axis, value) in axes.iter().zip(solved) {
                    step[*axis] = value[0];
                }
            }
            // As far as slacks and multipliers stay positive.
            let mut length = 1.0_f64;
            changes.clear();
            for (site, off) in sites.iter().zip(&offs) {
                let slack = site.missing(off) - dot(*off, site.at(&step));
                let target = target * bending[site.interval];
                let multiplier = (target - site.multiplier * (site.slack + slack)) / site.slack;
                for (value, change) in [(site.slack, slack), (site.multiplier, multiplier)] {
                    if change < 0.0 {
                        length = length.min(-STEP_PART * value / change);
                    }
                }
                changes.push(Change { slack, multiplier });
            }
            for (coefficient, step) in coefficients.iter_mut().zip(&step) {
                for (coordinate, step) in coefficient.iter_mut().zip(step) {
                    *coordinate += length * step;
                }
            }
            if !coefficients.iter().flatten().all(|value| value.is_finite()) {
                return false;
            }
            for ((site, off), change) in sites.iter_mut().zip(&mut offs).zip(&changes) {
                site.slack += length * change.slack;
                site.multiplier += length * change.multiplier;
                *off = site.off(coefficients);
                // Where there is more room than the slack says, it is taken.
                site.slack += site.missing(off).max(0.0);
            }
            bending = self.bending(coefficients);
            last_length = length;
        }
        false
    }

    /// Half the integral of the squared third derivative over each interval, spread to its
    /// neighbours.
    fn bending(&self, coefficients: &[Vec3]) -> Vec<f64> {
        let widths = self.breaks.0.windows(2).map(|pair| pair[1] - pair[0]);
        let mut bending: Vec<f64> = widths
            .enumerate()
            .map(|(k, width)| {
                let third = combined(&coefficients[k..k + ORDER], &self.thirds[k]);
                0.5 * width * dot(third, third)
            })
            .collect();
        let least = (LEAST_BENDING * bending.iter().sum::<f64>()).max(f64::MIN_POSITIVE);
        let mut before = least;
        let mut spread = |bending: &mut f64| {
            *bending = bending.max(SPREAD * before).max(least);
            before = *bending;
        };
        bending.iter_mut().for_each(&mut spread);
        bending.iter_mut().rev().for_each(&mut spread);
        bending
    }

    /// The bending's share of an interval, given its coefficients.
    fn bent<const N: usize>(&self, axes: [usize; N], k: usize, coefficients: &[Vec3]) -> Share<N> {
        let third = &self.thirds[k];
        let width = self.breaks.0[k + 1] - self.breaks.0[k];
        let value = combined(coefficients, third);
        let weights = third.map(|weight| width * weight);
        let mut share = Share {
            blocks: [[[0.0; PAIRS]; N]; N],
            right: axes.map(|axis| weights.map(|weight| -weight * value[axis])),
        };
        let all = pairs(&weights, third);
        for (i, row) in share.blocks.iter_mut().enumerate() {
            row[i] = all;
        }
        share
    }
}

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
struct Share<const N: usize> {
    /// For each pair of axes, the second one not before the first: the matrix by pairs of
    /// coefficients.
    blocks: [[[f64; PAIRS]; N]; N],
    right: [[f64; ORDER]; N],
}

impl<const N: usize> Share<N> {
    /// Adds a site with its slack and multiplier eliminated; `e` is how far it is off in the axes
    /// that move, and `target` what slack times multiplier should be.
    #[inline]
    fn add(&mut self, site: &Site, e: [f64; N], off: &Vec3, target: f64) {
        let stiff = site.multiplier / site.slack;
        // The multiplier after the step, but for what the step changes of the slack.
        let pull = target / site.slack - stiff * site.missing(off);
        let weights = pairs(&site.basis, &site.basis);
        for i in 0..N {
            for j in i..N {
                let own = if i == j { site.multiplier } else { 0.0 };
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

    /// Adds all to the rows of the interval's coefficients.
    #[inline]
    fn gather<const W: usize>(&self, rows: &mut [[f64; W]], right: &mut [[f64; 1]]) {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Between two sites aside of a line, the smoothest way touches both radii, and no admissible
    /// change of a coefficient bends it less.
    #[test]
    fn no_change_of_a_coefficient_bends_less() {
        let breaks = Breaks((0..=12).map(|k| 0.5 * f64::from(k)).collect());
        let count = breaks.coefficients();
        let fit = Fit::new(&breaks, 1..count - 1);
        let height = |w: f64| match w {
            w if w <= 0.0 || w >= 6.0 => 0.0,
            w if w < 2.0 => 0.5,
            w if w < 3.6 => -0.4,
            _ => 0.3,
        };
        let mut coefficients: Vec<Vec3> = (0..count)
            .map(|j| breaks.greville(j))
            .map(|w| [w, height(w), 0.0])
            .collect();
        let mut sites: Vec<Site> = [(1.2, 0.5), (2.9, -0.4), (4.4, 0.3)]
            .map(|(w, y)| Site::new(&breaks, breaks.interval(w), w, [w, y, 0.0], 0.1))
            .to_vec();
        assert!(fit.solve(&mut coefficients, &mut sites));
        let squares = |coefficients: &[Vec3]| {
            fit.thirds
                .iter()
                .enumerate()
                .map(|(k, third)| {
                    let value = combined(&coefficients[k..k + ORDER], third);
                    0.25 * dot(value, value)
                })
                .sum::<f64>()
        };
        let inside = |coefficients: &[Vec3]| {
            sites.iter().all(|site| {
                let off = site.off(coefficients);
                dot(off, off) <= KEPT_SQUARE * site.square()
            })
        };
        assert!(inside(&coefficients));
        let least = squares(&coefficients);
        let mut tried = 0;
        for j in 1..count - 1 {
            for axis in 0..2 {
                for change in [-0.03, -0.003, -3e-4, 3e-4, 0.003, 0.03] {
                    let mut other = coefficients.clone();
                    other[j][axis] += change;
                    if inside(&other) {
                        tried += 1;
                        // What the gap leaves.
                        assert!(squares(&other) > (1.0 - 2.0 * GAP_PART) * least);
                    }
                }
            }
        }
        assert!(tried > 40, "{tried}");
        let touched = sites.iter().filter(|site| {
            let off = site.off(&coefficients);
            dot(off, off) > 0.9 * site.square()
        });
        assert_eq!(touched.count(), 3);
    }
}
