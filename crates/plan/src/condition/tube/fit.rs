//! The smoothest spline that passes within given distances of given places.
//!
//! The integral of the squared third derivative is least, subject to |x(w_i) - p_i| <= r_i at the
//! sites. A primal-dual interior-point method: each site has a slack (r^2 - |e|^2) / 2 and a
//! multiplier, which are eliminated, so that each step solves one banded system in the coefficients
//! with the axes coupled.

use super::spline::{Breaks, ORDER, combined};
use lostmotion_base::linalg::solve_banded;
use lostmotion_base::vec::{Vec3, dot, sub};
use std::ops::Range;

/// Most steps. A choice: 10 to 20 are needed.
const MAX_STEPS: usize = 40;
/// The complementarity at which the steps end, as a part of the objective. A choice.
const GAP_PART: f64 = 0.02;
/// Square of the distance from a site, in units of its radius, at which the steps may end: what is
/// proven is a little more.
const KEPT_SQUARE: f64 = 1.01;
/// Part of the way to the nearest bound that a step goes at most.
const STEP_PART: f64 = 0.98;
/// Factor on the complementarity at each step that goes its full length. A choice.
const CENTERING: f64 = 0.15;

/// Part of an interval's bending that counts on the next one. A choice.
const SPREAD: f64 = 0.3;
/// Least bending of an interval, as a part of all.
const LEAST_ENERGY: f64 = 1e-9;

/// A place near which the spline has to pass.
#[derive(Clone, Copy, Debug)]
pub(super) struct Site {
    pub(super) w: f64,
    pub(super) interval: usize,
    pub(super) basis: [f64; ORDER],
    pub(super) place: Vec3,
    pub(super) radius: f64,
    pub(super) multiplier: f64,
    slack: f64,
}

impl Site {
    pub(super) fn new(breaks: &Breaks, w: f64, place: Vec3, radius: f64) -> Site {
        let interval = breaks.interval(w);
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

    /// One more, given the multiplier that it begins with.
    pub(super) fn between(
        breaks: &Breaks,
        interval: usize,
        w: f64,
        place: Vec3,
        radius: f64,
        multiplier: f64,
    ) -> Site {
        Site {
            w,
            interval,
            basis: breaks.basis(interval, w),
            place,
            radius,
            multiplier,
            slack: 0.05 * radius * radius,
        }
    }

    /// Allows less.
    pub(super) fn narrow(&mut self, factor: f64) {
        self.radius *= factor;
        self.slack *= factor * factor;
    }

    fn off(&self, coefficients: &[Vec3]) -> Vec3 {
        let under = &coefficients[self.interval..self.interval + ORDER];
        sub(combined(under, &self.basis), self.place)
    }
}

/// What is to be solved.
#[derive(Debug)]
pub(super) struct Problem<'a> {
    pub(super) breaks: &'a Breaks,
    /// Coefficients that may move; the others are given.
    pub(super) free: Range<usize>,
    /// Weight of each interval's squared third derivative.
    pub(super) weights: &'a [f64],
}

