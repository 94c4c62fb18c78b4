//! Whether correcting makes the contour better: of a machine whose compensators foresee where their
//! loads would be without a correction and with it.
//!
//! A drive knows its axis alone, and the contour is made by all of them: what the gap of one hides
//! of its overshoot may be the best that there is. The control has the path and is told what each
//! drive foresees; so it measures both contours, and lets the drives correct as long as theirs is
//! not the worse one.
//!
//! ```text
//! better   rms without^2 - rms with^2 >= 0.5 rms (without - with)^2 over 0.3 s in which each axis came back once    and peak with <= 1.01 peak without + 0.25 um
//! no worse rms with <= rms without over 2 s in which each axis came back twice   and the same
//! worse    rms with > 1.01 rms without, or peak with > 1.02 peak without + 0.5 um
//! ```
//! Where what a correction changes has nothing to do with the other errors, the squares differ by the
//! square of the change: half of it is clear, also where the axes lag by far more than the gap.
//!
//! Without a memory nothing is corrected before it is certainly better or no worse; with one, from
//! the start until it is worse. Axes learn their gaps one after the other, and foresee the last
//! seconds then: commands are held until all are known. Only what the drives know enters: their learned loads and gaps,
//! their references and motors.

use super::frame::STANDSTILL_PER_S;
use super::outputs::AxisInfo;
use crate::motion::Modes;
use crate::observer::ForeseenContour;
use lostmotion_base::units::UM_PER_MM;
use lostmotion_base::{Clock, Coords, Tick};
use lostmotion_contour::{ContourInput, ContourTracker, FootState};
use lostmotion_plan::Sample;
use std::collections::VecDeque;

/// Part of the squares of what is changed by which the squares of the error have to be less for it to
/// be clearly better, how often each axis has to come back meanwhile, and the time over which it has
/// to be, s. A choice: half is far beyond what foreseeing errs by; corners, where the peak is, come
/// as often as an axis does.
const CLEARLY: (f64, u32, f64) = (0.5, 1, 0.3);
/// Time over which the contour has to be no worse, s, and how often each axis has to come back. A
/// choice: as often as on a closed figure.
const NO_WORSE: (f64, u32) = (2.0, 2);
/// Time before which nothing counts as worse, s; with a memory, as long as for `NO_WORSE`. A choice: at
/// the start of a motion nobody knows where a load lies in its gap.
const LEAST_S: f64 = 1.0;
/// How often another axis comes back after an axis did until that one holds nobody back. A choice: the
/// tool axis of a part in a plane is out soon; where both come back in turn it is at most twice, on waves of
/// two to one and of three to two.
const OTHERS_RETURNS: u32 = 3;
/// RMS with a correction over that without from which on it is worse. A choice: half of what counts
/// as worse in the study.
const WORSE_RMS: f64 = 1.01;
/// How often each axis comes back, and the least time, s, until what was foreseen is forgotten while nothing
/// was corrected yet; twice as often each time. A choice: loads are learned within a few reversals, and
/// what was foreseen before was wrong.
const PATIENCE: (u32, f64) = (3, 1.0);
/// Peak with a correction over that without up to which correcting begins, and what may be on top, mm. A
/// choice: half of what counts as worse.
const BETTER_PEAK: (f64, f64) = (1.01, 2.5e-4);
/// Peak with a correction over that without from which on it is worse, and what may be on top, mm: what
/// counts as worse in the study.
const WORSE_PEAK: (f64, f64) = (1.02, 5e-4);

/// What the drives of a variant foresee, measured on the path.
#[derive(Debug)]
pub(super) struct Guard {
    feet: [FootState; 2],
    squares: [f64; 2],
    /// The same of the difference of both.
    changed: f64,
    peaks: [f64; 2],
    /// Time that was measured, s.
    time_s: f64,
    /// By axis, its last direction and how often it came back.
    turns: Vec<(f64, u32)>,
    /// By axis, how often each had come back when it did.
    since: Vec<Vec<u32>>,
    /// By axis, whether it has not come back for so long that its load stays on its flank.
    stays: Vec<bool>,
    /// How often it did while measuring.
    returns: Vec<u32>,
    /// What could not be measured yet, since an axis was not known; the oldest first.
    held: VecDeque<Held>,
    /// How often each axis comes back until what was measured is forgotten while nothing is corrected.
    patience: u32,
    /// Whether it ever corrected.
    corrected: bool,
    corrects: bool,
    /// Whether it did from the start.
    from_start: bool,
    /// Whether an axis is not known that the others have to wait for.
    held_back: bool,
}

