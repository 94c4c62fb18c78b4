//! One window after the other of a motion that is retimed.

use super::excess::{self, DIFFERENCE_POINTS, Excess, LimitJudge};
use super::interior::{Goal, Interior};
use super::problem::{End, LimitedJoint, Problem, joints, limits, stop_s};
use super::warp::{Placed, Walk};
use crate::{PlannerConfig, Sample};
use lostmotion_base::{Clock, Coords};

/// Part of a window that is planned but held back, in times that the slowest joint takes to stop.
const MARGIN_STOPS: f64 = 2.0;
/// Steps at rest over which beta is constant. A choice: four periods of the samples.
const TIED_STEPS: usize = 8;
/// Parts of the limits of velocity, acceleration and jerk that are planned for: within an interval
/// the jerk passes that of its middle a little where the path is tightly curved. Tuned on the judge
/// from outside (0.998 and 0.992 of the jerk were tried).
const PLANNED_PARTS: [f64; 3] = [1.0 - 1e-6, 0.999, 0.982];
/// When a window is good enough.
const FIRST_GOAL: Goal = Goal {
    gap: 3e-4,
    first_gap: 1.0,
    max_steps: 60,
};
/// The same where only some room was taken away.
const REPAIR_GOAL: Goal = Goal {
    first_gap: 0.03,
    ..FIRST_GOAL
};
/// How often limits are tightened and a window is solved again, at most. Tuned (6 and 8 before).
const MAX_ROUNDS: usize = 10;
/// Part of a limit that has to be passed for a further round. Tuned (2e-3 before).
const ROUND_EXCESS: f64 = 8e-4;
/// Least part of a limit left to an interval with which a solution is taken without a comparison
/// with the steady pace of the window's end. A choice: nearly twice `ROUND_EXCESS`.
const LEAST_ROOM: f64 = 0.9985;
/// How often the pace is lowered around what still passes a limit, at most. Raised from 24 and 100,
/// so that what still passes a limit is lowered more often.
const MAX_DIPS: usize = 200;
/// Factor by which dips may lengthen the samples of a window, at most. A choice: more would cost
/// what retiming gains.
const LONGEST_DIPPED: f64 = 1.01;
/// Times as long as before that a window may get by dips of what is held back, at most. A choice: no
/// dip that mends anything takes as much, and a window that stands still has samples without end.
const SLOWEST_DIPPED: f64 = 10.0;
/// Duality gap, as a part of the time, from which on no better motion was found. A choice: a
/// solution known no better than to 5 % promises no gain.
const FAILED_GAP: f64 = 0.05;
/// Intervals at the start of a window that are eased again after limits were tightened: the given
/// state leaves little choice there. A choice: as many as the taper of a dip beside a given state.
const EASED_AGAIN: usize = 60;
/// Samples that the present solution of a window leads to, with the limits that they pass.
pub(crate) struct Trial {
    pub(super) samples: Vec<Placed>,
    pub(super) walk: Walk,
    /// Intervals around what passes a limit, with the part of the limits of acceleration and jerk
    /// that is left to them.
    pub(super) excess: Excess,
    /// Whether the solver found a better motion.
    pub(crate) found: bool,
    /// Whether the motion is that at the pace of the window's end: nothing better was found.
    is_kept: bool,
}

impl Trial {
    /// The least part of a limit that is left to an interval.
    pub(crate) fn least(&self) -> f64 {
        self.excess
            .iter()
            .flat_map(|(_, scale)| *scale)
            .fold(1.0, f64::min)
    }
}

/// Windows of a nominal motion, with the state between two of them.
#[derive(Clone, Debug)]
pub(crate) struct Windows {
    joints: Vec<LimitedJoint>,
    step_s: f64,
    /// The pace, squared, at which a window ends that is not the last.
    tail: f64,
    /// The nominal motion that has not been output.
    pub(crate) points: Vec<Sample>,
    /// Coefficients of beta over it, as far as it was planned.
    x: Vec<f64>,
    /// Room that the joints' limits leave by interval: acceleration, jerk.
    room: Vec<[f64; 2]>,
    /// How wide the pace is lowered around what passes a limit, in steps.
    width: f64,
    /// Intervals that a window keeps back.
    pub(crate) margin: usize,
    walk: Walk,
    solver: Interior,
    judge: LimitJudge,
    /// How many windows were output in which nothing better was found.
    pub(crate) kept: u64,
}

impl Windows {
    /// For samples at the configuration's clock from a nominal motion at another; `tail` is the
    /// pace, squared, at which a window ends that is not the last.
    pub(crate) fn new(config: &PlannerConfig, nominal: Clock, tail: f64) -> Windows {
        let joints = joints(&config.limits, PLANNED_PARTS);
        let step_s = nominal.period_s();
        let stop_s = stop_s(&joints);
        Windows {
            width: excess::width(joints.iter().map(|joint| joint.limits), step_s),
            joints,
            step_s,
            tail,
            points: Vec::new(),
            x: Vec::new(),
            room: Vec::new(),
            margin: ((MARGIN_STOPS * stop_s / step_s).ceil() as usize).max(4 * TIED_STEPS),
            walk: Walk {
                ahead_s: 0.0,
                period_s: config.clock.period_s(),
            },
            solver: Interior::default(),
            judge: LimitJudge::new(config),
            kept: 0,
        }
    }

    /// An end at rest of a window of `steps` steps.
    pub(crate) fn rest(steps: usize) -> End {
        End::Rest(TIED_STEPS.min(steps / 4))
    }

