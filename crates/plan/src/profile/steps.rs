//! How long the intervals are in which a time law varies the motion.

use super::Section;
use crate::motion::{Knot, state_at};
use lostmotion_base::vec::{dot, norm};
use lostmotion_path::Curve;

/// Intervals in the longest time over which a moving joint builds up its acceleration. A choice:
/// more follow the limits closer and cost time in proportion; with eight zigzags take 0.5 to 2 %
/// longer.
const WINDOW_INTERVALS: f64 = 12.0;
/// Fewest usual intervals in a motion. A choice: a motion much shorter than the joints' windows has
/// no less in it that changes. With 36 short programs take 0.5 % longer, with 100 0.3 % less.
const LEAST_COUNT: f64 = 60.0;
/// Part of the time v / |a|, over which the speed changes by its own size, that an interval takes,
/// and by how much that may make it shorter than usual. A choice: beside rest, where the speed grows
/// with t^2, an interval is a seventh of the time since then. Record 120 of the decisions gives what
/// it brings.
const CHANGE_PART: f64 = 0.3;
const FINEST_PART: f64 = 1.0 / 8.0;
/// Largest turn of a piece in one of its intervals, rad, and most intervals of a piece by its turn.
/// A choice: where the direction turns, what the limits leave of the jerk changes, and one jerk for
/// all of an interval is the least of them. With 3 degrees corners take 0.5 % longer.
const LARGEST_TURN: f64 = 0.026;
const MOST_BY_TURN: f64 = 8.0;
/// Shortest interval that ends where pieces meet, as a part of what it would be there. A choice: where
/// pieces are shorter the number of intervals stays.
const LEAST_STEP: f64 = 0.35;

/// Times of intervals, s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Steps {
    /// Where nothing asks for less.
    pub(super) usual_s: f64,
    /// Where the speed changes most.
    pub(super) finest_s: f64,
}

impl Steps {
    /// For the base of a section.
    pub(super) fn new(section: &Section<'_>) -> Steps {
        let window_s = section.machine.window_over_s(section.intervals);
        let lasts_s = section.base.last().map_or(0.0, |last| last.t);
        let usual_s = (window_s / WINDOW_INTERVALS).min(lasts_s / LEAST_COUNT);
        Steps {
            usual_s,
            finest_s: FINEST_PART * usual_s,
        }
    }

    /// At a time of the base.
    fn at(&self, base: &[Knot], t: f64) -> f64 {
        let state = state_at(base, t);
        let change_s = state.v / state.a.abs();
        // Nothing divided by nothing is no time that asks for less.
        if change_s.is_finite() {
            (CHANGE_PART * change_s).clamp(self.finest_s, self.usual_s)
        } else {
            self.usual_s
        }
    }

    /// Appends the ends of intervals up to `to`, a factor times as long as they would be.
    fn fill(&self, base: &[Knot], to: f64, factor: f64, times: &mut Vec<f64>) {
        let begin = times.len();
        let Some(from) = times.last().copied() else {
            return;
        };
        let mut t = from;
        while t < to {
            let step_s = self.at(base, t);
            t += factor * step_s.min(self.at(base, t + step_s));
            times.push(t);
        }
        // The last one went too far: as many as come nearest, stretched to end in time.
        let last = times.len() - 1;
        if last > begin && times[last] - to > to - times[last - 1] {
            times.pop();
        }
        let last = times.len() - 1;
        let scale = (to - from) / (times[last] - from);
        for time in &mut times[begin..] {
            *time = from + (*time - from) * scale;
        }
        times[last] = to;
    }

