//! Where an axis stands still, and the reversal value of ISO 230-2 that it shows there.

use std::collections::BTreeMap;

/// A reference that moves by less within a tick stands still, in units of the axis.
const STILL: f64 = 1e-9;
/// Rest after which the load counts as settled, and for how long it is then averaged at least, s.
/// Choices: a servo settles in some 30 ms.
const SETTLE_S: f64 = 0.1;
const AVERAGE_S: f64 = 0.05;
/// Places that count as the same target, in units of the axis: 1 um or 1 mdeg.
const SAME: f64 = 1e-3;
/// Most targets that are kept. A choice that bounds the memory.
const MOST_TARGETS: usize = 500;

/// Mean deviation of the load at a target, of the approaches from one side.
#[derive(Clone, Copy, Debug, Default)]
struct Approaches {
    sum: f64,
    count: u32,
}

impl Approaches {
    fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / f64::from(self.count))
    }
}

/// The rests of an axis.
#[derive(Clone, Debug, Default)]
pub(super) struct RestRecorder {
    last: Option<f64>,
    /// Direction of the last motion; 0 until there was one.
    direction: i8,
    /// How far it has come in that direction.
    farthest: f64,
    rest_s: f64,
    /// Deviations of the rest at hand once it has settled.
    sum: f64,
    averaged_s: f64,
    count: u32,
    /// By target: approached upwards, approached downwards.
    targets: BTreeMap<i64, [Approaches; 2]>,
}

/// Reversal value of an axis after ISO 230-2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ReversalValue {
    /// Largest difference of the mean deviation at a target between both directions of approach, in
    /// the unit of the axis.
    pub(super) value: f64,
    /// Where that is.
    pub(super) target: f64,
    /// Targets that were approached in both directions.
    pub(super) targets: usize,
}

impl RestRecorder {
    /// Takes a tick.
    pub(super) fn push(&mut self, reference: f64, load: f64, tick_s: f64) {
        let way = self.last.map_or(0.0, |last| reference - last);
        if self.last.is_none() {
            self.farthest = reference;
        }
        if way.abs() > STILL {
            self.end();
            self.turn(reference);
        } else {
            self.rest_s += tick_s;
            if self.rest_s > SETTLE_S {
                self.sum += load - reference;
                self.averaged_s += tick_s;
                self.count += 1;
            }
        }
        self.last = Some(reference);
    }

    /// A direction is another one once it leads away from the farthest place: a reference between two
    /// commands overshoots a stop by nanometres.
    fn turn(&mut self, reference: f64) {
        let back = reference - self.farthest;
        if back.abs() > SAME && (back > 0.0) != (self.direction > 0) {
            self.direction = if back > 0.0 { 1 } else { -1 };
        }
        if self.direction != 0 && (back > 0.0) == (self.direction > 0) {
            self.farthest = reference;
        }
    }

    /// A rest is over.
    fn end(&mut self) {
        if let Some(place) = self.last
            && self.direction != 0
            && self.averaged_s >= AVERAGE_S
        {
            let target = (place / SAME).round() as i64;
            if self.targets.len() < MOST_TARGETS || self.targets.contains_key(&target) {
                let sides = self.targets.entry(target).or_default();
                let [up, down] = sides;
                let side = if self.direction > 0 { up } else { down };
                side.sum += self.sum / f64::from(self.count.max(1));
                side.count += 1;
            }
        }
        (self.rest_s, self.sum, self.averaged_s, self.count) = (0.0, 0.0, 0.0, 0);
    }

    /// The reversal value, if the axis stood at some target after motion in both directions.
    pub(super) fn finish(mut self) -> Option<ReversalValue> {
        self.end();
        let both: Vec<(i64, f64)> = self
            .targets
            .iter()
            .filter_map(|(target, [up, down])| Some((*target, up.mean()? - down.mean()?)))
            .collect();
        let (target, value) = both
            .iter()
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
            .copied()?;
        Some(ReversalValue {
            value: value.abs(),
            target: target as f64 * SAME,
            targets: both.len(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Strokes between two targets with a rest at each; the load is behind by half a gap that grows
    /// along the travel.
    #[test]
    fn the_largest_difference_at_a_target_is_the_reversal_value() {
        let tick = 1e-3;
        let mut axis = RestRecorder::default();
        let mut at = 0.0;
        for target in [10.0, 20.0, 30.0, 20.0, 10.0, 0.0, 10.0, 20.0, 5.0] {
            let direction = if target > at { 1.0 } else { -1.0 };
            let gap = |place: f64| 0.010 + 0.0002 * place;
            while (target - at) * direction > 1e-9 {
                at += 0.1 * direction;
                axis.push(at, at - 0.5 * gap(at) * direction, tick);
            }
            // Of an interpolator that overshoots.
            axis.push(
                target + 1e-6 * direction,
                at - 0.5 * gap(at) * direction,
                tick,
            );
            at = target;
            for _ in 0..200 {
                axis.push(at, at - 0.5 * gap(at) * direction, tick);
            }
        }
        let found = axis.finish().unwrap();
        assert_eq!(found.targets, 2);
        assert!((found.value - 0.014).abs() < 1e-12, "{found:?}");
        assert!((found.target - 20.0).abs() < 1e-9);
    }

    #[test]
    fn short_rests_and_one_direction_tell_nothing() {
        for rest in [100, 300] {
            let mut axis = RestRecorder::default();
            for step in 0..4 {
                for _ in 0..rest {
                    axis.push(f64::from(step), f64::from(step) - 0.005, 1e-3);
                }
            }
            assert_eq!(axis.finish(), None);
        }
    }
}
