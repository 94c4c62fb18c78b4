//! One window after the other of a motion that is retimed.

use super::excess::{self, DIFFERENCE_POINTS, Excess, LimitJudge};
use super::interior::{Goal, Interior};
use super::problem::{
    End, LimitedJoint, Problem, joints, keeps_limits, limits, stop_s, uses_limits,
};
use super::warp::{Placed, Walk};
use crate::{PlannerConfig, Sample};
use lostmotion_base::{Clock, Coords};
use std::ops::Range;

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
/// Part by which samples at the nominal pace may pass a limit: rounding of positions.
const STEADY_EXCESS: f64 = 5e-5;
/// Intervals to either side of a sample to which a passed limit is put down, at most: those under
/// four samples, and one more.
const JUDGED_REACH: usize = 2 * excess::DIFFERENCE_POINTS + 2;
/// Part of the time by which a solution has to be faster than the nominal pace, where that can be
/// kept, not to be held against it. A choice: rounding.
const FASTER_PART: f64 = 1e-9;
/// The part of a limit that is left to an interval in which it is passed by that.
const STEADY_ROOM: f64 = (1.0 - excess::TIGHTEN_MARGIN) / (1.0 + STEADY_EXCESS);
/// How many ways to the nominal pace and from it are tried, each a part shorter. A choice: where the
/// first ones pass a limit, one that changes the pace at another place often does not.
const TRIED_WAYS: usize = 4;
/// How often a way between two paces is found with less room where it passes a limit. A
/// choice: what is left after four is a way that does not go there.
const WAY_ROUNDS: usize = 4;
/// Intervals for which a window goes on as the search began before a way to a steady pace, tried in
/// turn. A choice: the reach of the given coefficients, as many as are eased, and some more.
const HELD_ON: [usize; 4] = [0, 8, EASED_AGAIN, 4 * EASED_AGAIN];
/// Part of a limit that has to be left to what is held back on a way from the nominal pace, if all
/// ways pass one. A choice: the next window nearly always mends as much.
const LEAST_HELD_BACK: f64 = 0.95;
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
    /// The largest part of a limit that is passed in the first intervals; none where nothing better was found
    /// than what stands in.
    pub(crate) fn beyond(&self, intervals: usize) -> Option<f64> {
        let output = self.excess.iter().filter(|(at, _)| *at < intervals);
        let passed = output.flat_map(|(_, scale)| scale.map(excess::passed));
        (!self.is_kept).then_some(passed.fold(0.0, f64::max))
    }

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
    /// The same where the nominal pace may be kept: what the nominal motion uses is allowed.
    steady_joints: Vec<LimitedJoint>,
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
    /// Whether the nominal motion at its own pace is one to fall back on.
    has_pace: bool,
    walk: Walk,
    solver: Interior,
    judge: LimitJudge,
    /// How many windows were output in which nothing better was found.
    pub(crate) kept: u64,
}

