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
mod interior;
mod nominal;
mod tighten;
mod warp;

pub(crate) use nominal::Point;

use crate::{PlannerConfig, Sample};
use interior::{End, Goal, Interior};
use lostmotion_base::{Clock, Tick};
use nominal::{Joint, joints, problem};
use std::collections::VecDeque;
use tighten::Judge;
use warp::{Walk, between};

/// Steps of nominal time in a period of the samples.
const STEPS_IN_PERIOD: u64 = 2;
/// The pace, squared, at which a window ends that is not the last.
const TAIL: f64 = 0.25;
/// What is given out ends at least so many times before the end of its window as the slowest joint takes to stop.
const STOPS: f64 = 2.0;
/// A window by what of it is not given out yet.
const WINDOW: usize = 4;
/// Over how many steps at rest beta is constant.
const TIED: usize = 8;
/// Parts of the limits that are planned.
const PARTS: [f64; 3] = [1.0 - 1e-6, 0.999, 0.998];
/// When a window is good enough.
const GOAL: Goal = Goal { gap: 3e-4, first_gap: 1.0, max_steps: 60 };
/// The same where only some room was taken away.
const AGAIN: Goal = Goal { first_gap: 0.03, ..GOAL };
/// How often room is taken away, at most.
const ROUNDS: usize = 6;

/// Retimes a motion as it comes.
#[derive(Clone, Debug)]
pub(crate) struct Retimer {
    joints: Vec<Joint>,
    step_s: f64,
    /// The nominal motion that is not given out yet.
    points: Vec<Point>,
    /// Coefficients of beta over it, as far as it was planned.
    x: Vec<f64>,
    /// Intervals that a window keeps back.
    margin: usize,
    /// Whether the points start at rest.
    at_rest: bool,
    walk: Walk,
    solver: Interior,
    tick: Tick,
    ready: VecDeque<Sample>,
    batch: Vec<(usize, Sample)>,
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
            joints,
            step_s,
            points: Vec::new(),
            x: Vec::new(),
            margin: ((STOPS * stop_s / step_s).ceil() as usize).max(4 * TIED),
            at_rest: true,
            walk: Walk { ahead_s: 0.0, period_s: config.clock.period_s() },
            solver: Interior::default(),
            tick: 0,
            ready: VecDeque::new(),
            batch: Vec::new(),
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
        self.name(between(&[last, last], self.step_s, 0.0, [1.0, 0.0]));
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

    /// Plans all that is there; what is checked and given out are the first `given` intervals.
    fn plan(&mut self, ends: [End; 2], given: usize) {
        let intervals = self.points.len() - 1;
        let mut room = vec![[1.0; 2]; intervals];
        self.x.resize(intervals + 2, TAIL);
        let mut goal = GOAL;
        let mut walk = self.walk;
        for round in 0..=ROUNDS {
            let problem = problem(&self.points, &self.joints, self.step_s, &room, ends);
            let outcome = self.solver.solve(&problem, &mut self.x, &goal);
            goal = AGAIN;
            walk = self.walk;
            self.batch.clear();
            walk.go(&self.points[..=given], self.step_s, &self.x[..given + 2], &mut self.batch);
            let found = self.judge.tighten(&self.batch, &mut room);
            if std::env::var("TRACE").is_ok() { println!("window {intervals} round {round} {outcome:?} over {found:?}"); }
            if found <= 0.0 {
                break;
            }
        }
        self.walk = walk;
        self.judge.pass(&self.batch);
        for (_, sample) in std::mem::take(&mut self.batch) {
            self.name(sample);
        }
        self.points.drain(..given);
        self.x.drain(..given);
        self.at_rest = false;
    }

    fn name(&mut self, sample: Sample) {
        self.ready.push_back(Sample { tick: self.tick, ..sample });
        self.tick += 1;
    }
}
