//! Looks at samples from the outside, and takes room away where a joint passes its limits.

use crate::{PlannerConfig, Sample};
use lostmotion_base::Coords;

/// Differences reach over so many samples.
const REACH: usize = 4;
/// What passes a limit by no more than this part is rounding.
const ROUNDING: f64 = 2e-4;
/// Room is taken away by a little more than what was passed.
const MORE: f64 = 2e-4;

/// Holds differences of the samples against the joints' limits.
#[derive(Clone, Debug)]
pub(super) struct Judge {
    /// By joint: index, limits of acceleration and jerk times the second and third power of the period.
    joints: Vec<(usize, [f64; 2])>,
    /// The last positions that were given out.
    before: Vec<Coords>,
}

impl Judge {
    pub(super) fn new(config: &PlannerConfig) -> Judge {
        let period = config.clock.period_s();
        let joint = |(index, limits): (usize, &Option<lostmotion_base::AxisLimits>)| {
            limits.map(|l| (index, [l.acceleration * period * period, l.jerk * period * period * period]))
        };
        Judge { joints: config.limits.iter().enumerate().filter_map(joint).collect(), before: Vec::new() }
    }

    /// Takes room away from the intervals around what passes a limit; gives by which part the limits are passed at most.
    pub(super) fn tighten(&self, batch: &[(usize, Sample)], room: &mut [[f64; 2]]) -> f64 {
        let Some((_, first)) = batch.first() else { return 0.0 };
        let before = if self.before.is_empty() { vec![first.position; REACH - 1] } else { self.before.clone() };
        let lead = before.len();
        let place = |index: usize| if index < lead { &before[index] } else { &batch[index - lead].1.position };
        let interval = |index: usize| batch[index.saturating_sub(lead).min(batch.len() - 1)].0;
        let mut worst = 0.0_f64;
        let mut scale = vec![[1.0_f64; 2]; room.len()];
        for end in 3..lead + batch.len() {
            let [p0, p1, p2, p3] = [3, 2, 1, 0].map(|back| place(end - back));
            for (joint, limits) in &self.joints {
                let [p0, p1, p2, p3] = [p0.0[*joint], p1.0[*joint], p2.0[*joint], p3.0[*joint]];
                let second = (p3 - p2) - (p2 - p1);
                let third = second - ((p2 - p1) - (p1 - p0));
                for (kind, (value, from)) in [(second, 2), (third, 3)].into_iter().enumerate() {
                    let part = value.abs() / limits[kind];
                    if part > 1.0 + ROUNDING {
                        worst = worst.max(part - 1.0);
                        let around = interval(end - from).saturating_sub(1)..=(interval(end) + 1).min(room.len() - 1);
                        scale[around].iter_mut().for_each(|scale| scale[kind] = scale[kind].min((1.0 - MORE) / part));
                    }
                }
            }
        }
        for (room, scale) in room.iter_mut().zip(scale) {
            *room = [room[0] * scale[0], room[1] * scale[1]];
        }
        worst
    }

    /// Takes note of what is given out.
    pub(super) fn pass(&mut self, batch: &[(usize, Sample)]) {
        if self.before.is_empty()
            && let Some((_, first)) = batch.first()
        {
            self.before = vec![first.position; REACH - 1];
        }
        self.before.extend(batch.iter().rev().take(REACH - 1).rev().map(|(_, sample)| sample.position));
        let excess = self.before.len().saturating_sub(REACH - 1);
        self.before.drain(..excess);
    }
}
