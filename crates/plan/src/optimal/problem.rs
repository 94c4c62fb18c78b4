//! The limits of beta over a window.

use super::banded::Banded;
use crate::Sample;
use lostmotion_base::vec::dot;
use lostmotion_base::{AXES, AxisLimits, Coords};

/// Value of a quadratic spline in the middle of an interval from its three coefficients there.
pub(super) const MIDDLE: [f64; 3] = [0.125, 0.75, 0.125];
/// Part of a limit by which an eased limit keeps the start. A choice: the solver needs a start
/// strictly inside.
const EASE_MARGIN: f64 = 2e-4;

/// The same for a largest beta, which has no need of room: rounding.
const CEILING_MARGIN: f64 = 1e-5;

/// Intervals one after the other over which a motion that uses all of a limit may use less. A choice:
/// its jerk changes within one of them, or at two such places that are next to each other.
const MOST_LESS: usize = 2;

/// Part of its limits up to which a joint counts as still: rounding of the nominal motion.
const STILL_PART: f64 = 1e-9;
/// Part of a limit by which rounding of the nominal motion may miss it. A choice: positions of some
/// hundred mm and steps of a quarter of a millisecond make 1e-5.
const ROUNDING_PART: f64 = 5e-5;
/// Time, s, in which the pace may change from standing still to that of the nominal motion, about:
/// where the joints rest, nothing else would bound its jerk. A choice: four command cycles of 1 ms.
const SWIFTEST_PACE_S: f64 = 4e-3;

/// State in which a window begins or ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum End {
    /// In a given state of motion: two coefficients stay as they are.
    #[default]
    Moving,
    /// At rest: beta, which has no influence on the joints there, is constant over this number of
    /// intervals.
    Rest(usize),
}

/// One joint's limits in one interval, divided by the limit: acceleration by the three
/// coefficients, jerk over sqrt(beta) likewise.
pub(super) type Rows = [[f64; 3]; 2];

/// A window of intervals.
#[derive(Clone, Debug, Default)]
pub(super) struct Problem {
    /// Nominal time of an interval, s.
    pub(super) step_s: f64,
    /// Joints with limits.
    pub(super) joints: usize,
    /// By interval, then joint.
    pub(super) rows: Vec<Rows>,
    /// By interval: one over the largest beta that velocities and feed allow.
    pub(super) inverse_ceilings: Vec<f64>,
    /// What the window begins and ends with.
    pub(super) ends: [End; 2],
}

impl Problem {
    /// Eases the limits of the first intervals, in which a given state at the start leaves little
    /// choice: each limit that the start does not keep by a margin is scaled until it does.
    pub(super) fn ease(&mut self, intervals: usize, x: &[f64]) {
        for interval in 0..intervals.min(self.inverse_ceilings.len()) {
            let local = Local::at(x, interval);
            let inverse = &mut self.inverse_ceilings[interval];
            *inverse = inverse.min((1.0 - CEILING_MARGIN) / local.beta);
            for rows in &mut self.rows[interval * self.joints..(interval + 1) * self.joints] {
                for (kind, row) in rows.iter_mut().enumerate() {
                    let (right, _) = local.right(kind);
                    let left = dot(*row, local.x).abs();
                    // Scaled so that the given start keeps it by a margin.
                    if left > right * (1.0 - EASE_MARGIN) {
                        *row = row.map(|c| c * (right * (1.0 - EASE_MARGIN) / left));
                    }
                }
            }
        }
    }

    /// Takes part of an interval's limits of acceleration and jerk away.
    pub(super) fn tighten(&mut self, interval: usize, scale: [f64; 2]) {
        for rows in &mut self.rows[interval * self.joints..(interval + 1) * self.joints] {
            for (row, scale) in rows.iter_mut().zip(scale) {
                *row = row.map(|c| c / scale);
            }
        }
    }
}

/// beta in the middle of an interval and what the right side of the jerk's limit and its slope are
/// there.
#[derive(Clone, Copy)]
pub(super) struct Local {
    pub(super) x: [f64; 3],
    pub(super) beta: f64,
    root: f64,
    slope: f64,
}

