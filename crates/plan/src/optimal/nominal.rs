//! From a motion at even steps of time to the limits of its retiming.

use super::ends::End;
use super::problem::{MIDDLE, Problem, Rows};
use crate::Sample;
use lostmotion_base::{AXES, AxisLimits, Coords};

/// Joints slower than this part of their limits do not count.
const STILL: f64 = 1e-9;
/// The pace may change from standing still to that of the nominal motion in no less than about this
/// time, s: where the joints rest, nothing else would bound its jerk.
const SWIFTEST_S: f64 = 4e-3;

/// Whether the nominal motion rests.
fn rests(point: &Sample) -> bool {
    point.velocity == Coords::ZERO && point.acceleration == Coords::ZERO
}

/// A joint with its limits of velocity, acceleration and jerk.
#[derive(Clone, Copy, Debug)]
pub(super) struct RetimedJoint {
    pub(super) index: usize,
    pub(super) limits: [f64; 3],
}

/// The joints that have limits, each kept to a part of them: velocity, acceleration, jerk.
pub(super) fn joints(limits: &[Option<AxisLimits>; AXES], parts: [f64; 3]) -> Vec<RetimedJoint> {
    let joint = |(index, limits): (usize, &Option<AxisLimits>)| {
        let limits = (*limits)?;
        Some(RetimedJoint {
            index,
            limits: [
                limits.velocity * parts[0],
                limits.acceleration * parts[1],
                limits.jerk * parts[2],
            ],
        })
    };
    limits.iter().enumerate().filter_map(joint).collect()
}

/// Makes the limits of beta between each two of the points. `room` scales those of acceleration and
/// jerk by interval.
pub(super) fn limits(
    points: &[Sample],
    joints: &[RetimedJoint],
    step_s: f64,
    room: &[[f64; 2]],
    ends: [End; 2],
) -> Problem {
    let moving: Vec<RetimedJoint> = joints
        .iter()
        .filter(|joint| moves(points, joint))
        .copied()
        .collect();
    let intervals = points.len().saturating_sub(1);
    let mut problem = Problem {
        step_s,
        joints: moving.len() + 1,
        rows: Vec::with_capacity(intervals * (moving.len() + 1)),
        inverse_ceilings: Vec::with_capacity(intervals),
        ends,
    };
    let derivatives = Stencil::new(step_s);
    for (pair, room) in points.windows(2).zip(room) {
        let (a, b) = (&pair[0], &pair[1]);
        // Where the nominal motion waits, it waits as long as it should.
        let waiting = if rests(a) && rests(b) { 1.0 } else { 0.0 };
        let mut fastest = a
            .feed_part
            .max(b.feed_part)
            .max(a.chord_part)
            .max(b.chord_part)
            .max(waiting);
        for RetimedJoint { index, limits } in &moving {
            let [v, w] = [a, b].map(|point| point.velocity.0[*index]);
            let [c, d] = [a, b].map(|point| point.acceleration.0[*index]);
            fastest = fastest.max(v.abs().max(w.abs()) / limits[0]);
            let middle = [
                0.5 * (v + w) - (d - c) * step_s / 8.0,
                0.5 * (c + d),
                (d - c) / step_s,
            ];
            problem
                .rows
                .push(derivatives.rows(middle, [limits[1] * room[0], limits[2] * room[1]]));
        }
        // The pace itself, as a joint of steady nominal speed.
        problem.rows.push(derivatives.rows(
            [1.0, 0.0, 0.0],
            [f64::INFINITY, 1.0 / (SWIFTEST_S * SWIFTEST_S)],
        ));
        problem.inverse_ceilings.push(fastest * fastest);
    }
    problem
}

/// Value, slope and curvature of beta in the middle of an interval by its coefficients.
struct Stencil([[f64; 3]; 3]);

impl Stencil {
    fn new(step_s: f64) -> Stencil {
        let first = [-0.5, 0.0, 0.5].map(|c| c / step_s);
        let second = [1.0, -2.0, 1.0].map(|c| c / (step_s * step_s));
        Stencil([MIDDLE, first, second])
    }

    /// d sigma / dt is sqrt(beta), the second derivative beta' / 2, the third sqrt(beta) beta'' /
    /// 2, so that a joint's acceleration is a beta + v beta' / 2 and its jerk sqrt(beta) (j beta +
    /// 3/2 a beta' + v beta'' / 2).
    fn rows(&self, [v, a, j]: [f64; 3], [most_a, most_j]: [f64; 2]) -> Rows {
        let row = |c: [f64; 3], limit: f64| {
            std::array::from_fn(|k| {
                (c[0] * self.0[0][k] + c[1] * self.0[1][k] + c[2] * self.0[2][k]) / limit
            })
        };
        [
            row([a, 0.5 * v, 0.0], most_a),
            row([j, 1.5 * a, 0.5 * v], most_j),
        ]
    }
}

fn moves(points: &[Sample], joint: &RetimedJoint) -> bool {
    points.iter().any(|point| {
        let (v, a) = (
            point.velocity.0[joint.index],
            point.acceleration.0[joint.index],
        );
        v.abs() > STILL * joint.limits[0] || a.abs() > STILL * joint.limits[1]
    })
}