    /// Times of the base at which intervals begin, and the places of those at which it goes from
    /// piece to piece: third derivatives step there, and an interval with two of them has the limits
    /// of both.
    pub(super) fn times(
        &self,
        section: &Section<'_>,
        [begin, end]: [f64; 2],
    ) -> (Vec<f64>, Vec<(usize, f64)>) {
        let base = section.base;
        let mut times = vec![begin];
        let mut meetings = Vec::new();
        let fill = |times: &mut Vec<f64>, to: f64, turn: f64| {
            let begin = times.len();
            self.fill(base, to, 1.0, times);
            let by_turn = (turn / LARGEST_TURN).min(MOST_BY_TURN);
            let factor = (times.len() - begin) as f64 / by_turn;
            if factor < 1.0 {
                times.truncate(begin);
                self.fill(base, to, factor, times);
            }
        };
        let [first, last] = [begin, end].map(|t| state_at(base, t).s);
        let from = section.pieces.partition_point(|(start, _)| *start <= first);
        let mut index = base.partition_point(|knot| knot.t <= begin);
        let (mut before, mut turn) = (begin, 0.0);
        let ended = section.pieces.range(from.saturating_sub(1)..);
        for ((_, ended), (start, _)) in ended.zip(section.pieces.range(from..)) {
            if *start >= last {
                break;
            }
            while base.get(index).is_some_and(|knot| knot.s < *start) {
                index += 1;
            }
            let Some(knot) = index.checked_sub(1).and_then(|index| base.get(index)) else {
                continue;
            };
            let next = base.get(index).map_or(end, |next| next.t);
            let at = knot.time_at(*start, knot.t, next);
            turn += turned(&ended.curve);
            if (at - before).min(end - at) >= LEAST_STEP * self.at(base, at) {
                fill(&mut times, at, turn);
                meetings.push((times.len() - 1, *start));
                (before, turn) = (at, 0.0);
            }
        }
        fill(&mut times, end, 0.0);
        (times, meetings)
    }
}

/// By how much the direction of the tip changes from the start of a curve to its end, nearly rad.
fn turned(curve: &Curve) -> f64 {
    if matches!(curve, Curve::Line(_)) {
        return 0.0;
    }
    let [from, to] = [0.0, curve.length()].map(|s| curve.eval(s).d1.linear());
    let product = norm(from) * norm(to);
    if product > 0.0 {
        (2.0 - 2.0 * dot(from, to) / product).max(0.0).sqrt()
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEPS: Steps = Steps {
        usual_s: 0.08,
        finest_s: 0.01,
    };

    /// From rest with one jerk the speed is j t^2 / 2 and changes by its own size in t / 2; at a
    /// steady speed it does not.
    #[test]
    fn steps_grow_with_the_time_since_rest() {
        let base = [
            Knot {
                j: 6.0,
                ..Knot::default()
            },
            Knot {
                t: 1.0,
                s: 1.0,
                v: 3.0,
                a: 0.0,
                j: 0.0,
            },
            Knot {
                t: 4.0,
                s: 10.0,
                v: 3.0,
                a: 0.0,
                j: 0.0,
            },
        ];
        for (t, expected) in [
            (0.0, STEPS.usual_s),
            (0.01, STEPS.finest_s),
            (0.2, CHANGE_PART * 0.1),
            (0.9, STEPS.usual_s),
            (2.0, STEPS.usual_s),
        ] {
            let found = STEPS.at(&base, t);
            assert!((found - expected).abs() <= 1e-12, "{t}: {found}");
        }
        let mut times = vec![0.05];
        STEPS.fill(&base, 1.5, 1.0, &mut times);
        assert_eq!(times.last(), Some(&1.5));
        for pair in times.windows(2) {
            let step_s = pair[1] - pair[0];
            assert!(
                (0.9 * STEPS.finest_s..=1.1 * STEPS.usual_s).contains(&step_s),
                "{pair:?}"
            );
        }
    }

    #[test]
    fn the_last_interval_ends_in_time() {
        for to in [1e-6, 0.03, 0.1, 0.19, 0.21] {
            let mut times = vec![0.0];
            STEPS.fill(&[], to, 1.0, &mut times);
            assert_eq!(times.last(), Some(&to));
            assert!(times.windows(2).all(|pair| pair[1] > pair[0]), "{times:?}");
        }
    }
}
