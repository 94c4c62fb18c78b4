//! Judges the retimed samples from outside, and makes room where a joint passes a limit: the
//! limits of the intervals around it are tightened before the window is solved again, or the pace
//! is lowered there.

use super::problem::End;
use super::warp::Placed;
use crate::PlannerConfig;
use lostmotion_base::Coords;

/// Number of consecutive positions that a third difference, the discrete jerk, needs.
pub(super) const DIFFERENCE_POINTS: usize = 4;
/// Part of a limit by which rounding of positions may pass it.
const ROUNDING_SHARE: f64 = 1e-7;
/// Part of a limit that is taken away beyond the excess, so that the next solution does not end
/// just beyond it again. Tuned (2e-4 before samples were judged from outside).
pub(super) const TIGHTEN_MARGIN: f64 = 5e-4;
/// Half width of a dip of the pace in units of sqrt(v/j): so wide that the dip's own change of pace
/// costs less jerk than the lower pace saves. A choice: narrower dips add jerk, wider ones lengthen
/// the motion.
const DIP_WIDTH: f64 = 3.5;
/// Depth of a dip of beta for each part by which a limit is passed. A choice: a tenth more than
/// needed, so that few dips are needed.
const DIP_DEPTH: f64 = 1.1;
/// Deepest dip at once, as a part of beta. A choice: a deeper one could pass limits by itself.
const DEEPEST_DIP: f64 = 0.5;
/// Coefficients next to a given state that no dip changes, and over how many more its depth grows
/// to the whole. A choice: a given state fixes the first ones, and a steeper growth would cost
/// jerk.
const FIXED_COEFFICIENTS: usize = 4;
const TAPER_COEFFICIENTS: f64 = 60.0;

/// Intervals, each with the part of its limits of acceleration and jerk that is left to it.
pub(super) type Excess = Vec<(usize, [f64; 2])>;

/// The part of a limit that is passed where this part of it is left.
pub(super) fn passed(left: f64) -> f64 {
    ((1.0 - TIGHTEN_MARGIN) / left - 1.0).max(0.0)
}

/// Holds differences of the samples against the joints' limits.
#[derive(Clone, Debug)]
pub(crate) struct LimitJudge {
    /// By joint: index, limits of acceleration and jerk times the second and third power of the
    /// period.
    joints: Vec<(usize, [f64; 2])>,
    /// The last positions that were output.
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

    /// The intervals around samples that pass a limit, each with the part of its limits of
    /// acceleration and jerk that is left to it; `intervals` is the number of all.
    pub(super) fn excess(&self, batch: &[Placed], intervals: usize) -> Excess {
        let Some(Placed { sample: first, .. }) = batch.first() else {
            return Vec::new();
        };
        // Before its first sample the motion has rested.
        let before = if self.before.is_empty() {
            vec![first.position; DIFFERENCE_POINTS - 1]
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
        for end in DIFFERENCE_POINTS - 1..lead + batch.len() {
            let points = [3, 2, 1, 0].map(|back| place(end - back));
            let parts = self.parts(points);
            for (kind, part) in parts
                .into_iter()
                .enumerate()
                .filter(|(_, part)| *part > 1.0 + ROUNDING_SHARE)
            {
                // A difference of order n reaches back n samples. The intervals under them, and one
                // more on either side, get less room.
                let around = interval(end - 2 - kind).saturating_sub(1)
                    ..=(interval(end) + 1).min(intervals - 1);
                scales[around]
                    .iter_mut()
                    .for_each(|scale| scale[kind] = scale[kind].min((1.0 - TIGHTEN_MARGIN) / part));
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
    fn parts(&self, points: [&Coords; DIFFERENCE_POINTS]) -> [f64; 2] {
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

    /// Keeps the last positions of the samples that are output.
    pub(super) fn pass(&mut self, batch: &[Placed]) {
        if self.before.is_empty()
            && let Some(Placed { sample: first, .. }) = batch.first()
        {
            self.before = vec![first.position; DIFFERENCE_POINTS - 1];
        }
        self.before.extend(
            batch
                .iter()
                .rev()
                .take(DIFFERENCE_POINTS - 1)
                .rev()
                .map(|placed| placed.sample.position),
        );
        let excess = self.before.len().saturating_sub(DIFFERENCE_POINTS - 1);
        self.before.drain(..excess);
    }

    /// Whether positions at even times keep the limits but for a part.
    pub(crate) fn keep(&self, positions: &[Coords], part: f64) -> bool {
        positions.windows(DIFFERENCE_POINTS).all(|p| {
            self.parts([&p[0], &p[1], &p[2], &p[3]])
                .into_iter()
                .all(|reached| reached <= 1.0 + part)
        })
    }

    /// Takes the last positions that were output by other means.
    pub(super) fn follow(&mut self, before: Vec<Coords>) {
        self.before = before;
    }
}

/// How wide a dip of the pace is, in steps of nominal time, for the ratios of velocity to jerk of
/// the joints.
pub(super) fn width(limits: impl Iterator<Item = [f64; 3]>, step_s: f64) -> f64 {
    DIP_WIDTH * limits.map(|[v, _, j]| (v / j).sqrt()).fold(0.0, f64::max) / step_s
}

/// Lowers the coefficients of beta around what passes a limit; those that are given stay.
pub(super) fn dip(x: &mut [f64], excess: &Excess, width: f64, ends: [End; 2]) {
    let mut less = vec![0.0_f64; x.len()];
    for (interval, scale) in excess {
        let depth = (DIP_DEPTH * (1.0 - scale[0].min(scale[1]))).min(DEEPEST_DIP);
        let (center, reach) = (*interval as f64 + 1.0, width.ceil() as usize);
        let around = (interval + 1).saturating_sub(reach)..(interval + 1 + reach).min(x.len());
        for (index, less) in less[around.clone()].iter_mut().enumerate() {
            let away = ((around.start + index) as f64 - center) / width;
            // A bump of continuous slope; where dips overlap the deeper one counts.
            let bump = (1.0 - away * away).max(0.0);
            *less = less.max(depth * bump * bump);
        }
    }
    let last = x.len() - 1;
    let part = |end: End, away: usize| {
        if end == End::Moving {
            (away.saturating_sub(FIXED_COEFFICIENTS) as f64 / TAPER_COEFFICIENTS).min(1.0)
        } else {
            1.0
        }
    };
    // The given end states stay, with a smooth onset beside them.
    for (index, (x, less)) in x.iter_mut().zip(less).enumerate() {
        let part = part(ends[0], index).min(part(ends[1], last - index));
        *x *= 1.0 - less * part * part * (3.0 - 2.0 * part);
    }
}
