//! The steps of a fit: what each aims at, the system that gives it, and how far it goes.

use super::banded::{self, SystemRow};
use super::share::{Off, Share, Weights};
use super::site::Site;
use super::{Bending, Bent, Fit};
use crate::condition::tube::spline::ORDER;
use lostmotion_base::vec::{Vec3, along, dot};
use pulp::{Simd, WithSimd};
use std::ops::Range;

/// Most steps of one fit. A choice: 6 to 15 are needed.
const MAX_STEPS: usize = 40;
/// The same for a part of the curve. A choice: 2 to 15 are needed where what lies beyond leaves enough
/// freedom.
const MAX_PART_STEPS: usize = 24;
/// Slack times multiplier at which the steps end, as a part of the bending around a site. A choice:
/// a tenth of it changes no time by more than 0.2 %.
pub(super) const GAP_PART: f64 = 0.02;
/// Square of the distance from a site, in units of its radius, at which the steps may end. A choice:
/// the radius is aimed at with more room than that.
pub(super) const KEPT_SQUARE: f64 = 1.01;
/// Part of the way to the nearest bound that a step goes at most. A choice, as usual.
const STEP_PART: f64 = 0.98;
/// Factor on slack times multiplier that a step aims at where the last one went its full length. A
/// choice.
const CENTERING: f64 = 0.15;
/// Least slack times multiplier that is aimed at, in units of that at which the steps end. A choice.
const LEAST_TARGET: f64 = 0.3;
/// Length of a step, as a part of the full one, from which on it counts as full. A choice.
const FULL_STEP: f64 = 0.9;
/// Part of what is to be least by which the last step may change it, for a full step. A choice: less takes
/// more steps and changes no time.
const SETTLED_PART: f64 = 0.03;
/// How often a step is halved, and the factor by which what is to be least may rise with it: where sites
/// are missed it has to. A choice.
const MAX_HALVINGS: usize = 6;
const MOST_RISE: f64 = 8.0;
/// Slack of a site that begins outside of its radius, in units of r^2. A choice.
const FIRST_SLACK: f64 = 0.1;

/// What a step changes at a site.
#[derive(Clone, Copy, Debug)]
struct Change {
    slack: f64,
    multiplier: f64,
}

/// How near the coefficients are to what is looked for.
struct Nearness {
    /// Slack times multiplier, as a part of the bending around the sites.
    gap: f64,
    /// The bending around the sites.
    bending: f64,
    /// The largest square of a distance from a site, in units of its radius.
    farthest: f64,
}

/// The steps of a fit over N axes that move, in columns of M.
pub(super) struct Descent<'a, B, const N: usize, const M: usize> {
    fit: &'a Fit<'a, B>,
    axes: [usize; N],
    /// Intervals that are fitted.
    part: Range<usize>,
    /// Coefficients that may move.
    moves: Range<usize>,
    coefficients: &'a mut [Vec3],
    sites: &'a mut [Site],
    /// How far the spline is off each site.
    offs: Vec<Off>,
    /// How the coefficients count for each site.
    weights: Vec<Weights>,
    /// What is to be least over each interval, spread to its neighbours.
    bending: Vec<f64>,
    /// The derivatives on each interval.
    bent: Vec<Bent>,
    /// The system of a step, a row for each axis of each coefficient of the intervals, and rows beyond.
    rows: Vec<[SystemRow<M>; N]>,
    right: Vec<[f64; N]>,
    /// What a step of full length changes.
    step: Vec<Vec3>,
    changes: Vec<Change>,
    /// The coefficients before the step.
    start: Vec<Vec3>,
    /// By how much the last step changed what is to be least.
    changed: f64,
    last_length: f64,
}

