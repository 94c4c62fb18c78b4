//! Quality `optimal`: the whole motion of all joints retimed to nearly the least time.
//!
//! The motion that the look-ahead planned is taken as nominal: every joint as a function p of a nominal time sigma. Sought is the pace
//! d sigma / dt, by its square beta over sigma. Since p comes to rest where the motion does, beta has no singularity there, and corners
//! that are rounded in time, dwells and kinematics are all in p. [`nominal`] makes the limits of beta, [`interior`] lowers the time,
//! [`warp`] makes samples of it.
//!
//! Windows overlap: each starts in the state in which the last one was left and ends at a part of the nominal pace, at which everything
//! that may come keeps its limits. What is given out lies far enough before that end not to feel it.

mod banded;
mod ends;
mod interior;
mod nominal;
mod problem;
mod settle;
mod tighten;
mod trial;
mod warp;

pub(crate) use nominal::Point;
pub(crate) use warp::{between, quintic};

use crate::{PlannerConfig, Sample};
use ends::End;
use interior::{Goal, Interior};
use lostmotion_base::{AXES, AxisLimits, Clock, Tick};
use nominal::{Joint, joints, limits};
use problem::Problem;
use std::collections::VecDeque;
use tighten::{Judge, REACH};
use trial::Trial;
use warp::Walk;

/// Steps of nominal time in a period of the samples.
const STEPS_IN_PERIOD: u64 = 2;
/// The pace, squared, at which a window ends that is not the last.
const TAIL: f64 = 0.25;
/// Part of the nominal limits at that pace that is used, so that some room is left.
const LOOSE: f64 = 0.9;
/// What is given out ends at least so many times before the end of its window as the slowest joint takes to stop.
const STOPS: f64 = 2.0;
/// A window by what of it is not given out yet.
const WINDOW: usize = 4;
/// Over how many steps at rest beta is constant.
const TIED: usize = 8;
/// Parts of the limits that are planned: within an interval the jerk passes its middle's a little where the path is tightly curved.
const PARTS: [f64; 3] = [1.0 - 1e-6, 0.999, 0.982];
/// When a window is good enough.
const GOAL: Goal = Goal { gap: 3e-4, first_gap: 1.0, max_steps: 60 };
/// The same where only some room was taken away.
const AGAIN: Goal = Goal { first_gap: 0.03, ..GOAL };
/// How often room is taken away, at most, and while a limit is passed by how much.
const ROUNDS: usize = 10;
const COARSE: f64 = 8e-4;
/// Where less than this part of a limit is left to an interval after all, the pace of the window's end may be better for all of it.
const TOLERABLE: f64 = 0.9985;
/// How often the pace is lowered around what still passes a limit.
const DIPS: usize = 24;
/// By how much that may lengthen what is given out, at most.
const LONGER: f64 = 1.01;
/// A gap that is not below this means that no better motion was found.
const FAILED: f64 = 0.05;
/// Intervals at the start of a window in which its given state leaves little choice, so that what was planned before may be done again.
const GIVEN: usize = 60;

/// Limits that the nominal motion has to keep where it will be retimed: what it keeps of velocity, acceleration and jerk at the pace at which
/// windows end.
pub(crate) fn loosened(limits: &[Option<AxisLimits>; AXES]) -> [Option<AxisLimits>; AXES] {
    let pace = TAIL.sqrt() / LOOSE;
    limits.map(|limits| {
        limits.map(|l| AxisLimits {
            velocity: l.velocity / pace,
            acceleration: l.acceleration / (pace * pace),
            jerk: l.jerk / (pace * pace * pace),
            ..l
        })
    })
}

/// Retimes a motion as it comes.
#[derive(Clone, Debug)]
pub(crate) struct Retimer {
    joints: Vec<Joint>,
    step_s: f64,
    /// The nominal motion that is not given out yet.
    points: Vec<Point>,
    /// Coefficients of beta over it, as far as it was planned.
    x: Vec<f64>,
    /// Room that the joints' limits leave by interval: acceleration, jerk.
    room: Vec<[f64; 2]>,
    /// How wide the pace is lowered around what passes a limit, in steps.
    width: f64,
    /// Intervals that a window keeps back.
    margin: usize,
    /// Whether the points start at rest.
    at_rest: bool,
    walk: Walk,
    solver: Interior,
    tick: Tick,
    ready: VecDeque<Sample>,
    judge: Judge,
}

/// The clock of the nominal motion.
pub(crate) fn nominal_clock(clock: Clock) -> Clock {
    Clock::from_nanos(clock.period_ns() / STEPS_IN_PERIOD).unwrap_or(clock)
}

impl Retimer {
    pub(crate) fn new(config: &PlannerConfig) -> Retimer {
        let joints = joints(&config.limits, PARTS);
        let step_s = nominal_clock(config.clock).period_s();
        let stop_s = joints.iter().map(|joint| joint.limits[0] / joint.limits[1] + joint.limits[1] / joint.limits[2]).fold(0.0, f64::max);
        Retimer {
            width: settle::width(joints.iter().map(|joint| joint.limits), step_s),
            joints,
            step_s,
            points: Vec::new(),
            x: Vec::new(),
            room: Vec::new(),
            margin: ((STOPS * stop_s / step_s).ceil() as usize).max(4 * TIED),
            at_rest: true,
            walk: Walk { ahead_s: 0.0, period_s: config.clock.period_s() },
            solver: Interior::default(),
            tick: 0,
            ready: VecDeque::new(),
            judge: Judge::new(config),
        }
    }

