//! A pace that changes all along: feeds above the programmed ones, and overrides that do not hold
//! for all that is ahead.
//!
//! The plan is taken as nominal motion and retimed window by window, as quality `optimal` does it,
//! from the state of motion that is. Each window ends at a steady pace that is within all limits
//! and all that is asked, so that there is always a way on.

use super::action::Asked;
use super::course::{Course, PaceState};
use crate::optimal::{End, Placed, Trial, Windows};
use crate::{Heeds, PlannerConfig, Sample};
use lostmotion_base::{Clock, Coords};
use std::collections::VecDeque;

/// Part of a limit by which the first window may pass it. A choice: half of the excess that makes
/// another round (`ROUND_EXCESS`).
pub(super) const SEAM_EXCESS: f64 = 4e-4;
/// Intervals that may go on at a steady pace as before, although they are at their limits. A
/// choice: as many as are eased again in a window (`EASED_AGAIN`).
const EASED_STEADY: usize = 60;
/// The same for a pace that changes. A choice: about the reach of the given coefficients.
const EASED_CHANGING: usize = 3;
/// Largest pace, however slow the plan is. A choice: twice the largest override (200 %).
pub(super) const MOST_PACE: f64 = 4.0;
/// Least pace from which a pace that changes all along sets out; below it a steady one comes first.
/// A choice: below any that is aimed at on the way to another, and a window that begins as slowly
/// has at most some hundred times the samples of the plan.
const LEAST_PACE: f64 = 2.5e-3;
/// Part by which the start may be above the pace asked for. A choice: above rounding of the pace,
/// hardly seen in the feed.
const START_MARGIN: f64 = 1e-3;

/// The way on, as far as it is settled.
#[derive(Clone, Debug)]
pub(super) struct Retimed {
    pub(super) asked: Asked,
    windows: Windows,
    /// Place of the first point that has not been output, in steps of the plan.
    origin: f64,
    ready: VecDeque<PaceState>,
    /// Steps of the plan that a window looks ahead, and keeps back.
    far: usize,
    margin: usize,
    done: bool,
}

impl Retimed {
    /// The way on from a state; `None` if none is found that keeps the limits. `before` are the last
    /// positions output before that state.
    pub(super) fn start(
        config: &PlannerConfig,
        nominal: Clock,
        course: &Course,
        state: &PaceState,
        before: [Coords; 3],
        asked: Asked,
    ) -> Option<Retimed> {
        let sure = asked.sure();
        let windows = Windows::new(config, nominal, sure * sure, false);
        let margin = (windows.margin as f64 * asked.feed.max(1.0)).ceil() as usize;
        let mut retimed = Retimed {
            asked,
            windows,
            origin: state.sigma,
            ready: VecDeque::new(),
            far: course.far(),
            margin,
            done: false,
        };
        let end = retimed.look(course)?;
        let steps = retimed.windows.points.len() - 1;
        let stands = course.stands(state.sigma);
        // beta at the start and its slope as the first two coefficients of the spline.
        let first = [-1.0, 1.0].map(|side| {
            if stands {
                sure * sure
            } else {
                state.w * state.w + side * state.u * course.step_s
            }
        });
        let too_slow = !stands && state.w < LEAST_PACE;
        if too_slow || first.iter().any(|x| *x <= 0.0) {
            return None;
        }
        // The state that is may already use all of a limit.
        let eased = if stands {
            0
        } else if state.u == 0.0 {
            EASED_STEADY.min(steps)
        } else {
            EASED_CHANGING.min(steps)
        };
        if !stands {
            retimed.let_slow_down(state.w);
        }
        retimed.windows.begin(
            guess(first, sure * sure, steps + 2, [eased, margin]),
            before.to_vec(),
        );
        let given = retimed.given(end);
        let start = if stands {
            Windows::rest(steps)
        } else {
            End::Moving
        };
        let trial = retimed.windows.best([start, end], given, eased);
        // The seam must not pass a limit.
        if !trial.found || trial.least() < 1.0 - SEAM_EXCESS {
            return None;
        }
        retimed.take(trial, given, end);
        // The state that it starts from.
        retimed.ready.pop_front();
        Some(retimed)
    }

