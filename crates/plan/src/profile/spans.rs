//! Which parts of a motion are worth changing.

use super::steps::Steps;
use crate::demand::Interval;
use crate::motion::{Knot, PathState, state_at, states};
use std::ops::Range;

/// Finest steps that are left as they are on either side of where the motion nearly stands still. A
/// choice: enough that intervals beside them move forward.
const SLOW_STEPS: usize = 2;
/// Usual steps of a steady speed at the limit that belong to the free part beside it. A choice: most
/// of the longest window, over which acceleration is built up.
const STEADY_STEPS: f64 = 8.0;
/// Finest steps of a motion above which it is left as it is. A choice: hours, and a step that is no
/// time at all would have no end.
const MOST_STEPS: f64 = 1e8;
/// Finest steps of a part that is worth it. A choice: some intervals to either side of one that is
/// free; shorter parts have little to gain.
const LEAST_STEPS: usize = 18;
/// Part of a cap from which on it counts as met, where the speed changes by no more than the rest over a
/// usual step: the cap follows the parameter of a curve, which goes as the length does but for parts in
/// 10,000. A choice: what is missing is worth less than the least gain asked for.
const CAP_MET: f64 = 0.9995;

/// Part of a motion, in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Span {
    /// Whether it is long enough to be worth it.
    pub(super) fn is_long(&self, steps: &Steps) -> bool {
        self.to - self.from > LEAST_STEPS as f64 * steps.finest_s
    }
}

/// What a step of the motion is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// May get faster.
    Free,
    /// As fast as it may ever be.
    Steady,
    /// At rest or nearly so.
    Slow,
}

/// From the states now and a step later, whose acceleration is at least as telling as that of now.
fn kind(
    PathState { s, v, a }: PathState,
    next: f64,
    intervals: &mut std::slice::Iter<'_, Interval>,
    steps: &Steps,
) -> Kind {
    let step_s = steps.finest_s;
    while intervals
        .as_slice()
        .get(1)
        .is_some_and(|interval| interval.start <= s)
    {
        intervals.next();
    }
    // So slow that the acceleration could take the speed away within a step.
    if v <= a.abs().max(next.abs()).max((next - a).abs()) * step_s {
        Kind::Slow
    } else if a.abs().max(next.abs()) * steps.usual_s <= (1.0 - CAP_MET) * v
        && intervals
            .as_slice()
            .first()
            .is_some_and(|interval| v >= interval.cap * CAP_MET)
    {
        Kind::Steady
    } else {
        Kind::Free
    }
}

/// Adds a run of steps behind those there are, of which the last one may overlap it.
fn add(runs: &mut Vec<Range<usize>>, run: Range<usize>) {
    match runs.last_mut().filter(|last| run.start <= last.end) {
        Some(last) => last.end = last.end.max(run.end),
        None => runs.push(run),
    }
}

/// The parts of a motion that may become faster, but for these times at its ends. Runs of steps of
/// one kind are all that is held.
pub(super) fn spans(
    base: &[Knot],
    intervals: &[Interval],
    steps: &Steps,
    rests_s: [f64; 2],
) -> Vec<Span> {
    let Some(last) = base.last() else {
        return Vec::new();
    };
    let step_s = steps.finest_s;
    let count = (last.t / step_s).floor();
    if !(0.0..MOST_STEPS).contains(&count) {
        return Vec::new();
    }
    let count = count as usize;
    let beside = (STEADY_STEPS * steps.usual_s / step_s).round() as usize;
    let rests = rests_s.map(|rest_s| (rest_s / step_s).round() as usize);
    let mut intervals = intervals.iter();
    // A free part takes in some of the steady motion beside it, in which it may begin to change the
    // speed earlier, and nothing near rest.
    let (mut free, mut slow) = (Vec::new(), Vec::new());
    add(&mut slow, 0..rests[0]);
    let mut now = state_at(base, 0.0);
    let later = states(base, (1..count + 2).map(|k| k as f64 * step_s));
    for (k, next) in later.enumerate() {
        match kind(now, next.a, &mut intervals, steps) {
            Kind::Free => add(&mut free, k.saturating_sub(beside)..k + beside + 1),
            Kind::Slow => add(&mut slow, k.saturating_sub(SLOW_STEPS)..k + SLOW_STEPS + 1),
            Kind::Steady => {}
        }
        now = next;
    }
    add(&mut slow, (count + 1).saturating_sub(rests[1])..count + 1);
    let mut out = Vec::new();
    for run in free {
        let mut from = run.start;
        let end = run.end.min(count + 1);
        let within = slow
            .iter()
            .filter(|slow| slow.start < end && slow.end > run.start);
        for slow in within.chain([&(end..end)]) {
            if slow.start.saturating_sub(from) > LEAST_STEPS {
                // The last step of a motion that goes on is not a whole one.
                let to = if slow.start > count && last.v > 0.0 {
                    last.t
                } else {
                    (slow.start - 1) as f64 * step_s
                };
                out.push(Span {
                    from: from as f64 * step_s,
                    to,
                });
            }
            from = from.max(slow.end);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 s at a steady 5 mm/s.
    fn steady() -> [Knot; 2] {
        [0.0, 2.0].map(|t| Knot {
            t,
            s: 5.0 * t,
            v: 5.0,
            a: 0.0,
            j: 0.0,
        })
    }

    #[test]
    fn a_motion_without_caps_is_free_from_end_to_end() {
        let steps = Steps {
            usual_s: 0.5,
            finest_s: 0.0625,
        };
        let found = spans(&steady(), &[], &steps, [0.0; 2]);
        assert_eq!(found, [Span { from: 0.0, to: 2.0 }]);
    }

    #[test]
    fn steps_that_do_not_divide_a_motion_leave_it_as_it_is() {
        for step_s in [0.0, -0.125, f64::NAN, 1e-300] {
            let steps = Steps {
                usual_s: 8.0 * step_s,
                finest_s: step_s,
            };
            assert_eq!(spans(&steady(), &[], &steps, [0.0; 2]), [], "{step_s}");
        }
    }
}