impl Problem<'_> {
    /// Half the weighted square of the third derivative on each interval, spread to its neighbours.
    fn energies(&self, thirds: &[[f64; ORDER]], coefficients: &[Vec3]) -> Vec<f64> {
        let square = |k: usize| {
            let third = combined(&coefficients[k..k + ORDER], &thirds[k]);
            0.5 * self.weights[k] * dot(third, third)
        };
        let mut energies: Vec<f64> = (0..thirds.len()).map(square).collect();
        let least = LEAST_ENERGY * energies.iter().sum::<f64>();
        let mut before = least.max(f64::MIN_POSITIVE);
        for energy in &mut energies {
            *energy = energy.max(SPREAD * before);
            before = energy.max(least);
        }
        for energy in energies.iter_mut().rev() {
            *energy = energy.max(SPREAD * before).max(least).max(f64::MIN_POSITIVE);
            before = *energy;
        }
        energies
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

    fn steps<const N: usize, const W: usize>(
        &self,
        axes: [usize; N],
        coefficients: &mut [Vec3],
        sites: &mut [Site],
    ) -> bool {
        let thirds: Vec<[f64; ORDER]> = (0..self.breaks.intervals())
            .map(|k| self.breaks.third(k))
            .collect();
        let mut energies = self.energies(&thirds, coefficients);
        if sites.first().is_some_and(|site| site.multiplier == 0.0) {
            for site in sites.iter_mut() {
                let r2 = site.radius * site.radius;
                let off = site.off(coefficients);
                site.multiplier = energies[site.interval] / r2;
                site.slack = (0.5 * (r2 - dot(off, off))).max(0.1 * r2);
            }
        }
        let count = self.free.len() * N;
        let (mut rows, mut right) = (vec![[0.0; W]; count], vec![[0.0; 1]; count]);
        let mut step = vec![[0.0; 3]; coefficients.len()];
        let mut offs: Vec<Vec3> = sites.iter().map(|site| site.off(coefficients)).collect();
        let mut last_length = 1.0_f64;
        for nr in 0..MAX_STEPS {
            // Slack times multiplier is aimed at the same part of the bending around each site.
            let (mut sum, mut all) = (0.0, 0.0);
            for site in sites.iter() {
                sum += site.multiplier * site.slack;
                all += energies[site.interval];
            }
            let gap = sum / all;
            let over = sites
                .iter()
                .zip(&offs)
                .map(|(site, off)| dot(*off, *off) / (site.radius * site.radius))
                .fold(0.0, f64::max);
            if std::env::var("TUBE_STEPS").is_ok() { eprintln!("   {nr} gap {gap:.3e} over {over:.3} length {last_length:.3} energy {:.3e} off {:.3e}", energies.iter().sum::<f64>(), sites.iter().zip(&offs).map(|(s, o)| (dot(*o, *o)).sqrt() / s.radius).fold(0.0, f64::max)); }
            if gap <= crate::param("GAP", GAP_PART) && over <= KEPT_SQUARE {
                if std::env::var("TUBE_DEBUG").is_ok() { eprintln!("   steps {nr}"); }
                return true;
            }
            let target = gap * if last_length > 0.9 { CENTERING } else { (1.0 - last_length).max(CENTERING) };
            rows.fill([0.0; W]);
            right.fill([0.0]);
            let first = self.free.start;
            // The bending: its second derivative, and its slope to the right side.
            for (k, third) in thirds.iter().enumerate() {
                let value = combined(&coefficients[k..k + ORDER], third);
                for (p, dp) in third.iter().enumerate() {
                    let Some(row) = (k + p).checked_sub(first).filter(|r| *r < self.free.len())
                    else {
                        continue;
                    };
                    let weighted = self.weights[k] * dp;
                    for (i, axis) in axes.iter().enumerate() {
                        right[row * N + i][0] -= weighted * value[*axis];
                        for (q, dq) in third.iter().enumerate().skip(p) {
                            rows[row * N + i][(q - p) * N] += weighted * dq;
                        }
                    }
                }
            }
            // The sites, slack and multiplier eliminated.
            for (site, off) in sites.iter().zip(&offs) {
                let e = axes.map(|axis| off[axis]);
                let r2 = site.radius * site.radius;
                let missing = 0.5 * (r2 - dot(*off, *off)) - site.slack;
                let stiff = site.multiplier / site.slack;
                // The multiplier that the slack after the step should have.
                let pull = target * energies[site.interval] / site.slack - stiff * missing;
                for p in 0..ORDER {
                    let Some(row) = (site.interval + p)
                        .checked_sub(first)
                        .filter(|r| *r < self.free.len())
                    else {
                        continue;
                    };
                    let bp = site.basis[p];
                    for i in 0..N {
                        right[row * N + i][0] -= pull * bp * e[i];
                        let line = &mut rows[row * N + i];
                        for q in p..ORDER {
                            let weight = bp * site.basis[q];
                            let (plain, along) =
                                (site.multiplier * weight, stiff * weight * e[i]);
                            let from = if q == p { i } else { 0 };
                            for j in from..N {
                                line[(q - p) * N + j - i] += along * e[j];
                            }
                            line[(q - p) * N] += plain;
                        }
                    }
                }
            }
            solve_banded(&mut rows, &mut right);
            for (row, solved) in right.chunks_exact(N).enumerate() {
                for (axis, value) in axes.iter().zip(solved) {
                    step[first + row][*axis] = value[0];
                }
            }
            if !step.iter().flatten().all(|value| value.is_finite()) {
                return false;
            }
            // As far as slacks and multipliers stay positive.
            let mut length = 1.0_f64;
            let mut changes = Vec::with_capacity(sites.len());
            for (site, off) in sites.iter().zip(&offs) {
                let under = &step[site.interval..site.interval + ORDER];
                let moved = combined(under, &site.basis);
                let r2 = site.radius * site.radius;
                let missing = 0.5 * (r2 - dot(*off, *off)) - site.slack;
                let slack = missing - dot(*off, moved);
                let multiplier =
                    (target * energies[site.interval] - site.multiplier * (site.slack + slack)) / site.slack;
                if slack < 0.0 {
                    length = length.min(-STEP_PART * site.slack / slack);
                }
                if multiplier < 0.0 {
                    length = length.min(-STEP_PART * site.multiplier / multiplier);
                }
                changes.push((slack, multiplier));
            }
            for (site, (slack, multiplier)) in sites.iter_mut().zip(&changes) {
                site.slack += length * slack;
                site.multiplier += length * multiplier;
            }
            for (coefficient, step) in coefficients.iter_mut().zip(&step) {
                for (coordinate, step) in coefficient.iter_mut().zip(step) {
                    *coordinate += length * step;
                }
            }
            for (site, off) in sites.iter_mut().zip(&mut offs) {
                *off = site.off(coefficients);
                // Where there is more room than the slack says, it is taken.
                let room = 0.5 * (site.radius * site.radius - dot(*off, *off));
                site.slack = site.slack.max(room);
            }
            energies = self.energies(&thirds, coefficients);
            last_length = length;
        }
        false
    }
}