impl Windows {
    /// For samples at the configuration's clock from a nominal motion at another; `tail` is the
    /// pace, squared, at which a window ends that is not the last. `has_pace` says that the nominal
    /// motion keeps the limits at its own pace nearly everywhere, and that no window should be
    /// slower.
    pub(crate) fn new(
        config: &PlannerConfig,
        nominal: Clock,
        tail: f64,
        has_pace: bool,
    ) -> Windows {
        let steady_joints = joints(&config.limits, PLANNED_PARTS, 1.0);
        let joints = joints(&config.limits, PLANNED_PARTS, 0.0);
        let step_s = nominal.period_s();
        let stop_s = stop_s(&joints);
        Windows {
            width: excess::width(joints.iter().map(|joint| joint.limits), step_s),
            joints,
            steady_joints,
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
            has_pace,
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
        let known = self.x.clone();
        // Fresh intervals start at the pace of a window's end, which keeps every limit.
        self.x.resize(intervals + 2, self.tail);
        let steady = if self.has_pace {
            self.steady(ends, given, &known)
        } else {
            0..0
        };
        // From the nominal pace, if no other can be faster, there is nothing to look for.
        if steady.start == 0
            && !steady.is_empty()
            && uses_limits(
                &self.points[..=steady.end],
                &self.steady_joints,
                self.step_s,
            )
            && let Some(trial) = self.at_pace(&steady, ends, given, &known)
        {
            return trial;
        }
        let trial = self.solved(ends, given, eased, &known);
        self.or_steady(trial, &steady, ends, given, &known)
    }

    /// The intervals over which the nominal pace may be kept: between the way to it from a given
    /// state, and the way from it to the pace of the window's end. None where it is too fast, as it
    /// is at corners rounded in time.
    fn steady(&self, ends: [End; 2], given: usize, known: &[f64]) -> Range<usize> {
        let is_given = ends[0] == End::Moving && known.iter().take(2).any(|x| *x != 1.0);
        let start = if is_given { self.margin } else { 0 };
        let end = if ends[1] == End::Moving {
            given
        } else {
            self.points.len() - 1
        };
        if start < end && keeps_limits(&self.points[start..=end], &self.steady_joints, self.step_s)
        {
            start..end
        } else {
            0..0
        }
    }

    /// The nominal pace in place of a solution that takes longer than it or passes a limit. A motion
    /// that uses all of the jerk all along, as one from rest to rest on a line does, has no better
    /// one, and the solution comes near to it at most.
    fn or_steady(
        &mut self,
        trial: Trial,
        steady: &Range<usize>,
        ends: [End; 2],
        given: usize,
        known: &[f64],
    ) -> Trial {
        let coefficients = steady.start..steady.end + 2;
        let steady_s = self.step_s * (1.0 - FASTER_PART) * steady.len() as f64;
        let passes = trial.least() < STEADY_ROOM;
        let is_faster =
            !steady.is_empty() && Walk::lasts_s(self.step_s, &self.x[coefficients]) < steady_s;
        if steady.is_empty() || (is_faster && !passes) {
            return trial;
        }
        let (solved, solved_s) = (self.x.clone(), self.lasts_s());
        match self.at_pace(steady, ends, given, known) {
            Some(other) if passes || self.lasts_s() <= solved_s => other,
            _ => {
                self.x = solved;
                trial
            }
        }
    }

    /// The nominal pace over some intervals, with ways to it and from it; `None` if there are none.
    fn at_pace(
        &mut self,
        steady: &Range<usize>,
        ends: [End; 2],
        given: usize,
        known: &[f64],
    ) -> Option<Trial> {
        let before = self.x.clone();
        let found = self
            .enter_pace(steady.start, ends[1], given, known)
            .and_then(|trial| {
                if ends[1] == End::Moving {
                    self.leave_pace(ends[1], given, &before)
                } else {
                    Some(trial)
                }
            });
        if found.is_none() {
            self.x = before;
        }
        found
    }

    /// The nominal pace from some interval up to `start` on; samples that are output keep the limits.
    fn enter_pace(&mut self, start: usize, end: End, given: usize, known: &[f64]) -> Option<Trial> {
        let judged = if end == End::Moving {
            given.saturating_sub(JUDGED_REACH)
        } else {
            usize::MAX
        };
        // Where the nominal motion uses all of the jerk, hardly any way leads to its pace.
        (0..TRIED_WAYS).find_map(|way| {
            let over = start - start * way / (TRIED_WAYS + 1);
            if start == 0 && way > 0 {
                return None;
            }
            self.x[over..].fill(1.0);
            let trial = self.way(0..over, known, end, given)?;
            let keeps = |(interval, scale): &(usize, [f64; 2])| {
                *interval >= judged || scale[0].min(scale[1]) >= STEADY_ROOM
            };
            trial.excess.iter().all(keeps).then_some(trial)
        })
    }

    /// From the nominal pace to that of the window's end, over what is held back.
    fn leave_pace(&mut self, end: End, given: usize, before: &[f64]) -> Option<Trial> {
        let intervals = self.points.len() - 1;
        let mut best: Option<(f64, Vec<f64>)> = None;
        for way in 0..TRIED_WAYS {
            let from = given + (intervals - given) * way / (2 * TRIED_WAYS);
            self.x[given..from + 2].fill(1.0);
            self.x[intervals..].copy_from_slice(&before[intervals..]);
            let Some(trial) = self.way(from..intervals, &[], end, given) else {
                continue;
            };
            if trial.least() > 1.0 - ROUND_EXCESS {
                return Some(trial);
            }
            if best
                .as_ref()
                .is_none_or(|(least, _)| trial.least() > *least)
            {
                best = Some((trial.least(), self.x.clone()));
            }
        }
        let (_, x) = best.filter(|(least, _)| *least > LEAST_HELD_BACK)?;
        self.x = x;
        Some(self.trial(end, given, true))
    }

    /// A way over some intervals between the paces at both of their ends, found again with less room
    /// where its samples pass a limit: the best of a few. All as it is where there are no intervals.
    fn way(&mut self, over: Range<usize>, known: &[f64], end: End, given: usize) -> Option<Trial> {
        if over.is_empty() {
            return Some(self.trial(end, given, true));
        }
        let paces = self.x.clone();
        let mut room = vec![[1.0; 2]; over.len()];
        let mut best: Option<(f64, Trial, Vec<f64>)> = None;
        for _ in 0..WAY_ROUNDS {
            self.x.clone_from(&paces);
            if !self.join(over.clone(), known, &room) {
                break;
            }
            let trial = self.trial(end, given, true);
            let mut least = 1.0_f64;
            for (interval, scale) in trial.excess.iter().filter(|(at, _)| over.contains(at)) {
                let room = &mut room[interval - over.start];
                *room = [room[0] * scale[0], room[1] * scale[1]];
                least = least.min(scale[0]).min(scale[1]);
            }
            if best.as_ref().is_none_or(|(known, ..)| least > *known) {
                best = Some((least, trial, self.x.clone()));
            }
            if least > 1.0 - ROUND_EXCESS {
                break;
            }
        }
        let (_, trial, x) = best?;
        self.x = x;
        Some(trial)
    }

    /// Finds a way between the paces that the coefficients have at both ends of some intervals;
    /// false if there is none. `left` is the part of the limits of acceleration and jerk that is left to
    /// an interval, the whole where it says nothing.
    fn join(&mut self, over: Range<usize>, known: &[f64], left: &[[f64; 2]]) -> bool {
        let x = &mut self.x[over.start..over.end + 2];
        let count = x.len();
        if let Some(known) = known.get(..2) {
            x[..2].copy_from_slice(known);
        }
        let (first, last) = (x[1], x[count - 2]);
        // To begin with a change as smooth as can be.
        for (index, x) in x.iter_mut().enumerate().take(count - 2).skip(2) {
            let part = (index - 1) as f64 / (count - 3) as f64;
            *x = first + (last - first) * part * part * (3.0 - 2.0 * part);
        }
        // A given state keeps what is planned for, the nominal pace needs what the nominal motion
        // uses: from the one to the other.
        let half = 0.5 * over.len() as f64;
        let room: Vec<[f64; 2]> = (0..over.len())
            .map(|interval| {
                let part = (interval as f64 / half).min(1.0);
                let planned = if known.is_empty() {
                    1.0
                } else {
                    PLANNED_PARTS[2]
                };
                let [acceleration, jerk] = left.get(interval).copied().unwrap_or([1.0; 2]);
                [acceleration, jerk * (planned + (1.0 - planned) * part)]
            })
            .collect();
        let mut problem = limits(
            &self.points[over.start..=over.end],
            &self.steady_joints,
            self.step_s,
            &room,
            [End::Moving; 2],
        );
        problem.ease(known.len().saturating_sub(2).min(EASED_AGAIN), known);
        self.solver.solve(&problem, x, &FIRST_GOAL) < FAILED_GAP
    }

    /// The solution for less time, as near to the limits as it can be brought.
    fn solved(&mut self, ends: [End; 2], given: usize, eased: usize, known: &[f64]) -> Trial {
        let (slow, room) = (self.x.clone(), self.room.clone());
        let mut trial = self.tightened([EASED_AGAIN, eased], ends, given, known);
        // A way from the nominal pace need not be the known one, whatever that passes.
        if trial.least() < LEAST_ROOM && known.len() >= 2 && known[..2] == [1.0; 2] {
            let found = std::mem::replace(&mut self.x, slow.clone());
            let tight = std::mem::replace(&mut self.room, room);
            let other = self.tightened([JUDGED_REACH, eased], ends, given, known);
            if other.found && other.least() > trial.least() {
                trial = other;
            } else {
                (self.x, self.room) = (found, tight);
            }
        }
        let mut is_kept = !trial.found;
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
        let longest = LONGEST_DIPPED * trial.samples.len() as f64 + 1.0;
        let settled = self.settle(trial, longest, ends, given);
        if !is_kept {
            return Trial { is_kept, ..settled };
        }
        // Where nothing better was found a steady pace, dipped around what passes a limit, with the
        // fastest way to it, mostly is better than what the search began with.
        let (slow, slow_s) = (self.x.clone(), self.lasts_s());
        match self.steady_with_dips(ends, given, known, settled.samples.len() as f64) {
            Some(other) if self.lasts_s() < slow_s => Trial { is_kept, ..other },
            _ => {
                self.x = slow;
                Trial { is_kept, ..settled }
            }
        }
    }

    /// The nominal pace, or where that is none to fall back on the one of the window's end, with dips
    /// where it passes a limit; `None` if there is no way to it or from it, or if dips do not suffice.
    fn steady_with_dips(
        &mut self,
        ends: [End; 2],
        given: usize,
        known: &[f64],
        longest: f64,
    ) -> Option<Trial> {
        let pace = if self.has_pace { 1.0 } else { self.tail };
        let slow = self.x.clone();
        let is_given = ends[0] == End::Moving && known.iter().take(2).any(|x| *x != pace);
        let judged = if ends[1] == End::Moving {
            given.saturating_sub(JUDGED_REACH)
        } else {
            usize::MAX
        };
        // A state that leaves no room at once may leave some when it has gone on as it was for a while.
        HELD_ON.into_iter().find_map(|from| {
            let over = if from == 0 && !is_given {
                0
            } else {
                (from + self.margin).min(given)
            };
            if from > 0 && from >= over {
                return None;
            }
            self.x.clone_from(&slow);
            self.x[over..].fill(pace);
            let known = if from == 0 {
                known
            } else {
                &slow[from..from + 2]
            };
            let trial = self.way(from..over, known, ends[1], given)?;
            let mut trial = self.settle(trial, longest, ends, given);
            if ends[1] == End::Moving && self.has_pace {
                trial = self.leave_pace(ends[1], given, &slow)?;
            }
            let keeps = |(interval, scale): &(usize, [f64; 2])| {
                *interval >= judged || scale[0].min(scale[1]) >= LEAST_ROOM
            };
            trial.excess.iter().all(keeps).then_some(trial)
        })
    }

    /// The solution after limits were tightened where its samples pass them. The limits of the first
    /// intervals are eased so that the pace known for them is feasible: after limits were tightened,
    /// and at first.
    fn tightened(
        &mut self,
        [eased_again, eased]: [usize; 2],
        ends: [End; 2],
        given: usize,
        known: &[f64],
    ) -> Trial {
        let mut problem = limits(&self.points, &self.joints, self.step_s, &self.room, ends);
        // The state at the start is given, and may use all of a limit: what it passes is eased, so
        // that the start is feasible.
        problem.ease(eased, known);
        let mut trial = self.improve(&problem, &FIRST_GOAL, ends[1], given);
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
            problem.ease(eased_again.min(eased), known);
            trial = self.improve(&problem, &REPAIR_GOAL, ends[1], given);
        }
        trial
    }

    /// Lowers the pace where a limit is still passed by a little, if that suffices and takes no more
    /// than so many samples.
    fn settle(&mut self, first: Trial, longest: f64, ends: [End; 2], given: usize) -> Trial {
        if first.excess.is_empty() {
            return first;
        }
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
