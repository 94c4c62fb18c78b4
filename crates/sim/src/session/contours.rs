//! Two contours of one motion, measured side by side, and how often each axis came back meanwhile.

use super::frame::STANDSTILL_PER_S;
use super::outputs::AxisInfo;
use crate::motion::Modes;
use lostmotion_base::{Clock, Coords, Tick};
use lostmotion_contour::{ContourInput, ContourTracker, FootState};
use lostmotion_methods::LONG_REST_S;
use lostmotion_plan::Sample;

/// What an axis foresees: joint positions without a correction and with it.
pub(super) type Pair = [Coords; 2];

/// The contour without a correction, and that with it.
#[derive(Clone, Debug, Default)]
pub(super) struct Contours {
    pub(super) feet: [FootState; 2],
    /// Sums of the squares of both errors, mm2, and of their difference.
    pub(super) squares: [f64; 2],
    pub(super) changed: f64,
    /// Their largest magnitudes, mm.
    pub(super) peaks: [f64; 2],
    /// Commands that were measured, and their time, s.
    pub(super) count: u64,
    pub(super) time_s: f64,
}

impl Contours {
    /// Measures a command of the plan with joint positions without a correction and with it; rapids, and
    /// what a correction does not change, are left out. Gives the squares of both errors, mm2.
    pub(super) fn measure(
        &mut self,
        sample: &Sample,
        pair: &Pair,
        clock: Clock,
        (tracker, modes): (&ContourTracker, &Modes),
    ) -> Option<[f64; 2]> {
        if pair[0] == pair[1] || sample.path_speed <= 0.0 {
            return None;
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
                _ => return None,
            }
        }
        let square = |off: [f64; 3]| off.iter().map(|x| x * x).sum::<f64>();
        for (which, off) in offs.into_iter().enumerate() {
            self.squares[which] += square(off);
            self.peaks[which] = self.peaks[which].max(square(off).sqrt());
        }
        self.changed += square(std::array::from_fn(|i| offs[1][i] - offs[0][i]));
        self.count += 1;
        self.time_s += clock.period_s();
        Some(offs.map(square))
    }

    /// Forgets what was measured.
    pub(super) fn clear(&mut self) {
        *self = Contours {
            feet: std::mem::take(&mut self.feet),
            ..Contours::default()
        };
    }
}

/// How often another axis comes back after an axis did until that one holds nobody back. A choice: the
/// tool axis of a part in a plane is out soon; where both come back in turn it is at most twice, on waves of
/// two to one and of three to two.
const OTHERS_RETURNS: u32 = 3;

/// Rest from which on an axis rests aside once another one comes back, or several move, s. A choice: those of one
/// figure rest for less when another one turns round at its end; a servo has come to rest.
const ASIDE_REST_S: f64 = 0.3;
/// Axes that make a figure by themselves. A choice: of a square or a zigzag one moves at a time.
const SEVERAL: usize = 2;

/// How often the axes come back.
#[derive(Clone, Debug)]
pub(super) struct Returns {
    /// By axis, its last direction and how often it came back.
    pub(super) turns: Vec<(f64, u32)>,
    /// By axis, how often each had come back when it did.
    since: Vec<Vec<u32>>,
    /// By axis, whether it has not come back for so long that its load stays on its flank.
    pub(super) stays: Vec<bool>,
    /// How often it did while measuring.
    pub(super) counted: Vec<u32>,
    /// By axis, how long it has rested, s.
    rested_s: Vec<f64>,
    /// By axis, whether its last motion began in a rapid.
    rapid: Vec<bool>,
    /// By axis, whether another one came back, or several moved, while it rests.
    aside: Vec<bool>,
}

impl Returns {
    pub(super) fn new(axes: usize) -> Returns {
        Returns {
            turns: vec![(0.0, 0); axes],
            since: vec![vec![0; axes]; axes],
            stays: vec![true; axes],
            counted: vec![0; axes],
            rested_s: vec![0.0; axes],
            rapid: vec![false; axes],
            aside: vec![false; axes],
        }
    }

    /// Takes a command of the plan, whose cycle takes `clock`; gives, by bits, which axes come back at it.
    pub(super) fn take(&mut self, sample: &Sample, axes: &[AxisInfo], clock: Clock) -> u32 {
        let speeds = axes.iter().map(|info| sample.velocity[info.id]);
        self.step(speeds, sample.feed_part <= 0.0, clock.period_s())
    }

    /// The same by the speeds of the axes; whether they are those of a rapid; for a time, s.
    fn step(&mut self, speeds: impl Iterator<Item = f64>, rapid: bool, period_s: f64) -> u32 {
        let mut returned = 0;
        for (axis, (turn, speed)) in self.turns.iter_mut().zip(speeds).enumerate() {
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
            let rested_s = std::mem::take(&mut self.rested_s[axis]);
            if speed != 0.0 {
                turn.0 = speed;
                // a rapid ends within the move that it is blended into
                if rested_s > 0.0 {
                    self.rapid[axis] = rapid;
                }
                self.aside[axis] = false;
            } else {
                self.rested_s[axis] = rested_s + period_s;
            }
        }
        if returned != 0 {
            self.note(returned);
        }
        let moving = self.rested_s.iter().filter(|rested_s| **rested_s <= 0.0);
        if returned != 0 || moving.count() >= SEVERAL {
            for (aside, rested_s) in self.aside.iter_mut().zip(&self.rested_s) {
                *aside |= *rested_s > ASIDE_REST_S;
            }
        }
        returned
    }