/// What an axis foresees: joint positions without a correction and with it.
pub(super) type Pair = [Coords; 2];

/// A command of the plan and what was foreseen for it.
#[derive(Clone, Debug)]
struct Held {
    sample: Sample,
    /// What is not known is not a number.
    pair: Pair,
    /// By axis, a bit where it came back.
    returned: u32,
}

impl Held {
    fn is_known(&self) -> bool {
        self.pair[0].0.iter().all(|place| !place.is_nan())
    }

    /// A load that is not known stays where it is while its axis stands.
    fn standing(mut self) -> Held {
        let Sample {
            position, velocity, ..
        } = &self.sample;
        for joints in &mut self.pair {
            for ((joint, place), speed) in joints.0.iter_mut().zip(position.0).zip(velocity.0) {
                if joint.is_nan() && speed.abs() <= STANDSTILL_PER_S {
                    *joint = place;
                }
            }
        }
        self
    }
}

/// Commands that are kept until all axes are known. A choice: as many as a drive recalls.
const MOST_HELD: usize = 4000;

impl Guard {
    /// Of so many axes; whether it corrects from the start.
    pub(super) fn new(axes: usize, corrects: bool) -> Guard {
        Guard {
            feet: Default::default(),
            squares: [0.0; 2],
            changed: 0.0,
            peaks: [0.0; 2],
            time_s: 0.0,
            turns: vec![(0.0, 0); axes],
            since: vec![vec![0; axes]; axes],
            stays: vec![true; axes],
            returns: vec![0; axes],
            held: VecDeque::new(),
            patience: PATIENCE.0,
            corrected: corrects,
            corrects,
            from_start: corrects,
            held_back: false,
        }
    }

    /// What is foreseen, for those who look on.
    pub(super) fn foreseen(&self, clock: Clock) -> ForeseenContour {
        let count = (self.time_s / clock.period_s()).max(1.0);
        ForeseenContour {
            corrects: self.corrects,
            waits: self.held_back,
            measured_s: self.time_s,
            rms_um: self
                .squares
                .map(|sum| UM_PER_MM * (sum / count).max(0.0).sqrt()),
            max_um: self.peaks.map(|peak| UM_PER_MM * peak),
        }
    }

    /// The part of their corrections that the drives may use.
    pub(super) fn share(&self) -> f64 {
        if self.corrects && !self.held_back {
            1.0
        } else {
            0.0
        }
    }

    /// Takes what is foreseen for a command of the plan, whose cycle takes `clock`.
    pub(super) fn take(
        &mut self,
        sample: &Sample,
        pair: &Pair,
        (axes, clock): (&[AxisInfo], Clock),
        (tracker, modes): (&ContourTracker, &Modes),
    ) {
        // what comes back counts from the start: it is of the path, not of what is foreseen
        let mut returned = 0;
        for (axis, (turn, info)) in self.turns.iter_mut().zip(axes).enumerate() {
            let speed = sample.velocity[info.id];
            // below it an axis stands: rounding of the planner
            let speed = if speed.abs() > STANDSTILL_PER_S {
                speed
            } else {
                0.0
            };
            if speed * turn.0 < 0.0 {
                turn.1 += 1;
                returned |= 1 << axis;
            }
            if speed != 0.0 {
                turn.0 = speed;
            }
        }
        if returned != 0 {
            self.note_returns(returned);
        }
        // until an axis comes back, and while others do time and again, its load stays on its flank;
        // else one that is not known holds the others back: one set right alone can be worse than neither
        let mut pair = *pair;
        self.held_back = false;
        for (stays, info) in self.stays.iter().zip(axes) {
            if *stays {
                pair.iter_mut()
                    .for_each(|joints| joints[info.id] = sample.position[info.id]);
            }
            self.held_back |= pair[0][info.id].is_nan();
        }
        let command = Held {
            sample: *sample,
            pair,
            returned,
        };
        if self.held_back {
            if self.held.len() >= MOST_HELD {
                self.held.pop_front();
            }
            self.held.push_back(command);
            return;
        }
        // the path is measured in its order
        self.measure_held(clock, (tracker, modes));
        self.measure(&command, clock, (tracker, modes));
    }

