//! Which parts of a motion are worth changing.

use crate::demand::Interval;
use crate::motion::{Knot, PathState, states};

/// Steps at an end at rest that are left as they are: b(s) has no bounded derivatives there. A
/// choice: the steps of the longest window (`WINDOW_INTERVALS`).
const REST_STEPS: usize = 5;
/// Steps that are left as they are on either side of where the motion nearly stands still. A
/// choice: enough that intervals beside them move forward.
const SLOW_STEPS: usize = 2;
/// Steps of a steady speed at the limit that belong to the free part beside it. A choice: the steps
/// of the longest window, over which acceleration is built up.
const STEADY_STEPS: usize = 8;
/// Steps of a motion above which it is left as it is. A choice: at a millisecond twelve days, and a
/// step that is no time at all would need memory without end.
const MOST_STEPS: f64 = 1e9;
/// Part of a cap from which on it counts as met. A choice: what is missing is worth less than the
/// least gain asked for.
const CAP_MET: f64 = 0.9995;

/// Part of a motion, in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) from: f64,
    pub(super) to: f64,
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
    step_s: f64,
) -> Kind {
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
    } else if a == 0.0
        && next == 0.0
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

/// Marks a step and its neighbours.
fn mark(steps: &mut [bool], k: usize, beside: usize, value: bool) {
    steps
        .iter_mut()
        .take(k + beside + 1)
        .skip(k.saturating_sub(beside))
        .for_each(|step| *step = value);
}

/// The parts of a motion that may become faster, each of at least `least` steps.
pub(super) fn spans(base: &[Knot], intervals: &[Interval], step_s: f64, least: usize) -> Vec<Span> {
    let (Some(first), Some(last)) = (base.first(), base.last()) else {
        return Vec::new();
    };
    let steps = (last.t / step_s).floor();
    if !(0.0..MOST_STEPS).contains(&steps) {
        return Vec::new();
    }
    let count = steps as usize;
    let mut intervals = intervals.iter();
    let states = states(base, (0..count + 2).map(|k| k as f64 * step_s));
    let kinds: Vec<Kind> = states
        .windows(2)
        .map(|pair| kind(pair[0], pair[1].a, &mut intervals, step_s))
        .collect();
    let mut free: Vec<bool> = kinds.iter().map(|kind| *kind == Kind::Free).collect();
    // A free part takes in some of the steady motion beside it, in which it may begin to change the
    // speed earlier.
    for (k, _) in kinds
        .iter()
        .enumerate()
        .filter(|(_, kind)| **kind == Kind::Free)
    {
        mark(&mut free, k, STEADY_STEPS, true);
    }
    // Nothing near rest. This comes last, since it counts more.
    for (k, _) in kinds
        .iter()
        .enumerate()
        .filter(|(_, kind)| **kind == Kind::Slow)
    {
        mark(&mut free, k, SLOW_STEPS, false);
    }
    let rests = |knot: &Knot| if knot.v > 0.0 { 0 } else { REST_STEPS };
    let tail = free.len().saturating_sub(rests(last));
    free.iter_mut()
        .take(rests(first))
        .for_each(|step| *step = false);
    free.iter_mut().skip(tail).for_each(|step| *step = false);
    let mut out = Vec::new();
    let mut k = 0;
    while k < free.len() {
        let steps = free.iter().skip(k).take_while(|free| **free).count();
        if steps > least {
            // The last step of a motion that goes on is not a whole one.
            let to = if k + steps > count && last.v > 0.0 {
                last.t
            } else {
                (k + steps - 1) as f64 * step_s
            };
            out.push(Span {
                from: k as f64 * step_s,
                to,
            });
        }
        k += steps.max(1);
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
        let found = spans(&steady(), &[], 0.125, 3);
        assert_eq!(found, [Span { from: 0.0, to: 2.0 }]);
    }

    #[test]
    fn steps_that_do_not_divide_a_motion_leave_it_as_it_is() {
        for step_s in [0.0, -0.125, f64::NAN, 1e-300] {
            assert_eq!(spans(&steady(), &[], step_s, 3), [], "{step_s}");
        }
    }
}
