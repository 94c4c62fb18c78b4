//! Whether correcting makes the contour better: of a machine whose compensators foresee where their
//! loads would be without a correction and with it.
//!
//! A drive knows its axis alone, and the contour is made by all of them: what the gap of one hides
//! of its overshoot may be the best that there is. The control has the path and is told what each
//! drive foresees; so it measures both contours, and lets the drives correct as long as theirs is
//! not the worse one.
//!
//! ```text
//! better   rms with <= 0.7 rms without over 0.3 s in which each axis came back once    and peak with <= 1.02 peak without + 0.5 um
//! no worse rms with <= rms without over 2 s in which each axis came back twice   and the same
//! worse    rms with > 1.01 rms without, or peak with > 1.02 peak without + 0.5 um
//! ```
//! Without a memory nothing is corrected before it is certainly better or no worse; with one, from
//! the start until it is worse. Only what the drives know enters: their learned loads and gaps,
//! their references and motors.

use super::frame::STANDSTILL_PER_S;
use super::outputs::AxisInfo;
use crate::motion::Modes;
use lostmotion_base::{Clock, Coords, Tick};
use lostmotion_contour::{ContourInput, ContourTracker, FootState};
use lostmotion_plan::Sample;

/// RMS with a correction over that without from which on it is clearly better, how often each axis has
/// to come back meanwhile, and the time over which it has to be, s. A choice: three tenths are far
/// beyond what foreseeing errs by; corners, where the peak is, come as often as an axis does.
const CLEARLY: (f64, u32, f64) = (0.7, 1, 0.3);
/// Time over which the contour has to be no worse, s, and how often each axis has to come back. A
/// choice: as often as on a closed figure.
const NO_WORSE: (f64, u32) = (2.0, 2);
/// Time before which nothing counts as worse, s; with a memory, as long as for `NO_WORSE`. A choice: at
/// the start of a motion nobody knows where a load lies in its gap.
const LEAST_S: f64 = 1.0;
/// Time for which an axis stands beside others that move until it holds nobody back, s. A choice: the
/// tool axis of a part in a plane is out after this time, the legs of a square are mostly shorter.
const STILL_S: f64 = 2.0;
/// RMS with a correction over that without from which on it is worse. A choice: half of what counts
/// as worse in the study.
const WORSE_RMS: f64 = 1.01;
/// The same of the peak, and what may be on top, mm: what counts as worse in the study.
const WORSE_PEAK: (f64, f64) = (1.02, 5e-4);

/// What the drives of a variant foresee, measured on the path.
#[derive(Debug)]
pub(super) struct Guard {
    feet: [FootState; 2],
    squares: [f64; 2],
    peaks: [f64; 2],
    /// Time that was measured, s.
    time_s: f64,
    /// By axis, its last direction and how often it came back.
    turns: Vec<(f64, u32)>,
    /// By axis, for how long the others have moved since it did, s.
    still_s: Vec<f64>,
    /// How often it had when measuring began.
    from: Vec<u32>,
    corrects: bool,
    /// Whether it did from the start.
    from_start: bool,
    /// Whether an axis is not known that the others have to wait for.
    held_back: bool,
}

/// What an axis foresees: joint positions without a correction and with it.
pub(super) type Pair = [Coords; 2];

impl Guard {
    /// Of so many axes; whether it corrects from the start.
    pub(super) fn new(axes: usize, corrects: bool) -> Guard {
        Guard {
            feet: Default::default(),
            squares: [0.0; 2],
            peaks: [0.0; 2],
            time_s: 0.0,
            turns: vec![(0.0, 0); axes],
            still_s: vec![0.0; axes],
            from: vec![0; axes],
            corrects,
            from_start: corrects,
            held_back: false,
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
        for ((turn, still_s), info) in self.turns.iter_mut().zip(&mut self.still_s).zip(axes) {
            let speed = sample.velocity[info.id];
            // below it an axis stands: rounding of the planner
            let speed = if speed.abs() > STANDSTILL_PER_S {
                speed
            } else {
                0.0
            };
            if speed != 0.0 {
                *still_s = 0.0;
            } else if sample.path_speed > 0.0 {
                *still_s += clock.period_s();
            }
            if speed * turn.0 < 0.0 {
                turn.1 += 1;
            }
            if speed != 0.0 {
                turn.0 = speed;
            }
        }
        // until an axis comes back, and while it stands beside others that move, its load stays where it is;
        // else one that is not known holds the others back: one set right alone can be worse than neither
        let mut pair = *pair;
        self.held_back = false;
        for (((_, count), still_s), info) in self.turns.iter().zip(&self.still_s).zip(axes) {
            if *count == 0 || *still_s > STILL_S {
                pair.iter_mut()
                    .for_each(|joints| joints[info.id] = sample.position[info.id]);
            }
            self.held_back |= pair[0][info.id].is_nan();
        }
        // nothing is known yet, or nothing would be changed
        if self.held_back || pair[0] == pair[1] || sample.path_speed <= 0.0 {
            return;
        }
        let modes = modes.at(sample.segment);
        let wanted = modes.tool_pose(&sample.position, &sample.tool_mm);
        let mut errors = [0.0; 2];
        for ((joints, foot), error) in pair.iter().zip(&mut self.feet).zip(&mut errors) {
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
                Ok(found) if !found.rapid => *error = found.distance_mm,
                _ => return,
            }
        }
        if self.time_s == 0.0 {
            self.from = self.turns.iter().map(|(_, count)| *count).collect();
        }
        for (which, error) in errors.into_iter().enumerate() {
            self.squares[which] += error * error;
            self.peaks[which] = self.peaks[which].max(error);
        }
        self.time_s += clock.period_s();
    }

    /// Whether each axis came back so often since measuring began; one that never does need not.
    fn came_back(&self, times: u32) -> bool {
        let turns = self.turns.iter().zip(&self.from);
        let mut turns = turns.map(|((_, count), from)| count - from);
        turns.clone().all(|count| count == 0 || count >= times) && turns.any(|count| count > 0)
    }

    /// Decides anew; to be asked at the same times of the motion whatever the chunks.
    pub(super) fn decide(&mut self) {
        let [without, with] = self.squares;
        let peaks = self.peaks[1] <= WORSE_PEAK.0 * self.peaks[0] + WORSE_PEAK.1;
        let seen = |times: u32, time_s: f64| self.time_s >= time_s && self.came_back(times);
        let seen_all = seen(NO_WORSE.1, NO_WORSE.0);
        if self.corrects {
            let enough = if self.from_start {
                seen_all
            } else {
                self.time_s >= LEAST_S
            };
            let no_worse = peaks && with <= WORSE_RMS * WORSE_RMS * without;
            self.corrects = no_worse || !enough;
            return;
        }
        let clearly = with <= CLEARLY.0 * CLEARLY.0 * without && seen(CLEARLY.1, CLEARLY.2);
        let no_worse = with <= without && seen_all;
        self.corrects = peaks && without > 0.0 && (clearly || no_worse);
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
            time_s,
            turns: vec![(1.0, times), (-1.0, times), (0.0, 0)],
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
    fn an_axis_that_came_back_and_is_not_known_holds_the_others_back() {
        let guard = Guard {
            held_back: true,
            ..Guard::new(2, true)
        };
        assert!(guard.share() == 0.0 && Guard::new(2, true).share() == 1.0);
    }
}
