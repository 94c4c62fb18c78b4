//! What part of the limits a motion uses.

use super::course::{Course, Place};
use super::{Knot, Motion};
use crate::machine::Machine;

/// Places looked at over each knot's time, besides both sides of where pieces meet.
const PLACES: usize = 2;

/// Largest part used of the limits of velocity (feed included), acceleration and jerk.
fn at(machine: &Machine, place: &Place, motion: &Motion, j: f64) -> [f64; 3] {
    let Motion { v, a, .. } = *motion;
    let mut most = [v / place.feed, 0.0, 0.0];
    for (joint, limits) in machine.joints() {
        let [d1, d2, d3] = place.d.map(|d| d[joint]);
        let used = [d1 * v, d1 * a + d2 * v * v, d1 * j + (3.0 * d2 * a + d3 * v * v) * v];
        for kind in 0..3 {
            most[kind] = most[kind].max(used[kind].abs() / limits[kind]);
        }
    }
    most
}

/// The same over consecutive knots, of which the last one is only an end; none where the machine cannot be.
pub(crate) fn usage(machine: &Machine, course: &mut Course<'_>, knots: &[Knot]) -> Option<[f64; 3]> {
    let mut most = [0.0_f64; 3];
    for pair in knots.windows(2) {
        for k in 0..=PLACES {
            let motion = pair[0].at(pair[0].t + (pair[1].t - pair[0].t) * (k as f64 / PLACES as f64));
            let used = at(machine, &course.at(motion.s)?, &motion, pair[0].j);
            most = [0, 1, 2].map(|kind| most[kind].max(used[kind]));
        }
    }
    Some(most)
}