    /// Adds a step of the nominal motion.
    pub(crate) fn push(&mut self, point: Point) {
        self.points.push(point);
        if self.points.len() > WINDOW * self.margin {
            self.plan([self.start(), End::Moving], self.points.len() - 1 - self.margin);
        }
    }

    /// Ends the motion at rest; false if it has ended before.
    pub(crate) fn finish(&mut self) -> bool {
        let Some(last) = self.points.last().copied() else { return false };
        let intervals = self.points.len() - 1;
        if intervals > 0 {
            self.plan([self.start(), End::Rest(TIED.min(intervals / 4))], intervals);
        }
        self.name(between([&last.sample; 2], self.step_s, 0.0, [1.0, 0.0]));
        self.points.clear();
        true
    }

    /// The next sample that is final.
    pub(crate) fn next(&mut self) -> Option<Sample> {
        self.ready.pop_front()
    }

    fn start(&self) -> End {
        if self.at_rest { End::Rest(TIED.min(self.points.len() / 4)) } else { End::Moving }
    }

    /// Plans all that is there and gives out the first `given` intervals.
    fn plan(&mut self, ends: [End; 2], given: usize) {
        let intervals = self.points.len() - 1;
        self.room.resize(intervals, [1.0; 2]);
        let mut problem = limits(&self.points, &self.joints, self.step_s, &self.room, ends);
        let known = self.x.clone();
        let overlap = known.len().saturating_sub(2);
        problem.ease(overlap, &known);
        self.x.resize(intervals + 2, TAIL);
        let slow = self.x.clone();
        let mut trial = self.improve(&problem, &GOAL, ends[1], given);
        for _ in 0..ROUNDS {
            if trial.least() > 1.0 - COARSE || !trial.found {
                break;
            }
            for (interval, scale) in &trial.excess {
                problem.tighten(*interval, *scale);
                self.room[*interval] = [self.room[*interval][0] * scale[0], self.room[*interval][1] * scale[1]];
            }
            problem.ease(GIVEN.min(overlap), &known);
            trial = self.improve(&problem, &AGAIN, ends[1], given);
        }
        if trial.least() < TOLERABLE {
            let found = std::mem::replace(&mut self.x, slow);
            let other = self.trial(ends[1], given, true);
            if other.least() > trial.least() {
                trial = other;
            } else {
                self.x = found;
            }
        }
        let trial = self.settle(trial, ends, given);
        self.give(trial, given);
    }

    /// Lowers the pace where a limit is still passed by a little, if that does it and takes hardly longer.
    fn settle(&mut self, first: Trial, ends: [End; 2], given: usize) -> Trial {
        if first.excess.is_empty() {
            return first;
        }
        let found = self.x.clone();
        settle::dip(&mut self.x, &first.excess, self.width, ends);
        for _ in 0..DIPS {
            let trial = self.trial(ends[1], given, true);
            if trial.samples.len() as f64 > LONGER * first.samples.len() as f64 + 1.0 {
                break;
            }
            if trial.excess.is_empty() {
                return trial;
            }
            settle::dip(&mut self.x, &trial.excess, self.width, ends);
        }
        self.x = found;
        first
    }

    /// Lowers the time, if that can be done, and looks at what comes of it.
    fn improve(&mut self, problem: &Problem, goal: &Goal, end: End, given: usize) -> Trial {
        let before = self.x.clone();
        let found = self.solver.solve(problem, &mut self.x, goal) < FAILED;
        if !found {
            self.x = before;
        }
        self.trial(end, given, found)
    }

    /// The samples of the first `given` intervals, and what of the limits they and all that is planned pass.
    fn trial(&self, end: End, given: usize, found: bool) -> Trial {
        let intervals = self.points.len() - 1;
        let (mut walk, mut samples) = (self.walk, Vec::new());
        walk.go(&self.points[..=given], self.step_s, &self.x[..given + 2], &mut samples);
        let mut more = samples.clone();
        let mut beyond = walk;
        beyond.go(&self.points[given..], self.step_s, &self.x[given..], &mut more);
        more[samples.len()..].iter_mut().for_each(|(interval, _)| *interval += given);
        if let (End::Rest(_), Some(last)) = (end, self.points.last()) {
            more.extend([(intervals - 1, last.sample); REACH]);
        }
        Trial { excess: self.judge.excess(&more, intervals), samples, walk, found }
    }

    fn give(&mut self, trial: Trial, given: usize) {
        self.walk = trial.walk;
        self.judge.pass(&trial.samples);
        trial.samples.into_iter().for_each(|(_, sample)| self.name(sample));
        self.points.drain(..given);
        self.x.drain(..given);
        self.room.drain(..given);
        self.at_rest = false;
    }

    fn name(&mut self, sample: Sample) {
        self.ready.push_back(Sample { tick: self.tick, ..sample });
        self.tick += 1;
    }
}