    /// Plans all points; the first `given` intervals are to be output. The limits of the first
    /// `eased` intervals are eased so that the pace known for them is feasible.
    pub(crate) fn best(&mut self, ends: [End; 2], given: usize, eased: usize) -> Trial {
        let intervals = self.points.len() - 1;
        self.room.resize(intervals, [1.0; 2]);
        let mut problem = limits(&self.points, &self.joints, self.step_s, &self.room, ends);
        let known = self.x.clone();
        // The state at the start is given, and may use all of a limit: what it passes is eased, so
        // that the start is feasible.
        problem.ease(eased, &known);
        // Fresh intervals start at the pace of a window's end, which keeps every limit.
        self.x.resize(intervals + 2, self.tail);
        let slow = self.x.clone();
        let mut trial = self.improve(&problem, &FIRST_GOAL, ends[1], given);
        let mut is_kept = !trial.found;
        // The solver imposes limits in the middles of intervals, the judge looks at samples: where
        // they differ the limits are tightened.
        for _ in 0..MAX_ROUNDS {
            // The steady pace of the end is slower but within all limits, but for the way there.
            if trial.least() > 1.0 - ROUND_EXCESS || !trial.found {
                break;
            }
            for (interval, scale) in &trial.excess {
                problem.tighten(*interval, *scale);
                self.room[*interval] = [
                    self.room[*interval][0] * scale[0],
                    self.room[*interval][1] * scale[1],
                ];
            }
            problem.ease(EASED_AGAIN.min(eased), &known);
            trial = self.improve(&problem, &REPAIR_GOAL, ends[1], given);
        }
        if trial.least() < LEAST_ROOM {
            let found = std::mem::replace(&mut self.x, slow);
            let other = self.trial(ends[1], given, true);
            if other.least() > trial.least() {
                trial = other;
                is_kept = true;
            } else {
                self.x = found;
            }
        }
        Trial {
            is_kept,
            ..self.settle(trial, ends, given)
        }
    }

    /// Lowers the pace where a limit is still passed by a little, if that suffices and takes hardly
    /// longer.
    fn settle(&mut self, first: Trial, ends: [End; 2], given: usize) -> Trial {
        if first.excess.is_empty() {
            return first;
        }
        let longest = LONGEST_DIPPED * first.samples.len() as f64 + 1.0;
        // What is held back may be dipped further, but not until it stands still.
        let slowest_s = SLOWEST_DIPPED * self.lasts_s();
        let (mut best, mut found) = (first, self.x.clone());
        excess::dip(&mut self.x, &best.excess, self.width, ends);
        for _ in 0..MAX_DIPS {
            if self.lasts_s() > slowest_s {
                break;
            }
            let trial = self.trial(ends[1], given, true);
            if trial.samples.len() as f64 > longest {
                break;
            }
            if trial.excess.is_empty() {
                return trial;
            }
            let lowered = trial.excess.clone();
            if trial.least() > best.least() {
                (best, found) = (trial, self.x.clone());
            }
            excess::dip(&mut self.x, &lowered, self.width, ends);
        }
        self.x = found;
        best
    }

    /// How long all that is planned takes, s.
    fn lasts_s(&self) -> f64 {
        Walk::lasts_s(self.step_s, &self.x)
    }

    /// Solves for less time and judges the resulting samples.
    fn improve(&mut self, problem: &Problem, goal: &Goal, end: End, given: usize) -> Trial {
        let before = self.x.clone();
        let found = self.solver.solve(problem, &mut self.x, goal) < FAILED_GAP;
        if !found {
            self.x = before;
        }
        self.trial(end, given, found)
    }

    /// The samples of the first `given` intervals, and what of the limits they and all that is
    /// planned pass.
    fn trial(&self, end: End, given: usize, found: bool) -> Trial {
        let intervals = self.points.len() - 1;
        let (mut walk, mut samples) = (self.walk, Vec::new());
        walk.go(
            &self.points[..=given],
            self.step_s,
            &self.x[..given + 2],
            &mut samples,
        );
        // The judge also sees what is held back, so that a limit passed just beyond is found while
        // it can be mended.
        let mut more = samples.clone();
        let mut beyond = walk;
        beyond.go(
            &self.points[given..],
            self.step_s,
            &self.x[given..],
            &mut more,
        );
        more[samples.len()..]
            .iter_mut()
            .for_each(|placed| placed.interval += given);
        // Differences of the last samples reach into the rest that follows.
        if let (End::Rest(_), Some(last)) = (end, self.points.last()) {
            more.extend(
                [Placed {
                    interval: intervals - 1,
                    part: 1.0,
                    pace: [1.0, 0.0],
                    sample: *last,
                }; DIFFERENCE_POINTS],
            );
        }
        Trial {
            excess: self.judge.excess(&more, intervals),
            samples,
            walk,
            found,
            is_kept: false,
        }
    }

    /// Outputs the samples of the first `given` intervals and drops those intervals.
    pub(crate) fn give(&mut self, trial: Trial, given: usize) -> Vec<Placed> {
        self.walk = trial.walk;
        self.kept += u64::from(trial.is_kept);
        self.judge.pass(&trial.samples);
        self.points.drain(..given);
        self.x.drain(..given);
        self.room.drain(..given);
        trial.samples
    }

    /// Begins in a given state of motion: coefficients of beta for all points, of which the first
    /// two are fixed, and the last positions that were output before.
    pub(crate) fn begin(&mut self, x: Vec<f64>, before: Vec<Coords>) {
        self.x = x;
        self.judge.follow(before);
    }

    /// How many coefficients are known.
    pub(crate) fn known(&self) -> usize {
        self.x.len()
    }
}
