//! The fastest curve inside the tube: from side to side, and faster and slower along it.
//!
//! The smoothest curve at a steady pace leaves the limits of the joints unused. This one is found as
//! a motion: a cubic spline of the time, so that its third derivative is the jerk. The sum of a high
//! power of every joint's jerk, in units of its limit, is made least inside the tube, where the curve
//! may also slide along its lines; then each stretch is given more time where that is worth more, and
//! the motion is found again. What is left of it is its shape and its parameter: the plan gives it the
//! time. It is looked for where the steady curve is slower than the feed ([`slow`]).

mod jerks;
mod slow;
mod times;

use super::fit::{Fit, Rail, Site};
use super::paced::Paced;
use super::passage::passed;
use super::spline::Breaks;
use super::way::Way;
use super::{AIMED_PART, Cubic, MAX_NARROWINGS, Tie};
use jerks::Jerks;
use lostmotion_base::math;
use lostmotion_base::vec::{Vec3, along, dot, norm, scale};
use lostmotion_path::HermiteEnd;
pub(super) use slow::busy;
use slow::{Slowness, fed, paced, passed_s};

/// How long the steady curve takes, s.
#[derive(Clone, Copy, Debug)]
struct SteadyTimes {
    /// At the pace that it allows.
    paced_s: f64,
    /// At the feed alone.
    fed_s: f64,
}

/// A joint on a straight way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinearJoint {
    /// How far it moves for each mm along X, Y and Z.
    pub(crate) per_mm: Vec3,
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    pub(crate) jerk: f64,
}

/// Width of an interval, in units of the time in which jerk alone goes as far as the tolerance. A
/// choice: corners take six to twelve of these units, and eight intervals a corner come within 1 % of
/// many.
const INTERVAL: f64 = 0.8;
/// Bounds of the number of intervals: a shorter section is over before the motion is at a limit (a
/// choice), and memory is bounded.
const LEAST_INTERVALS: usize = 8;
const MAX_INTERVALS: usize = 2048;
/// Least time, as a part of that which the feed alone takes, from which on a motion is looked for. A
/// choice: a plan is that near to its feed anyway.
const LEAST_OVER_FEED: f64 = 1.04;
/// How roughly a motion is found the first time, where all that follows is that its times are set. A choice,
/// as the others below: with 15 single motions get 1 to 10 % slower.
const FIRST_ROUGH: f64 = 10.0;
/// The same once its times have been set. A choice: with 6 more motions are given up that would be faster.
const TIMED_ROUGH: f64 = 5.0;
/// Half of the powers with which it is found at last, each from the one before, and how roughly: the
/// higher the power, the nearer the largest jerk is to the mean, and the fewer the steps of Newton's
/// method that are too long. A choice.
const HALF_POWERS: [(u32, f64); 3] = [(3, 10.0), (4, 10.0), (6, LAST_ROUGH)];
/// How roughly the last of them is found, also where the tube is narrowed. A choice: with 1 times are the
/// same on average, and more of the motions are narrowed in vain.
const LAST_ROUGH: f64 = 2.0;
/// Half of the power with which the times are found before.
const TIMED_HALF_POWER: u32 = 2;
/// How often the times are set anew. A choice: a third time changes no time by more than 0.5 %.
const RETIMINGS: usize = 2;
/// Part of the time that jerk asks for along the steady curve that a motion begins with. A choice: one that
/// begins too slow runs beyond corners and back to spend its time, one that begins too fast gets
/// the time that it needs.
const HURRY: f64 = 0.5;
/// Part of the time at the pace that the steady curve allows that the motion has to keep to. A choice:
/// nearer to that the plan is as often slower as faster.
const MOST_PART: f64 = 0.98;
/// Sites in each interval, besides the corners. A choice, as at a steady pace.
const SITES: usize = 2;

/// The motion as it is found.
#[derive(Debug)]
struct Motion<'a, 'b> {
    way: &'b Way<'a>,
    ties: [Tie; 2],
    joints: &'b [LinearJoint],
    jerks: Jerks,
    breaks: Breaks,
    coefficients: Vec<Vec3>,
    /// When each vertex of the way is passed.
    passed: Vec<f64>,
    /// Where the way leads to past each vertex, of unit length.
    ahead: Vec<Vec3>,
    /// Where the curve leads to there, of unit length.
    directions: Vec<Vec3>,
}

