//! The smoothest spline that passes within given distances of given places.
//!
//! The integral of the squared third derivative is least, subject to |e| <= r at each site, with e
//! the distance of the spline from the site. A primal-dual interior-point method: each site has a
//! slack s = (r^2 - |e|^2) / 2 and a multiplier, which are eliminated, so that each step solves one
//! banded system in the coefficients, the axes coupled. Slack times multiplier is aimed at the same
//! part of the bending around each site, so that gentle stretches are found as well as sharp ones.

mod banded;
mod descent;
mod rail;
mod share;
mod site;

use super::spline::{Breaks, ORDER, combined};
use descent::Descent;
use lostmotion_base::vec::{Vec3, dot};
use pulp::{Arch, Simd};
pub(super) use rail::Rail;
use share::{Share, Weights};
pub(super) use site::Site;
use std::ops::Range;

/// Part of an interval's bending that counts on the next one. A choice.
const SPREAD: f64 = 0.3;
/// Least bending of an interval, as a part of all. A choice: keeps a straight stretch regular.
const LEAST_BENDING: f64 = 1e-9;

/// What is to be least: a convex function of the third derivative, times the width of the interval.
pub(super) trait Bending {
    /// Its value.
    fn value(&self, third: &Vec3) -> f64;

    /// Its gradient and its second derivatives in the axes that move, from the diagonal on.
    fn slopes<const N: usize>(&self, axes: [usize; N], third: &Vec3) -> ([f64; N], [[f64; N]; N]);

    /// Whether it is a square, of which one step finds the least.
    const IS_SQUARE: bool;

    /// Whether the second derivative where an interval begins counts, too.
    const HEEDS_SECOND: bool;

    /// The same of the second derivative.
    fn second_value(&self, second: &Vec3) -> f64;

    /// The same of the second derivative.
    fn second_slopes<const N: usize>(
        &self,
        axes: [usize; N],
        second: &Vec3,
    ) -> ([f64; N], [[f64; N]; N]);
}

/// Half of the square.
#[derive(Clone, Copy, Debug)]
pub(super) struct Squared;

impl Bending for Squared {
    #[inline(always)]
    fn value(&self, third: &Vec3) -> f64 {
        0.5 * dot(*third, *third)
    }

    #[inline(always)]
    fn slopes<const N: usize>(&self, axes: [usize; N], third: &Vec3) -> ([f64; N], [[f64; N]; N]) {
        let mut unit = [[0.0; N]; N];
        for (i, row) in unit.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        (axes.map(|axis| third[axis]), unit)
    }

    const IS_SQUARE: bool = true;

    const HEEDS_SECOND: bool = false;

    #[inline(always)]
    fn second_value(&self, _: &Vec3) -> f64 {
        0.0
    }

    #[inline(always)]
    fn second_slopes<const N: usize>(&self, _: [usize; N], _: &Vec3) -> ([f64; N], [[f64; N]; N]) {
        ([0.0; N], [[0.0; N]; N])
    }
}

/// The spline to be found, but for its coefficients.
#[derive(Debug)]
pub(super) struct Fit<'a, B> {
    breaks: &'a Breaks,
    bending: B,
    /// Coefficients that may move; the others are given.
    free: Range<usize>,
    /// Factor on the gap and on the last change at which the steps end.
    rough: f64,
    rails: Vec<Rail>,
    /// The third derivative on each interval as weights of its coefficients.
    thirds: Vec<Derivative>,
    /// The second derivative where each interval begins, where it counts.
    seconds: Vec<Derivative>,
}

/// A derivative on an interval.
#[derive(Clone, Copy, Debug)]
struct Derivative {
    /// Weights of the coefficients.
    basis: [f64; ORDER],
    /// The same, and those of their pairs, over the width of the interval.
    weights: Weights,
}

impl Derivative {
    fn new(breaks: &Breaks, k: usize, basis: [f64; ORDER]) -> Derivative {
        let width = breaks.0[k + 1] - breaks.0[k];
        Derivative {
            basis,
            weights: Weights::over(width, &basis),
        }
    }
}