impl<'a, B: Bending, const N: usize, const M: usize> Descent<'a, B, N, M> {
    pub(super) fn new(
        fit: &'a Fit<'a, B>,
        axes: [usize; N],
        part: Range<usize>,
        coefficients: &'a mut [Vec3],
        sites: &'a mut [Site],
    ) -> Self {
        let (mut bending, mut bent) = (Vec::new(), Vec::new());
        fit.bending(&part, coefficients, &mut bending, &mut bent);
        let offs: Vec<Off> = sites
            .iter()
            .map(|site| Off::new(site, coefficients))
            .collect();
        for (site, off) in sites.iter_mut().zip(&offs) {
            // What is new begins with the bending around it.
            if site.multiplier == 0.0 {
                site.multiplier = bending[site.interval - part.start] / site.square();
                site.slack = off.missing(site).max(FIRST_SLACK * site.square());
            }
        }
        let count = part.len() + 2 * (ORDER - 1);
        Descent {
            fit,
            axes,
            moves: fit.moves(&part),
            offs,
            weights: sites.iter().map(|site| Weights::new(&site.basis)).collect(),
            bending,
            bent,
            rows: vec![[[[0.0; M]; ORDER]; N]; count],
            right: vec![[0.0; N]; count],
            step: vec![[0.0; 3]; coefficients.len()],
            changes: Vec::with_capacity(sites.len()),
            start: coefficients.to_vec(),
            changed: f64::INFINITY,
            last_length: 1.0,
            part,
            coefficients,
            sites,
        }
    }

    /// Goes on until the coefficients settle; returns whether they do.
    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> bool {
        let most = if self.part.len() < self.fit.breaks.intervals() {
            MAX_PART_STEPS
        } else {
            MAX_STEPS
        };
        for _ in 0..most {
            let nearness = self.nearness();
            if self.has_settled(&nearness) {
                return true;
            }
            let target = self.target(nearness.gap);
            self.gather(simd, target);
            self.solve(simd);
            let longest = self.longest(target);
            let before = self.bending.iter().sum();
            let length = self.go(longest, before);
            let mut values = self.coefficients.iter().flatten();
            if !values.all(|value| value.is_finite()) {
                return false;
            }
            self.follow(length);
            self.changed = (self.bending.iter().sum::<f64>() - before).abs();
            self.last_length = length;
        }
        false
    }

    #[inline(always)]
    fn nearness(&self) -> Nearness {
        let (mut sum, mut bending, mut farthest) = (0.0, 0.0, 0.0_f64);
        for (site, off) in self.sites.iter().zip(&self.offs) {
            sum += site.multiplier * site.slack;
            bending += self.bending[site.interval - self.part.start];
            farthest = farthest.max(off.square / site.square());
        }
        Nearness {
            gap: sum / bending,
            bending,
            farthest,
        }
    }

    #[inline(always)]
    fn has_settled(&self, nearness: &Nearness) -> bool {
        let rough = self.fit.rough;
        let is_still = B::IS_SQUARE
            || self.changed <= rough * SETTLED_PART * nearness.bending * self.last_length;
        nearness.gap <= rough * GAP_PART && nearness.farthest <= KEPT_SQUARE && is_still
    }

    /// Slack times multiplier that the next step aims at, as a part of the bending around each site.
    #[inline(always)]
    fn target(&self, gap: f64) -> f64 {
        // The gap closes no faster than the steps get on, and no further than is asked for: at a
        // site that is nearly touched a narrower one is reached in short steps alone.
        let centering = if self.last_length > FULL_STEP {
            CENTERING
        } else {
            (1.0 - self.last_length).max(CENTERING)
        };
        (centering * gap).max(LEAST_TARGET * self.fit.rough * GAP_PART)
    }

