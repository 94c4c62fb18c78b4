//! Which change of pace to make, and when.

use super::course::{Course, PaceState};
use super::ramp::{Effort, Ramp};

/// Command cycles that a change may wait for a place where it can be made, if that makes it sooner
/// done.
const WAIT_CYCLES: [u32; 22] = [
    0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 64, 80, 96,
];
/// Parts of the most that the pace may change by that are tried, each with the part of the least
/// reach that joints which hardly move may count on.
const EFFORTS: [[f64; 2]; 8] = [
    [1.0, 0.5],
    [1.0, 0.0],
    [0.85, 0.0],
    [0.7, 0.0],
    [0.55, 0.0],
    [0.4, 0.0],
    [0.25, 0.0],
    [0.12, 0.0],
];
/// Parts of the pace aimed at that are tried where the plan leaves no room for all of it; the rest
/// follows with a later change.
const GOAL_PARTS: [f64; 9] = [1.0, 0.99, 0.97, 0.93, 0.85, 0.7, 0.5, 0.3, 0.1];
/// Difference from a pace up to which it is reached.
pub(super) const PACE_SLACK: f64 = 1e-6;

/// A change of pace that begins after `wait` command cycles.
#[derive(Clone, Debug)]
pub(super) struct Aim {
    pub(super) wait: u32,
    pub(super) ramp: Ramp,
}

/// The best change to a pace found: for less pace the one that is done first, for more the one that
/// gets nearest. `after` tells the state after a number of command cycles if nothing changes;
/// `None` if that is not known.
pub(super) fn aim(
    course: &Course,
    target: f64,
    period_s: f64,
    after: &dyn Fn(u32) -> Option<PaceState>,
) -> Option<Aim> {
    let now = after(0)?;
    if now.w < target {
        rise(course, target, &now)
    } else {
        fall(course, target, period_s, after)
    }
}

/// From the hardest to the gentlest.
fn efforts(course: &Course) -> impl Iterator<Item = Effort<'_>> {
    let reach = course.reach();
    EFFORTS.into_iter().map(move |[part, of]| Effort {
        course,
        part,
        reach: of * reach,
    })
}

fn fall(
    course: &Course,
    target: f64,
    period_s: f64,
    after: &dyn Fn(u32) -> Option<PaceState>,
) -> Option<Aim> {
    let mut best: Option<(f64, Aim)> = None;
    for wait in WAIT_CYCLES {
        // Later starts cannot be done before the best one found.
        let waited_s = f64::from(wait) * period_s;
        if best.as_ref().is_some_and(|(least, _)| waited_s >= *least) {
            break;
        }
        let Some(from) = after(wait) else { break };
        let found = efforts(course).find_map(|effort| effort.ramp(from, target));
        if let Some(ramp) = found {
            let done_s = waited_s + ramp.lasts_s();
            if best.as_ref().is_none_or(|(least, _)| done_s < *least) {
                best = Some((done_s, Aim { wait, ramp }));
            }
        }
    }
    best.map(|(_, aim)| aim)
}

fn rise(course: &Course, target: f64, now: &PaceState) -> Option<Aim> {
    let goals = GOAL_PARTS
        .into_iter()
        .map(|part| part * target)
        .filter(|goal| *goal > now.w + PACE_SLACK);
    // The nearest goal first, each with the hardest effort first.
    let mut tries = goals.flat_map(|goal| efforts(course).map(move |effort| (goal, effort)));
    tries
        .find_map(|(goal, effort)| effort.ramp(*now, goal))
        .map(|ramp| Aim { wait: 0, ramp })
}
