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
}

impl Returns {
    pub(super) fn new(axes: usize) -> Returns {
        Returns {
            turns: vec![(0.0, 0); axes],
            since: vec![vec![0; axes]; axes],
            stays: vec![true; axes],
            counted: vec![0; axes],
            rested_s: vec![0.0; axes],
        }
    }

    /// Takes a command of the plan, whose cycle takes `clock`; gives, by bits, which axes come back at it.
    pub(super) fn take(&mut self, sample: &Sample, axes: &[AxisInfo], clock: Clock) -> u32 {
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
            self.rested_s[axis] += clock.period_s();
            if speed != 0.0 {
                turn.0 = speed;
                self.rested_s[axis] = 0.0;
            }
        }
        if returned != 0 {
            self.note(returned);
        }
        returned
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
}
