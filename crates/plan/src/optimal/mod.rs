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
const OTHER_CUTS: [f64; 5] = [0.75, 0.5, 0.875, 0.625, 0.25];
/// Part of a limit that a window may pass: beyond that another cut is tried. A choice: a third of what a plan may
/// take beyond that of `fast`.
const MOST_BEYOND: f64 = 1e-4;
/// The same where a motion takes the place of one in which nothing better was found, which loses more than that
/// passes.
const FOUND_BEYOND: f64 = 1e-3;
/// Part of the time of two windows that keeping a limit may cost. A choice: some samples.
const MENDED_LONGER: f64 = 2e-3;
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
    /// The largest part of a limit that they pass; none where nothing better was found than what stands in.
    beyond: Option<f64>,
}

impl Outcome {
    /// Whether it is faster than what stands in for it, and keeps limits.
    fn is_good(&self) -> bool {
        self.beyond.is_some_and(|beyond| beyond <= MOST_BEYOND)
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
        if !now.trial.is_good()
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
    let beyond = trial.beyond(given);
    Outcome {
        samples: windows.give(trial, given),
        beyond,
    }
}

/// The last window and this one with another cut between them: the first with which both are good, or the one that
/// passes limits least. They take no longer than as they are, or hardly where they keep limits that were passed.
fn cut_elsewhere(last: &Last, now: &Last, end: End) -> Option<(Windows, Last, Last)> {
    let before = last.trial.samples.len() + now.trial.samples.len();
    let (mut least, longest) = match now.trial.beyond {
        Some(beyond) => (beyond, (1.0 + MENDED_LONGER) * before as f64),
        None => (FOUND_BEYOND, before as f64),
    };
    let mut best = None;
    for part in OTHER_CUTS {
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
        let (Some(one), Some(other)) = (first.trial.beyond, second.trial.beyond) else {
            continue;
        };
        let beyond = one.max(other);
        let taken = first.trial.samples.len() + second.trial.samples.len();
        if beyond < least && taken as f64 <= longest {
            least = beyond;
            best = Some((windows, first, second));
            if beyond <= MOST_BEYOND {
                break;
            }
        }
    }
    best
}