    /// How many points and states are held.
    pub(super) fn held(&self) -> usize {
        self.windows.points.len() + self.ready.len()
    }

    /// How many windows of it were output in which nothing better was found.
    pub(super) fn kept(&self) -> u64 {
        self.windows.kept
    }

    /// The states of the next cycles, as far as they are settled.
    pub(super) fn ready(&self, cycle: usize) -> Option<PaceState> {
        self.ready.get(cycle).copied()
    }

    /// The next state; none at the end of the plan.
    pub(super) fn next(&mut self, course: &Course) -> Option<PaceState> {
        while self.ready.is_empty() && !self.done {
            let eased = self.windows.known().saturating_sub(2);
            let end = self.look(course)?;
            let given = self.given(end);
            let trial = self.windows.best([End::Moving, end], given, eased);
            self.take(trial, given, end);
        }
        self.ready.pop_front()
    }

    /// Adds the points ahead; the end of the window.
    fn look(&mut self, course: &Course) -> Option<End> {
        let last = course.end()?;
        let (known, points) = (last - self.origin, &mut self.windows.points);
        // The end of the plan is in sight: the window ends at rest there.
        let rests = known < self.far as f64;
        let steps = if rests {
            known.ceil().max(1.0) as usize
        } else {
            self.far
        };
        for step in points.len()..=steps {
            let sample = course.sample(&PaceState {
                sigma: self.origin + step as f64,
                w: 1.0,
                u: 0.0,
            })?;
            points.push(Sample {
                feed_part: most(&sample, &self.asked),
                ..sample
            });
        }
        Some(if rests {
            Windows::rest(steps)
        } else {
            End::Moving
        })
    }

    fn given(&self, end: End) -> usize {
        let steps = self.windows.points.len() - 1;
        if end == End::Moving {
            steps - self.margin.min(steps - 1)
        } else {
            steps
        }
    }

    /// Relaxes the feed limit at the start so that a faster initial pace is feasible.
    fn let_slow_down(&mut self, pace: f64) {
        let margin = self.margin as f64;
        for (step, point) in self.windows.points.iter_mut().enumerate().take(self.margin) {
            let left = pace * (1.0 + START_MARGIN) * (1.0 - step as f64 / margin);
            point.feed_part = point.feed_part.min(1.0 / left);
        }
    }

    fn take(&mut self, trial: Trial, given: usize, end: End) {
        let origin = self.origin;
        let state = |placed: Placed| {
            let [w, u] = placed.pace;
            PaceState {
                sigma: origin + placed.interval as f64 + placed.part,
                w,
                u,
            }
        };
        self.ready
            .extend(self.windows.give(trial, given).into_iter().map(state));
        self.origin += given as f64;
        self.done = end != End::Moving;
    }
}

/// One over the largest pace that is asked of a sample.
fn most(sample: &Sample, asked: &Asked) -> f64 {
    let cap = asked.cap(sample.heeds);
    let part = if sample.heeds == Heeds::Feed && cap > 1.0 {
        sample.feed_part / cap
    } else {
        1.0 / cap
    };
    part.max(1.0 / MOST_PACE)
}

/// Coefficients to begin with: as at the start for a while, then over to the pace of the end,
/// squared.
fn guess(first: [f64; 2], end: f64, count: usize, [held, over]: [usize; 2]) -> Vec<f64> {
    let coefficient = |index: usize| match index {
        0 | 1 => first[index],
        _ => {
            let part = (index.saturating_sub(held + 1) as f64 / over as f64).min(1.0);
            end + (first[1] - end) * (1.0 - part * part * (3.0 - 2.0 * part))
        }
    };
    (0..count).map(coefficient).collect()
}