    /// Notes, by bits, which axes come back now.
    fn note_returns(&mut self, returned: u32) {
        for (axis, (since, stays)) in self.since.iter_mut().zip(&mut self.stays).enumerate() {
            if (returned >> axis) & 1 != 0 {
                since.clear();
                since.extend(self.turns.iter().map(|(_, count)| count));
                *stays = false;
            }
            // one that never came back has its first flank
            let mut others = since.iter().zip(&self.turns);
            *stays |= others.any(|(since, (_, count))| *count >= since + OTHERS_RETURNS);
        }
    }

    /// Takes what an axis foresees of the last commands, now that it is known; the last is the newest.
    pub(super) fn recall(&mut self, info: &AxisInfo, places: &[Option<[f64; 2]>]) {
        for (held, places) in self.held.iter_mut().rev().zip(places.iter().rev()) {
            let Some(places) = places else { continue };
            for (joints, place) in held.pair.iter_mut().zip(places) {
                if joints[info.id].is_nan() {
                    joints[info.id] = place * info.units_per_rad / info.units;
                }
            }
        }
    }

    /// Measures the commands that were held, if all axes are known of the newest.
    pub(super) fn catch_up(&mut self, clock: Clock, path: (&ContourTracker, &Modes)) {
        if self.held.back().is_some_and(Held::is_known) {
            self.measure_held(clock, path);
        }
    }

    /// Measures those of the held commands of which all axes are known, or stood.
    fn measure_held(&mut self, clock: Clock, path: (&ContourTracker, &Modes)) {
        for held in std::mem::take(&mut self.held) {
            let held = held.standing();
            if held.is_known() {
                self.measure(&held, clock, path);
            }
        }
    }

    /// The oldest command that is held.
    pub(super) fn oldest(&self) -> Option<&Sample> {
        self.held.front().map(|held| &held.sample)
    }

    /// Measures what is foreseen for a command.
    fn measure(
        &mut self,
        Held {
            sample,
            pair,
            returned,
        }: &Held,
        clock: Clock,
        (tracker, modes): (&ContourTracker, &Modes),
    ) {
        for (axis, returns) in self.returns.iter_mut().enumerate() {
            *returns += (returned >> axis) & 1;
        }
        // nothing would be changed
        if pair[0] == pair[1] || sample.path_speed <= 0.0 {
            return;
        }
        let modes = modes.at(sample.segment);
        let wanted = modes.tool_pose(&sample.position, &sample.tool_mm);
        let mut offs = [[0.0; 3]; 2];
        for ((joints, foot), off) in pair.iter().zip(&mut self.feet).zip(&mut offs) {
            let pose = modes.tool_pose(joints, &sample.tool_mm);
            let input = ContourInput {
                tick: Tick::default(),
                segment: sample.segment,
                s: sample.s,
                actual_tip_mm: pose.tip,
                commanded_tip_mm: wanted.tip,
                actual_axis: pose.axis,
                commanded_axis: wanted.axis,
            };
            // what cannot be measured is no contour to judge by
            match tracker.measure(foot, &input) {
                Ok(found) if !found.rapid => *off = found.off_mm,
                _ => return,
            }
        }
        let square = |off: [f64; 3]| off.iter().map(|x| x * x).sum::<f64>();
        for (which, off) in offs.into_iter().enumerate() {
            self.squares[which] += square(off);
            self.peaks[which] = self.peaks[which].max(square(off).sqrt());
        }
        self.changed += square(std::array::from_fn(|i| offs[1][i] - offs[0][i]));
        self.time_s += clock.period_s();
    }

    /// Whether each axis came back so often since measuring began; one that never does need not.
    fn came_back(&self, times: u32) -> bool {
        let mut axes = self.stays.iter().zip(&self.returns);
        axes.clone()
            .all(|(stays, returns)| *stays || *returns >= times)
            && axes.any(|(_, returns)| *returns > 0)
    }