    /// Whether an axis rests while others come and go: its error is across what they move, and has nothing to do
    /// with theirs.
    pub(super) fn is_aside(&self, axis: usize) -> bool {
        self.aside.get(axis).copied().unwrap_or(false)
    }

    /// Whether an axis has only been brought to where it will cut: it sets out next, and whether it comes back then is
    /// not known.
    pub(super) fn is_to_cut(&self, axis: usize) -> bool {
        let mut others = self.turns.iter().enumerate();
        self.rapid[axis]
            && self.rested_s[axis] < LONG_REST_S
            && !others.any(|(other, (_, count))| other != axis && *count >= OTHERS_RETURNS)
    }

    /// Notes, by bits, which axes come back now.
    pub(super) fn note(&mut self, returned: u32) {
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

    /// Counts, by bits, those that came back while measuring.
    pub(super) fn count(&mut self, returned: u32) {
        for (axis, counted) in self.counted.iter_mut().enumerate() {
            *counted += (returned >> axis) & 1;
        }
    }

    /// Whether each axis came back so often since measuring began; one that never does need not.
    pub(super) fn came_back(&self, times: u32) -> bool {
        self.all_came_back(times, f64::INFINITY)
    }

    /// The same, while one that rests for long need not, either: the tool axis comes back before the others are
    /// known, and not again while they cut.
    pub(super) fn came_back_or_rests(&self, times: u32) -> bool {
        self.all_came_back(times, LONG_REST_S)
    }

    fn all_came_back(&self, times: u32, long_s: f64) -> bool {
        let axes = self.stays.iter().zip(&self.rested_s).zip(&self.counted);
        let mut enough = axes
            .map(|((stays, rested_s), counted)| *stays || *rested_s > long_s || *counted >= times);
        enough.all(|enough| enough) && self.counted.iter().any(|counted| *counted > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_that_rests_for_long_need_not_come_back() {
        let mut returns = Returns::new(2);
        (returns.stays, returns.counted) = (vec![false; 2], vec![2, 0]);
        assert!(!returns.came_back(2));
        returns.rested_s = vec![0.0, 2.5];
        assert!(returns.came_back_or_rests(2) && !returns.came_back_or_rests(3));
        assert!(!returns.came_back(2));
        // somebody has to
        (returns.rested_s, returns.counted) = (vec![2.5; 2], vec![0; 2]);
        assert!(!returns.came_back_or_rests(1));
    }

    /// Two axes move at these speeds for a time, s.
    fn moves(returns: &mut Returns, seconds: f64, speeds: [f64; 2], rapid: bool) {
        for _ in 0..(seconds * 1e3) as usize {
            returns.step(speeds.into_iter(), rapid, 1e-3);
        }
    }

    #[test]
    fn an_axis_rests_aside_while_another_one_comes_back_until_it_moves() {
        let mut returns = Returns::new(2);
        for (seconds, speeds, aside) in [
            (0.5, [1.0, 1.0], false),
            (1.0, [1.0, 0.0], false),
            (0.1, [-1.0, 0.0], true),
            (0.1, [-1.0, 1.0], false),
            // it has just come to rest at the end of a figure
            (0.1, [1.0, 0.0], false),
        ] {
            moves(&mut returns, seconds, speeds, false);
            assert_eq!(returns.is_aside(1), aside, "{speeds:?}");
        }
    }

    #[test]
    fn an_axis_is_to_cut_where_a_rapid_has_brought_it_until_it_sets_out_or_rests_for_long() {
        let mut returns = Returns::new(2);
        moves(&mut returns, 0.1, [0.0, 0.0], true);
        moves(&mut returns, 0.1, [10.0, 0.0], true);
        // the rapid is blended into the cut
        moves(&mut returns, 0.01, [1.0, 0.0], false);
        moves(&mut returns, 0.2, [0.0, -1.0], false);
        assert!(returns.is_to_cut(0) && !returns.is_to_cut(1));
        moves(&mut returns, 0.2, [1.0, 0.0], false);
        assert!(!returns.is_to_cut(0));
        moves(&mut returns, 0.2, [0.0, 0.0], false);
        moves(&mut returns, 0.2, [1.0, 0.0], true);
        moves(&mut returns, 1.0, [0.0, 0.0], false);
        assert!(returns.is_to_cut(0));
        moves(&mut returns, 1.5, [0.0, 0.0], false);
        assert!(!returns.is_to_cut(0));
    }
}