impl Local {
    pub(super) fn at(x: &[f64], interval: usize) -> Local {
        let x = [x[interval], x[interval + 1], x[interval + 2]];
        let beta = dot(MIDDLE, x);
        let root = 1.0 / beta.sqrt();
        Local {
            x,
            beta,
            root,
            slope: -0.5 * root / beta,
        }
    }

    /// The right side of a limit and its slope by beta: row 0 acceleration, row 1 jerk.
    pub(super) fn right(&self, kind: usize) -> (f64, f64) {
        if kind == 0 {
            (1.0, 0.0)
        } else {
            (self.root, self.slope)
        }
    }
}

/// Whether the nominal motion rests.
fn rests(point: &Sample) -> bool {
    point.velocity == Coords::ZERO && point.acceleration == Coords::ZERO
}

/// A joint with its limits of velocity, acceleration and jerk.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LimitedJoint {
    pub(crate) index: usize,
    /// What is planned for.
    pub(crate) limits: [f64; 3],
    /// What the nominal motion may use at its own pace.
    pub(crate) nominal: [f64; 3],
}

impl LimitedJoint {
    /// The limit of a derivative where the nominal motion has one: what is planned for, or as much
    /// as the nominal motion uses of what it may.
    fn limit(&self, kind: usize, nominal: f64) -> f64 {
        let (planned, used) = (self.limits[kind], nominal.abs());
        if used <= self.nominal[kind] * (1.0 + STILL_PART) {
            planned.max(used)
        } else {
            planned
        }
    }
}

/// The joints that have limits, each kept to a part of them: velocity, acceleration, jerk. A nominal
/// motion at its own pace is kept to another part.
pub(crate) fn joints(
    limits: &[Option<AxisLimits>; AXES],
    parts: [f64; 3],
    nominal_part: f64,
) -> Vec<LimitedJoint> {
    let joint = |(index, limits): (usize, &Option<AxisLimits>)| {
        let limits = (*limits)?;
        let limits = [limits.velocity, limits.acceleration, limits.jerk];
        Some(LimitedJoint {
            index,
            limits: std::array::from_fn(|kind| limits[kind] * parts[kind]),
            nominal: limits.map(|limit| limit * nominal_part),
        })
    };
    limits.iter().enumerate().filter_map(joint).collect()
}

/// Time that the slowest joint takes to stop, s: to brake from its velocity, and to build up the
/// acceleration for that.
pub(crate) fn stop_s(joints: &[LimitedJoint]) -> f64 {
    joints
        .iter()
        .map(|joint| {
            let [v, a, j] = joint.limits;
            v / a + a / j
        })
        .fold(0.0, f64::max)
}

/// Makes the limits of beta between each two of the points. `room` scales those of acceleration and
/// jerk by interval.
pub(super) fn limits(
    points: &[Sample],
    joints: &[LimitedJoint],
    step_s: f64,
    room: &[[f64; 2]],
    ends: [End; 2],
) -> Problem {
    let moving: Vec<LimitedJoint> = joints
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
        // Velocity is a ceiling of beta, acceleration and jerk are rows.
        for joint in &moving {
            let [v, w] = [a, b].map(|point| point.velocity.0[joint.index]);
            let [c, d] = [a, b].map(|point| point.acceleration.0[joint.index]);
            let speed = v.abs().max(w.abs());
            fastest = fastest.max(speed / joint.limit(0, speed));
            // Derivatives of the nominal motion in the middle of the interval.
            let middle = [
                0.5 * (v + w) - (d - c) * step_s / 8.0,
                0.5 * (c + d),
                (d - c) / step_s,
            ];
            let [most_a, most_j] = [1, 2].map(|kind| joint.limit(kind, middle[kind]));
            problem
                .rows
                .push(derivatives.rows(middle, [most_a * room[0], most_j * room[1]]));
        }
        // The pace itself, as a joint of steady nominal speed.
        problem.rows.push(derivatives.rows(
            [1.0, 0.0, 0.0],
            [f64::INFINITY, 1.0 / (SWIFTEST_PACE_S * SWIFTEST_PACE_S)],
        ));
        problem.inverse_ceilings.push(fastest * fastest);
    }
    problem
}