    /// Decides anew; to be asked at the same times of the motion whatever the chunks.
    pub(super) fn decide(&mut self) {
        let [without, with] = self.squares;
        let peaks = self.peaks[1] <= WORSE_PEAK.0 * self.peaks[0] + WORSE_PEAK.1;
        let seen = |times: u32, time_s: f64| self.time_s >= time_s && self.came_back(times);
        let seen_all = seen(NO_WORSE.1, NO_WORSE.0);
        if self.corrects {
            self.corrected = true;
            let enough = if self.from_start {
                seen_all
            } else {
                self.time_s >= LEAST_S
            };
            let no_worse = peaks && with <= WORSE_RMS * WORSE_RMS * without;
            self.corrects = no_worse || !enough;
            return;
        }
        let clearly = without - with >= CLEARLY.0 * self.changed && seen(CLEARLY.1, CLEARLY.2);
        let peaks = self.peaks[1] <= BETTER_PEAK.0 * self.peaks[0] + BETTER_PEAK.1;
        let no_worse = with <= without && seen_all;
        let impatient = seen(self.patience, PATIENCE.1);
        self.corrects = peaks && without > 0.0 && (clearly || no_worse);
        // what was foreseen while the load was known less well is forgotten
        if !self.corrects && !self.corrected && impatient {
            self.patience = self.patience.saturating_mul(2);
            (self.time_s, self.squares, self.peaks) = (0.0, [0.0; 2], [0.0; 2]);
            self.changed = 0.0;
            self.returns.fill(0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both axes came back so often, over a time, with these mean squares and peaks.
    fn seen(corrects: bool, times: u32, time_s: f64, squares: [f64; 2], peaks: [f64; 2]) -> bool {
        let mut guard = Guard {
            squares,
            peaks,
            changed: 1.0,
            time_s,
            turns: vec![(1.0, times), (-1.0, times), (0.0, 0)],
            returns: vec![times, times, 0],
            stays: vec![false, false, true],
            ..Guard::new(3, corrects)
        };
        guard.decide();
        guard.share() > 0.0
    }

    #[test]
    fn nothing_is_corrected_before_it_is_seen_to_be_no_worse() {
        let (better, alike, peaks) = ([1.0, 0.25], [1.0, 0.99], [1.0, 1.0]);
        assert!(!seen(false, 0, 10.0, better, peaks));
        assert!(!seen(false, 1, 0.2, better, peaks));
        assert!(seen(false, 1, 0.4, better, peaks));
        assert!(!seen(false, 1, 10.0, alike, peaks));
        assert!(!seen(false, 2, 1.0, alike, peaks));
        assert!(seen(false, 2, 3.0, alike, peaks));
        assert!(!seen(false, 2, 3.0, [1.0, 1.01], peaks));
        assert!(!seen(false, 2, 3.0, better, [1.0, 1.05]));
    }

    #[test]
    fn what_corrects_from_the_start_does_until_it_is_seen_to_be_worse() {
        let (worse, peaks) = ([1.0, 1.1], [1.0, 1.0]);
        assert!(seen(true, 1, 10.0, worse, peaks));
        assert!(!seen(true, 2, 10.0, worse, peaks));
        assert!(seen(true, 2, 10.0, [1.0, 1.005], [1.0, 1.0203]));
        assert!(!seen(true, 2, 10.0, [1.0, 0.5], [1.0, 1.03]));
    }

    #[test]
    fn an_axis_beside_others_that_come_back_time_and_again_stays_on_its_flank() {
        let mut guard = Guard::new(2, false);
        let mut came = |axis: usize| {
            guard.turns[axis].1 += 1;
            guard.note_returns(1 << axis);
            guard.stays.clone()
        };
        assert_eq!(came(0), [false, true]);
        assert_eq!(came(1), [false, false]);
        // two of one to one of the other
        for axis in [0, 0, 1, 0, 0] {
            assert_eq!(came(axis), [false, false]);
        }
        // the first alone, until the other comes back
        assert_eq!(came(0), [false, true]);
        assert_eq!(came(1), [false, false]);
    }

    #[test]
    fn what_was_foreseen_first_is_forgotten_after_some_returns() {
        let mut guard = Guard {
            squares: [1.0, 0.5],
            peaks: [1.0, 2.0],
            time_s: 1.5,
            returns: vec![2, 3],
            stays: vec![false, false],
            ..Guard::new(2, false)
        };
        guard.decide();
        assert!(guard.time_s > 0.0 && guard.patience == 3);
        guard.returns = vec![3, 3];
        guard.decide();
        assert!(guard.time_s == 0.0 && guard.patience == 6 && guard.share() == 0.0);
    }

    #[test]
    fn an_axis_that_came_back_and_is_not_known_holds_the_others_back() {
        let guard = Guard {
            held_back: true,
            ..Guard::new(2, true)
        };
        assert!(guard.share() == 0.0 && Guard::new(2, true).share() == 1.0);
    }
}