/// The fastest curve along a way, from one that was found at a steady pace, with the speeds at its
/// breaks; `None` where that is proven and about as fast.
pub(super) fn curve<'a>(
    way: &Way<'a>,
    ties: [Tie; 2],
    steady: (&Breaks, &[HermiteEnd]),
    joints: &[LinearJoint],
    is_proven: bool,
) -> Option<(Paced<'a>, Vec<f64>)> {
    let (mut motion, steady) = Motion::new(way, ties, steady, joints)?;
    // Where the feed is the limit there is nothing to gain.
    if is_proven && steady.paced_s < LEAST_OVER_FEED * steady.fed_s {
        return None;
    }
    let needs_over =
        |motion: &Motion<'_, '_>, part| is_proven && motion.needed_s() > part * steady.paced_s;
    let mut sites = motion.sites();
    motion.solve(&mut sites, FIRST_ROUGH);
    for _ in 0..RETIMINGS {
        motion.pass();
        motion.retime(&sites);
        sites = motion.sites();
        motion.solve(&mut sites, TIMED_ROUGH);
    }
    // With higher powers some need some hundredths less, most of them with the first one.
    if needs_over(&motion, 1.0) {
        return None;
    }
    for (half_power, rough) in HALF_POWERS {
        motion.jerks.half_power = half_power;
        // What was found may pass the places at other times.
        motion.pass();
        sites = motion.sites();
        motion.solve(&mut sites, rough);
        if needs_over(&motion, MOST_PART) {
            return None;
        }
    }
    motion.pass();
    for round in 0..MAX_NARROWINGS {
        let states = motion.breaks.states(&motion.coefficients);
        let paced = Paced::new(way, &ties, (&motion.breaks, &states), &motion.passed)?;
        let excess = paced.excess()?;
        if excess.is_none() {
            let part = 1.0 / motion.longer();
            let speeds = states.iter().map(|state| part * norm(state.d1.linear()));
            return Some((paced, speeds.collect()));
        }
        excess.narrow(&mut sites, round, |k, vertex| {
            let radius = AIMED_PART * way.vertex_tolerance(vertex);
            Site::new(
                &motion.breaks,
                k,
                motion.passed[vertex],
                way.vertex(vertex),
                radius,
            )
            .sliding(motion.directions[vertex])
        });
        // A fit that does not settle may still be inside the tube; one that does not again will not.
        if !motion.solve(&mut sites, LAST_ROUGH) && round > 1 {
            return None;
        }
        motion.pass();
    }
    None
}

impl<'a, 'b> Motion<'a, 'b> {
    /// A motion along a curve to begin with, and how long the curve takes.
    fn new(
        way: &'b Way<'a>,
        ties: [Tie; 2],
        (breaks, states): (&Breaks, &[HermiteEnd]),
        joints: &'b [LinearJoint],
    ) -> Option<(Motion<'a, 'b>, SteadyTimes)> {
        let slowness = Slowness::along(way, (breaks, states), joints);
        let last = breaks.intervals();
        let steady = SteadyTimes {
            paced_s: passed_s(breaks, &paced(&slowness, 1.0, true))[last],
            fed_s: passed_s(breaks, &fed(&slowness))[last],
        };
        let times = passed_s(breaks, &paced(&slowness, HURRY, true));
        let jerk = joints
            .iter()
            .map(|joint| norm(joint.per_mm) / joint.jerk)
            .fold(0.0, f64::max);
        let width = INTERVAL * math::cbrt(way.least_tolerance() * jerk);
        let count = (steady.paced_s / width).ceil();
        if !(LEAST_INTERVALS as f64..=MAX_INTERVALS as f64).contains(&count) {
            return None;
        }
        let count = count as usize;
        let by_time = Breaks::even(times[last], count);
        let sampled = transferred(states, breaks, &times, &by_time);
        let mut passed = Interpolated::new(&breaks.0, &times);
        let passed = way.parameters().iter().map(|w| passed.at(*w)).collect();
        let ahead: Vec<Vec3> = (0..=way.legs()).map(|k| way.passing(k)).collect();
        let motion = Motion {
            way,
            ties,
            joints,
            jerks: Jerks::new(joints, TIMED_HALF_POWER),
            breaks: by_time,
            coefficients: sampled,
            passed,
            directions: ahead.clone(),
            ahead,
        };
        Some((motion, steady))
    }

    /// Finds when each vertex is passed, and where the curve leads to there.
    fn pass(&mut self) {
        let states = self.breaks.states(&self.coefficients);
        self.passed = passed(
            self.way,
            (&self.breaks, &states),
            |vertex| self.ahead[vertex],
            &self.passed,
            |vertex, direction| self.directions[vertex] = direction,
        );
    }

    /// Where the curve has to be near the way.
    fn sites(&self) -> Vec<Site> {
        let mut sites = Vec::with_capacity(2 * SITES * self.breaks.intervals());
        let mut passed = Interpolated::new(&self.passed, self.way.parameters());
        let mut walk = self.way.walk();
        for (k, t) in self.breaks.0.windows(2).enumerate() {
            for part in 0..SITES {
                let t = t[0] + (t[1] - t[0]) * ((part as f64 + 0.5) / SITES as f64);
                let at = walk.to(passed.at(t));
                let radius = AIMED_PART * at.tolerance();
                sites.push(Site::new(&self.breaks, k, t, at.place(), radius).sliding(at.heading()));
            }
        }
        let last = *self.breaks.0.last().unwrap_or(&0.0);
        for &vertex in self.way.inner_corners() {
            let t = self.passed[vertex];
            if t > 0.0 && t < last {
                let radius = AIMED_PART * self.way.vertex_tolerance(vertex);
                let k = self.breaks.interval(t);
                let site = Site::new(&self.breaks, k, t, self.way.vertex(vertex), radius);
                // When it is passed is open.
                sites.push(site.sliding(self.directions[vertex]));
            }
        }
        sites.sort_by(|a, b| a.w.total_cmp(&b.w));
        sites
    }