    /// Adds up the system of a step from its intervals, with their sites and rails.
    #[inline(always)]
    fn gather<S: Simd>(&mut self, simd: S, target: f64) {
        self.rows.fill([[[0.0; M]; ORDER]; N]);
        self.right.fill([0.0; N]);
        // In memory: as so many single numbers it would not go through vectors.
        let mut share = Box::<Share<N>>::default();
        let mut next = 0;
        let intervals = self.part.clone().zip(self.bending.iter().zip(&self.bent));
        for (k, (bending, bent)) in intervals {
            share.clear();
            self.fit.bend(simd, &mut share, self.axes, k, bent);
            while let Some(site) = self.sites.get(next).filter(|site| site.interval == k) {
                let (weights, off) = (&self.weights[next], &self.offs[next]);
                share.add(simd, site, weights, self.axes, off, target * bending);
                next += 1;
            }
            let first = k - self.part.start;
            let (rows, right) = (&mut self.rows[first..], &mut self.right[first..]);
            share.gather(first, rows, right);
            for rail in &self.fit.rails {
                if rail.is_in(k, self.fit.breaks.intervals()) {
                    rail.hold(
                        &share,
                        self.axes,
                        (k, first),
                        self.coefficients,
                        rows,
                        right,
                    );
                }
            }
        }
    }

    /// Finds the step of full length.
    #[inline(always)]
    fn solve<S: Simd>(&mut self, simd: S) {
        // What is given takes no step: its rows and columns are left out.
        let first = self.moves.start - self.part.start;
        let end = self.moves.end - self.part.start + ORDER - 1;
        let right = &mut self.right[first..end];
        banded::solve(simd, first, &mut self.rows[first..end], right);
        let steps = &mut self.step[self.moves.clone()];
        for (step, solved) in steps.iter_mut().zip(right) {
            for (axis, value) in self.axes.iter().zip(solved) {
                step[*axis] = *value;
            }
        }
    }

    /// What the step changes at the sites, and how long it may be for slacks and multipliers to stay
    /// positive.
    #[inline(always)]
    fn longest(&mut self, target: f64) -> f64 {
        let mut length = 1.0_f64;
        self.changes.clear();
        for (site, off) in self.sites.iter().zip(&self.offs) {
            let slack = off.missing(site) - dot(off.counted, site.at(&self.step));
            let target = target * self.bending[site.interval - self.part.start];
            let multiplier = (target - site.multiplier * (site.slack + slack)) / site.slack;
            for (value, change) in [(site.slack, slack), (site.multiplier, multiplier)] {
                if change < 0.0 {
                    length = length.min(-STEP_PART * value / change);
                }
            }
            self.changes.push(Change { slack, multiplier });
        }
        length
    }

    /// Moves the coefficients by a step of at most a length; returns how far it went.
    #[inline(always)]
    fn go(&mut self, longest: f64, before: f64) -> f64 {
        let mut length = longest;
        self.start.copy_from_slice(self.coefficients);
        for _ in 0..=MAX_HALVINGS {
            let moved = self.coefficients[self.moves.clone()].iter_mut();
            let starts = &self.start[self.moves.clone()];
            let steps = &self.step[self.moves.clone()];
            for ((coefficient, start), step) in moved.zip(starts).zip(steps) {
                *coefficient = along(*start, *step, length);
            }
            self.fit.bending(
                &self.part,
                self.coefficients,
                &mut self.bending,
                &mut self.bent,
            );
            // A high power rises out of all proportion where a step is too long.
            if B::IS_SQUARE || self.bending.iter().sum::<f64>() <= MOST_RISE * before {
                break;
            }
            length *= 0.5;
        }
        length
    }

    /// Takes the sites along on a step that has been gone.
    #[inline(always)]
    fn follow(&mut self, length: f64) {
        let sites = self.sites.iter_mut().zip(&mut self.offs);
        for ((site, off), change) in sites.zip(&self.changes) {
            site.slack += length * change.slack;
            site.multiplier += length * change.multiplier;
            *off = Off::new(site, self.coefficients);
            // Where there is more room than the slack says, it is taken.
            site.slack += off.missing(site).max(0.0);
        }
    }
}

impl<B: Bending, const N: usize, const M: usize> WithSimd for Descent<'_, B, N, M> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        self.run(simd)
    }
}
