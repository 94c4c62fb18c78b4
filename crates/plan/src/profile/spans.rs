//! Which parts of a motion are worth changing.

use crate::demand::Interval;
use crate::motion::{Knot, PathState, states};

/// Steps at an end at rest that are left as they are: b(s) has no bounded derivatives there. A
/// choice: the steps of the longest window (`WINDOW_INTERVALS`).
const REST_STEPS: usize = 8;
/// Steps that are left as they are on either side of where the motion nearly stands still. A
/// choice: enough that intervals beside them move forward.
const SLOW_STEPS: usize = 2;
/// Steps of a steady speed at the limit that belong to the free part beside it. A choice: the steps
/// of the longest window, over which acceleration is built up.
const STEADY_STEPS: usize = 8;
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

/// The parts of a motion that may become faster, each of at least `least` steps.
pub(super) fn spans(base: &[Knot], intervals: &[Interval], step_s: f64, least: usize) -> Vec<Span> {
    let (Some(first), Some(last)) = (base.first(), base.last()) else {
        return Vec::new();
    };
    let count = (last.t / step_s).floor() as usize;
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
        free[k.saturating_sub(STEADY_STEPS)..(k + STEADY_STEPS + 1).min(count + 1)].fill(true);
    }
    // Nothing near rest. This comes last, since it counts more.
    for (k, _) in kinds
        .iter()
        .enumerate()
        .filter(|(_, kind)| **kind == Kind::Slow)
    {
        free[k.saturating_sub(SLOW_STEPS)..(k + SLOW_STEPS + 1).min(count + 1)].fill(false);
    }
    let rests = |knot: &Knot| if knot.v > 0.0 { 0 } else { REST_STEPS };
    let (head, tail) = (
        rests(first).min(free.len()),
        free.len().saturating_sub(rests(last)),
    );
    free[..head].fill(false);
    free[tail..].fill(false);
    let mut out = Vec::new();
    let mut k = 0;
    while k <= count {
        let steps = free[k..].iter().take_while(|free| **free).count();
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