    /// Finds the motion inside the tube; returns whether it settled.
    fn solve(&mut self, sites: &mut [Site], rough: f64) -> bool {
        let count = self.coefficients.len();
        let fit = Fit::new(&self.breaks, &self.jerks, 1..count - 1)
            .on_rails(self.rails())
            .roughly(rough);
        let settled = fit.solve(&mut self.coefficients, sites);
        for rail in self.rails() {
            rail.put_on(&mut self.coefficients);
        }
        settled
    }

    /// The ends where direction and curvature are given, and the pace is not.
    fn rails(&self) -> Vec<Rail> {
        let count = self.coefficients.len();
        let ends = [
            (self.breaks.first_widths(), [0, 1, 2]),
            (self.breaks.last_widths(), [count - 1, count - 2, count - 3]),
        ];
        let mut rails = Vec::new();
        for (tie, (widths, [at, next, third])) in self.ties.iter().zip(ends) {
            let (Tie::State(state), Some([h, g])) = (tie, widths) else {
                continue;
            };
            let (d1, d2) = (state.d1.linear(), state.d2.linear());
            let square = dot(d1, d1);
            let direction = scale(d1, 1.0 / square.sqrt());
            let bend = scale(along(d2, direction, -dot(d2, direction)), 1.0 / square);
            rails.push(Rail {
                next,
                third,
                place: self.coefficients[at],
                direction,
                // The next one is h/3 of the pace ahead, and what bends aside is the square of the pace.
                aside: scale(bend, 1.5 * (h + g) / h),
            });
        }
        rails
    }
}

/// Coefficients on other breaks of a curve given by its states at breaks and the times there.
fn transferred(states: &[HermiteEnd], breaks: &Breaks, times: &[f64], to: &Breaks) -> Vec<Vec3> {
    let count = to.coefficients();
    let mut coefficients: Vec<Vec3> = (0..count)
        .map(|j| {
            let t = to.greville(j);
            let k = times
                .partition_point(|time| *time <= t)
                .clamp(1, breaks.intervals())
                - 1;
            let width = breaks.0[k + 1] - breaks.0[k];
            // How fast the parameter goes.
            let rate = width / (times[k + 1] - times[k]);
            let x = (t - times[k]) * rate;
            let cubic = Cubic::new(&states[k], &states[k + 1], width);
            let second = along(cubic.d2, cubic.d3, x);
            // The blossom of what the curve is nearby.
            let [a, b, c] = to.knots(j).map(|knot| (knot - t) * rate);
            let (pairs, all) = ((a * b + b * c + c * a) / 6.0, a * b * c / 6.0);
            along(along(cubic.at(x).p, second, pairs), cubic.d3, all)
        })
        .collect();
    coefficients[0] = states[0].p.linear();
    coefficients[count - 1] = states[breaks.intervals()].p.linear();
    coefficients
}

/// The largest of the values around each.
fn largest(values: &[f64], around: usize) -> Vec<f64> {
    (0..values.len())
        .map(|k| {
            values[k.saturating_sub(around)..(k + around + 1).min(values.len())]
                .iter()
                .copied()
                .fold(0.0, f64::max)
        })
        .collect()
}

/// The mean of the values around each.
fn averaged(values: &[f64], around: usize) -> Vec<f64> {
    (0..values.len())
        .map(|k| {
            let these = &values[k.saturating_sub(around)..(k + around + 1).min(values.len())];
            these.iter().sum::<f64>() / these.len() as f64
        })
        .collect()
}

/// Values between those at rising places, asked for one after the other.
struct Interpolated<'a> {
    places: &'a [f64],
    values: &'a [f64],
    /// The place that ends the stretch.
    end: usize,
}

impl<'a> Interpolated<'a> {
    fn new(places: &'a [f64], values: &'a [f64]) -> Interpolated<'a> {
        Interpolated {
            places,
            values,
            end: 1,
        }
    }

    /// The value at a place that does not lie before the last one.
    fn at(&mut self, at: f64) -> f64 {
        while self.end + 1 < self.places.len() && self.places[self.end] <= at {
            self.end += 1;
        }
        let k = self.end;
        let span = self.places[k] - self.places[k - 1];
        let part = if span > 0.0 {
            ((at - self.places[k - 1]) / span).clamp(0.0, 1.0)
        } else {
            1.0
        };
        self.values[k - 1] + (self.values[k] - self.values[k - 1]) * part
    }
}