/// The third derivative on an interval, and the second one where it begins where that counts.
type Bent = [Vec3; 2];

impl<B: Bending> Fit<'_, B> {
    pub(super) fn new(breaks: &Breaks, bending: B, free: Range<usize>) -> Fit<'_, B> {
        Fit {
            breaks,
            bending,
            free,
            rough: 1.0,
            rails: Vec::new(),
            thirds: (0..breaks.intervals())
                .map(|k| Derivative::new(breaks, k, breaks.third(k)))
                .collect(),
            seconds: (0..breaks.intervals())
                .filter(|_| B::HEEDS_SECOND)
                .map(|k| Derivative::new(breaks, k, breaks.second(k)))
                .collect(),
        }
    }

    /// Ends its steps earlier, by a factor: for what another fit goes on from.
    pub(super) fn roughly(self, rough: f64) -> Self {
        Fit { rough, ..self }
    }

    pub(super) fn on_rails(self, rails: Vec<Rail>) -> Self {
        Fit { rails, ..self }
    }

    /// Improves the coefficients from where they are; returns whether they settled.
    pub(super) fn solve(&self, coefficients: &mut [Vec3], sites: &mut [Site]) -> bool {
        self.solve_part(0..self.breaks.intervals(), coefficients, sites)
    }

    /// The same on some intervals alone: what lies beyond stays as it is, with the derivatives where they
    /// meet.
    pub(super) fn solve_part(
        &self,
        part: Range<usize>,
        coefficients: &mut [Vec3],
        sites: &mut [Site],
    ) -> bool {
        let first = sites.partition_point(|site| site.interval < part.start);
        let end = sites.partition_point(|site| site.interval < part.end);
        let sites = &mut sites[first..end];
        // What is flat stays flat, at half of the cost.
        let moves = |axis: usize| {
            let first = coefficients.first().map_or(0.0, |c| c[axis]);
            coefficients.iter().any(|c| c[axis] != first)
                || sites.iter().any(|site| site.place[axis] != first)
        };
        match [0, 1, 2].map(moves) {
            [_, _, false] => self.descend::<2, 2>([0, 1], part, coefficients, sites),
            [_, false, _] => self.descend::<2, 2>([0, 2], part, coefficients, sites),
            [false, _, _] => self.descend::<2, 2>([1, 2], part, coefficients, sites),
            _ => self.descend::<3, 4>([0, 1, 2], part, coefficients, sites),
        }
    }

    /// Goes on until the coefficients settle, in vectors as wide as the processor has them; returns whether
    /// they do.
    fn descend<const N: usize, const M: usize>(
        &self,
        axes: [usize; N],
        part: Range<usize>,
        coefficients: &mut [Vec3],
        sites: &mut [Site],
    ) -> bool {
        Arch::new().dispatch(Descent::<B, N, M>::new(
            self,
            axes,
            part,
            coefficients,
            sites,
        ))
    }

    /// Coefficients that may move where a part is fitted: those that no interval beyond has.
    fn moves(&self, part: &Range<usize>) -> Range<usize> {
        let start = if part.start == 0 {
            self.free.start
        } else {
            part.start + ORDER - 1
        };
        let end = if part.end == self.breaks.intervals() {
            self.free.end
        } else {
            part.end
        };
        start..end
    }

    /// What is to be least over each interval, spread to its neighbours, and the derivatives there.
    #[inline(always)]
    fn bending(
        &self,
        part: &Range<usize>,
        coefficients: &[Vec3],
        bending: &mut Vec<f64>,
        bent: &mut Vec<Bent>,
    ) {
        bending.clear();
        bent.clear();
        for k in part.clone() {
            let width = self.breaks.0[k + 1] - self.breaks.0[k];
            let these = &coefficients[k..k + ORDER];
            let third = combined(these, &self.thirds[k].basis);
            let (mut second, mut by_second) = ([0.0; 3], 0.0);
            if B::HEEDS_SECOND {
                second = combined(these, &self.seconds[k].basis);
                by_second = self.bending.second_value(&second);
            }
            bending.push(width * (self.bending.value(&third) + by_second));
            bent.push([third, second]);
        }
        let least = (LEAST_BENDING * bending.iter().sum::<f64>()).max(f64::MIN_POSITIVE);
        let mut before = least;
        let mut spread = |bending: &mut f64| {
            *bending = bending.max(SPREAD * before).max(least);
            before = *bending;
        };
        bending.iter_mut().for_each(&mut spread);
        bending.iter_mut().rev().for_each(&mut spread);
    }

    /// Adds the bending's share of an interval, given the derivatives there.
    #[inline(always)]
    fn bend<S: Simd, const N: usize>(
        &self,
        simd: S,
        share: &mut Share<N>,
        axes: [usize; N],
        k: usize,
        [third, second]: &Bent,
    ) {
        let slopes = self.bending.slopes(axes, third);
        if B::IS_SQUARE {
            share.bend_evenly(simd, &self.thirds[k].weights, slopes.0);
        } else {
            share.bend(simd, &self.thirds[k].weights, slopes);
        }
        if B::HEEDS_SECOND {
            let slopes = self.bending.second_slopes(axes, second);
            share.bend(simd, &self.seconds[k].weights, slopes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::descent::{GAP_PART, KEPT_SQUARE};
    use super::*;

    /// Between two sites aside of a line, the smoothest way touches both radii, and no admissible
    /// change of a coefficient bends it less.
    #[test]
    fn no_change_of_a_coefficient_bends_less() {
        let breaks = Breaks((0..=12).map(|k| 0.5 * f64::from(k)).collect());
        let count = breaks.coefficients();
        let fit = Fit::new(&breaks, Squared, 1..count - 1);
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
                    let value = combined(&coefficients[k..k + ORDER], &third.basis);
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

    /// Where one site is narrowed, what is found again around it is what all of it gives, and the rest stays
    /// to the last bit.
    #[test]
    fn a_part_is_found_as_the_whole_is() {
        let breaks = Breaks((0..=80).map(|k| 0.5 * f64::from(k)).collect());
        let count = breaks.coefficients();
        let fit = Fit::new(&breaks, Squared, 1..count - 1);
        let height = |w: f64| {
            if ((w / 3.0) as usize).is_multiple_of(2) {
                0.0
            } else {
                0.4
            }
        };
        let mut coefficients: Vec<Vec3> = (0..count)
            .map(|j| breaks.greville(j))
            .map(|w| [w, height(w), 0.0])
            .collect();
        let mut sites: Vec<Site> = (0..13)
            .map(|k| 1.3 + 3.0 * f64::from(k))
            .map(|w| Site::new(&breaks, breaks.interval(w), w, [w, height(w), 0.0], 0.1))
            .collect();
        assert!(fit.solve(&mut coefficients, &mut sites));
        sites[6].narrow(0.8);
        let k = sites[6].interval;
        let part = k - 16..k + 17;
        let (mut found, mut found_sites) = (coefficients.clone(), sites.clone());
        assert!(fit.solve_part(part.clone(), &mut found, &mut found_sites));
        for j in (0..count).filter(|j| *j < part.start + ORDER - 1 || *j >= part.end) {
            assert_eq!(found[j], coefficients[j], "{j}");
        }
        let off = found_sites[6].off(&found);
        assert!(dot(off, off) <= KEPT_SQUARE * found_sites[6].square());
        let mut whole = coefficients.clone();
        assert!(fit.solve(&mut whole, &mut sites));
        let [by_part, by_whole] = [&found, &whole].map(|c| {
            let third = |k: usize| combined(&c[k..k + ORDER], &fit.thirds[k].basis);
            (0..breaks.intervals())
                .map(|k| dot(third(k), third(k)))
                .sum::<f64>()
        });
        assert!(
            (by_part - by_whole).abs() < GAP_PART * by_whole,
            "{by_part} {by_whole}"
        );
    }
}
