//! Quality `optimal`: the whole motion of all joints retimed to nearly the least time.
//!
//! The motion that the look-ahead planned is taken as nominal: every joint as a function p of a
//! nominal time sigma. Sought is the pace d sigma / dt, by its square beta over sigma. Since p
//! comes to rest where the motion does, beta has no singularity there, and corners that are rounded
//! in time, dwells and kinematics are all in p. [`problem`] makes the limits of beta, [`interior`]
//! lowers the time, [`warp`] makes samples of it.
//!
//! Windows overlap: each starts in the state in which the last one was left and ends at a part of
//! the nominal pace, at which everything that may come keeps its limits. Only samples far enough
//! before that end not to depend on it are output.

mod banded;
mod excess;
mod interior;
mod problem;
mod warp;
mod windows;

pub(crate) use excess::LimitJudge;
pub(crate) use problem::{End, LimitedJoint, joints, stop_s};
pub(crate) use warp::{Placed, between, quintic};
pub(crate) use windows::{Trial, Windows};

use crate::{PlannerConfig, Sample};
use lostmotion_base::{AXES, AxisLimits, Clock, Tick};
use std::collections::VecDeque;

/// Steps of nominal time in a period of the samples. A choice: more follow the jerk within a sample
/// better and cost time in proportion.
const STEPS_IN_PERIOD: u64 = 2;
/// Square of the pace at which a window ends that is not the last. A choice: half of the nominal
/// pace, at which velocity, acceleration and jerk take 1/2, 1/4 and 1/8.
const TAIL_BETA: f64 = 0.25;
/// Part of the nominal limits that is used at that pace, so that some room is left. A choice: less
/// slows the windows' ends, more leaves no room.
const TAIL_ROOM: f64 = 0.9;
/// Length of a window in margins held back. A choice: three quarters of each window are output;
/// longer windows cost memory, shorter ones plan more twice.
const WINDOW_MARGINS: usize = 4;

/// The pace at which windows end, and a little more.
pub(crate) fn end_pace() -> f64 {
    TAIL_BETA.sqrt() / TAIL_ROOM
}

/// Limits that the nominal motion has to keep where it will be retimed: what it keeps of velocity,
/// acceleration and jerk at the pace at which windows end.
pub(crate) fn loosened(limits: &[Option<AxisLimits>; AXES]) -> [Option<AxisLimits>; AXES] {
    let pace = end_pace();
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
    windows: Windows,
    step_s: f64,
    /// Whether the points start at rest.
    at_rest: bool,
    tick: Tick,
    ready: VecDeque<Sample>,
}

/// The clock of the nominal motion.
pub(crate) fn nominal_clock(clock: Clock) -> Clock {
    Clock::from_nanos(clock.period_ns() / STEPS_IN_PERIOD).unwrap_or(clock)
}

impl Retimer {
    pub(crate) fn new(config: &PlannerConfig) -> Retimer {
        let clock = nominal_clock(config.clock);
        let windows = Windows::new(config, clock, TAIL_BETA, true);
        Retimer {
            windows,
            step_s: clock.period_s(),
            at_rest: true,
            tick: 0,
            ready: VecDeque::new(),
        }
    }

    /// Adds a step of the nominal motion.
    pub(crate) fn push(&mut self, point: Sample) {
        let windows = &mut self.windows;
        windows.points.push(point);
        if windows.points.len() > WINDOW_MARGINS * windows.margin {
            let given = windows.points.len() - 1 - windows.margin;
            self.plan(End::Moving, given);
        }
    }

    /// Ends the motion at rest; false if it has ended before.
    pub(crate) fn finish(&mut self) -> bool {
        let Some(last) = self.windows.points.last().copied() else {
            return false;
        };
        let intervals = self.windows.points.len() - 1;
        if intervals > 0 {
            self.plan(Windows::rest(intervals), intervals);
        }
        self.name(between([&last; 2], self.step_s, 0.0, [1.0, 0.0]));
        self.windows.points.clear();
        true
    }

    /// How many windows were output in which nothing better was found.
    pub(crate) fn kept(&self) -> u64 {
        self.windows.kept
    }

    /// How many samples are held.
    pub(crate) fn held(&self) -> usize {
        self.windows.points.len() + self.ready.len()
    }

    /// The next sample that is final.
    pub(crate) fn next(&mut self) -> Option<Sample> {
        self.ready.pop_front()
    }

    fn plan(&mut self, end: End, given: usize) {
        let windows = &mut self.windows;
        let start = if self.at_rest {
            Windows::rest(windows.points.len())
        } else {
            End::Moving
        };
        let trial = windows.best([start, end], given, windows.known().saturating_sub(2));
        for placed in windows.give(trial, given) {
            self.name(placed.sample);
        }
        self.at_rest = false;
    }

    fn name(&mut self, sample: Sample) {
        self.ready.push_back(Sample {
            tick: self.tick,
            ..sample
        });
        self.tick += 1;
    }
}