/// Largest parts of the limits that the nominal motion uses between two points: speed (of joints, of
/// the feed, and of what a chord allows), acceleration, jerk.
fn used(ends: [&Sample; 2], joints: &[LimitedJoint], step_s: f64) -> [f64; 3] {
    let [a, b] = ends;
    let speed = [a.feed_part, b.feed_part, a.chord_part, b.chord_part]
        .into_iter()
        .fold(0.0, f64::max);
    joints.iter().fold([speed, 0.0, 0.0], |used, joint| {
        let [v, w] = [a, b].map(|point| point.velocity.0[joint.index].abs());
        let [c, d] = [a, b].map(|point| point.acceleration.0[joint.index]);
        let parts = [v.max(w), 0.5 * (c + d).abs(), (d - c).abs() / step_s];
        std::array::from_fn(|kind| used[kind].max(parts[kind] / joint.nominal[kind]))
    })
}

/// Whether the nominal motion keeps all limits at its own pace.
pub(super) fn keeps_limits(points: &[Sample], joints: &[LimitedJoint], step_s: f64) -> bool {
    points.windows(2).all(|pair| {
        let used = used([&pair[0], &pair[1]], joints, step_s);
        used.iter().all(|part| *part <= 1.0 + ROUNDING_PART)
    })
}

/// Whether the nominal motion uses all of a limit all along, but where its jerk changes: so does the
/// fastest one on a line.
pub(super) fn uses_limits(points: &[Sample], joints: &[LimitedJoint], step_s: f64) -> bool {
    let mut less = 0;
    points.windows(2).all(|pair| {
        let used = used([&pair[0], &pair[1]], joints, step_s);
        let all = used.iter().any(|part| *part >= 1.0 - ROUNDING_PART);
        less = if all || (rests(&pair[0]) && rests(&pair[1])) {
            0
        } else {
            less + 1
        };
        less <= MOST_LESS
    })
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

fn moves(points: &[Sample], joint: &LimitedJoint) -> bool {
    points.iter().any(|point| {
        let (v, a) = (
            point.velocity.0[joint.index],
            point.acceleration.0[joint.index],
        );
        v.abs() > STILL_PART * joint.limits[0] || a.abs() > STILL_PART * joint.limits[1]
    })
}

/// Removes given and tied coefficients from the system for the change of the coefficients.
pub(super) fn hold([start, end]: [End; 2], matrix: &mut Banded, right: &mut [f64]) {
    let last = right.len() - 1;
    let mut given = |index: usize| {
        matrix.isolate(index);
        right[index] = 0.0;
    };
    // Two coefficients hold the value and the slope of beta at an end.
    if start == End::Moving {
        [0, 1].into_iter().for_each(&mut given);
    }
    if end == End::Moving {
        [last - 1, last].into_iter().for_each(&mut given);
    }
    // At rest beta is constant but free: gradients of all tied coefficients go to the one inside.
    if let End::Rest(tied) = start {
        for index in 0..tied {
            matrix.tie_up(index);
            right[index + 1] += right[index];
            right[index] = 0.0;
        }
    }
    if let End::Rest(tied) = end {
        for index in (last + 1 - tied..=last).rev() {
            matrix.tie_down(index);
            right[index - 1] += right[index];
            right[index] = 0.0;
        }
    }
}

/// Gives tied coefficients the change of the one that they are tied to.
pub(super) fn follow([start, end]: [End; 2], change: &mut [f64]) {
    if let End::Rest(tied) = start {
        let free = change[tied];
        change[..tied].fill(free);
    }
    if let End::Rest(tied) = end {
        let last = change.len() - 1 - tied;
        let free = change[last];
        change[last + 1..].fill(free);
    }
}
