//! Looks at samples from the outside, and takes room away where a joint passes its limits.

use super::trial::Placed;
use crate::PlannerConfig;
use lostmotion_base::Coords;

/// Differences reach over so many samples.
pub(super) const REACH: usize = 4;
/// What passes a limit by no more than this part is rounding.
const ROUNDING: f64 = 1e-7;
/// Room is taken away by a little more than what was passed.
const MORE: f64 = 5e-4;

/// Intervals, each with the part of its limits of acceleration and jerk that is left to it.
pub(super) type Excess = Vec<(usize, [f64; 2])>;

/// Holds differences of the samples against the joints' limits.
#[derive(Clone, Debug)]
pub(crate) struct LimitJudge {
    /// By joint: index, limits of acceleration and jerk times the second and third power of the
    /// period.
    joints: Vec<(usize, [f64; 2])>,
    /// The last positions that were given out.
    before: Vec<Coords>,
}

impl LimitJudge {
    pub(crate) fn new(config: &PlannerConfig) -> LimitJudge {
        let period = config.clock.period_s();
        let joint = |(index, limits): (usize, &Option<lostmotion_base::AxisLimits>)| {
            limits.map(|l| {
                (
                    index,
                    [
                        l.acceleration * period * period,
                        l.jerk * period * period * period,
                    ],
                )
            })
        };
        LimitJudge {
            joints: config.limits.iter().enumerate().filter_map(joint).collect(),
            before: Vec::new(),
        }
    }

    /// The intervals, out of so many, around what passes a limit, each with the part of its limits
    /// of acceleration and jerk that is left to it.
    pub(super) fn excess(&self, batch: &[Placed], intervals: usize) -> Excess {
        let Some(Placed { sample: first, .. }) = batch.first() else {
            return Vec::new();
        };
        let before = if self.before.is_empty() {
            vec![first.position; REACH - 1]
        } else {
            self.before.clone()
        };
        let lead = before.len();
        let place = |index: usize| {
            if index < lead {
                &before[index]
            } else {
                &batch[index - lead].sample.position
            }
        };
        let interval =
            |index: usize| batch[index.saturating_sub(lead).min(batch.len() - 1)].interval;
        let mut scales = vec![[1.0_f64; 2]; intervals];
        for end in REACH - 1..lead + batch.len() {
            let points = [3, 2, 1, 0].map(|back| place(end - back));
            let parts = self.parts(points);
            for (kind, part) in parts
                .into_iter()
                .enumerate()
                .filter(|(_, part)| *part > 1.0 + ROUNDING)
            {
                let around = interval(end - 2 - kind).saturating_sub(1)
                    ..=(interval(end) + 1).min(intervals - 1);
                scales[around]
                    .iter_mut()
                    .for_each(|scale| scale[kind] = scale[kind].min((1.0 - MORE) / part));
            }
        }
        scales
            .into_iter()
            .enumerate()
            .filter(|(_, scale)| scale[0] < 1.0 || scale[1] < 1.0)
            .collect()
    }

    /// Second and third differences of the last three and all four of the points as parts of what
    /// the joints' limits allow, the largest.
    fn parts(&self, points: [&Coords; REACH]) -> [f64; 2] {
        let mut parts = [0.0_f64; 2];
        for (joint, limits) in &self.joints {
            let [p0, p1, p2, p3] = points.map(|point| point.0[*joint]);
            let second = (p3 - p2) - (p2 - p1);
            let third = second - ((p2 - p1) - (p1 - p0));
            parts = [
                parts[0].max(second.abs() / limits[0]),
                parts[1].max(third.abs() / limits[1]),
            ];
        }
        parts
    }

    /// Takes note of what is given out.
    pub(super) fn pass(&mut self, batch: &[Placed]) {
        if self.before.is_empty()
            && let Some(Placed { sample: first, .. }) = batch.first()
        {
            self.before = vec![first.position; REACH - 1];
        }
        self.before.extend(
            batch
                .iter()
                .rev()
                .take(REACH - 1)
                .rev()
                .map(|placed| placed.sample.position),
        );
        let excess = self.before.len().saturating_sub(REACH - 1);
        self.before.drain(..excess);
    }

    /// Whether positions at even times keep the limits but for a part.
    pub(crate) fn keep(&self, positions: &[Coords], part: f64) -> bool {
        positions.windows(REACH).all(|p| {
            self.parts([&p[0], &p[1], &p[2], &p[3]])
                .into_iter()
                .all(|reached| reached <= 1.0 + part)
        })
    }

    /// Takes over the last positions of what was given out elsewhere.
    pub(super) fn follow(&mut self, before: Vec<Coords>) {
        self.before = before;
    }
}
