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
/// Parts of what the last window output that it outputs instead where nothing better than the nominal pace is
/// found behind it, or what is found passes a limit, one after the other. A choice: a window that begins just
/// before a corner, whose samples the one before has shifted, begins well before it then.
const OTHER_CUTS: [f64; 4] = [0.75, 0.5, 0.875, 0.625];
/// Part of a limit that a window has to pass for another cut to be tried, and that neither may pass with it where
/// that was the cause. A choice: a window that is not mended passes one by up to 0.1 %.
const BAD_BEYOND: f64 = 1.5e-3;
const GOOD_BEYOND: f64 = 2e-4;
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
    /// The last window, while the next one may ask for another cut.
    last: Option<Box<Last>>,
    tick: Tick,
    ready: VecDeque<Sample>,
}

/// A window that has been planned: what it began with, and what it outputs.
#[derive(Clone, Debug)]
struct Last {
    before: Windows,
    start: End,
    given: usize,
    trial: Outcome,
}

/// What planning a window led to.
#[derive(Clone, Debug)]
struct Outcome {
    samples: Vec<Placed>,
    /// The least part of a limit that is left to an interval of them; none where nothing better was found than
    /// what stands in.
    least: Option<f64>,
}

impl Outcome {
    /// Whether it is faster than what stands in for it, and passes limits by no more than this part.
    fn is_good(&self, beyond: f64) -> bool {
        self.least.is_some_and(|least| least >= 1.0 - beyond)
    }
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
            last: None,
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
        self.output();
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
        let last = self.last.as_ref().map_or(0, |last| {
            last.before.points.len() + last.trial.samples.len()
        });
        self.windows.points.len() + last + self.ready.len()
    }

    /// The next sample that is final.
    pub(crate) fn next(&mut self) -> Option<Sample> {
        self.ready.pop_front()
    }

    fn plan(&mut self, end: End, given: usize) {
        let start = if self.at_rest {
            Windows::rest(self.windows.points.len())
        } else {
            End::Moving
        };
        let mut now = Last {
            before: self.windows.clone(),
            start,
            given,
            trial: take(&mut self.windows, [start, end], given),
        };
        if !now.trial.is_good(BAD_BEYOND)
            && let Some(last) = &self.last
            && let Some((windows, first, second)) = cut_elsewhere(last, &now, end)
        {
            self.windows = windows;
            self.last = Some(Box::new(first));
            now = second;
        }
        self.output();
        self.last = Some(Box::new(now));
        self.at_rest = false;
    }

    /// Outputs the last window.
    fn output(&mut self) {
        let last = self.last.take();
        for placed in last.into_iter().flat_map(|last| last.trial.samples) {
            self.name(placed.sample);
        }
    }

    fn name(&mut self, sample: Sample) {
        self.ready.push_back(Sample {
            tick: self.tick,
            ..sample
        });
        self.tick += 1;
    }
}

/// Plans a window and takes what it outputs off its points.
fn take(windows: &mut Windows, ends: [End; 2], given: usize) -> Outcome {
    let trial = windows.best(ends, given, windows.known().saturating_sub(2));
    let least = trial.kept_limits(given);
    Outcome {
        samples: windows.give(trial, given),
        least,
    }
}

/// The last window and this one with another cut between them, if both are good then and take less time, or keep
/// limits that they passed.
fn cut_elsewhere(last: &Last, now: &Last, end: End) -> Option<(Windows, Last, Last)> {
    let before = last.trial.samples.len() + now.trial.samples.len();
    // what passes a limit has to be mended by it; what stands in loses more than a solution passes
    let beyond = if now.trial.least.is_some() {
        GOOD_BEYOND
    } else {
        BAD_BEYOND
    };
    OTHER_CUTS.into_iter().find_map(|part| {
        let mut windows = last.before.clone();
        // all that is known by now
        windows.points.truncate(last.given);
        windows.points.extend_from_slice(&now.before.points);
        let given = (part * last.given as f64) as usize;
        let first = Last {
            before: windows.clone(),
            start: last.start,
            given,
            trial: take(&mut windows, [last.start, End::Moving], given),
        };
        let left = last.given - given + now.given;
        let second = Last {
            before: windows.clone(),
            start: End::Moving,
            given: left,
            trial: take(&mut windows, [End::Moving, end], left),
        };
        let is_good = [&first, &second]
            .iter()
            .all(|window| window.trial.is_good(beyond));
        let taken = first.trial.samples.len() + second.trial.samples.len();
        (is_good && taken <= before).then_some((windows, first, second))
    })
}
