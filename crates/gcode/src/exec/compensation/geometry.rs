//! Offsets of lines and arcs in a plane, and where they meet.

use crate::ops::{Plane, Position};
use crate::problem::Problem;
use crate::state::{Edge, Shape};
use lostmotion_base::math;
use lostmotion_base::vec::{Vec2, along, cross2, direction2, distance2, dot, left_of, sub};
use std::f64::consts::{PI, TAU};

/// Largest turn that counts as no corner, rad. Published: LinuxCNC's documentation of cutter
/// compensation.
pub(crate) const SMOOTH_TURN_RAD: f64 = 0.05;
/// Largest growth of an arc when its end is fixed, in parts of the tool's radius. A choice: more
/// would cut further round than programmed, less would refuse ends that rounding has moved.
const LARGEST_ARC_GROWTH: f64 = 0.01;

/// A place in the plane.
pub(crate) fn in_plane(plane: Plane, position: &Position) -> Vec2 {
    let [first, second, _] = plane.axes();
    [position[first], position[second]]
}

/// Sweep of an arc, in its direction, above 0 and up to a full turn.
fn sweep(center: Vec2, from: Vec2, to: Vec2, counter_clockwise: bool) -> f64 {
    // The angle between the radius vectors, taken in the direction of the arc.
    let (a, b) = (sub(from, center), sub(to, center));
    let angle = math::atan2(cross2(a, b), dot(a, b));
    let angle = if counter_clockwise { angle } else { -angle };
    if angle <= 0.0 { angle + TAU } else { angle }
}

impl Edge {
    /// Refuses an end that would send the tool backwards, or round an arc further than programmed.
    /// A move of entry is off the path in any case and may go anywhere.
    pub(crate) fn check(&self, end: Vec2, tool_radius: f64) -> Result<(), Problem> {
        let message = "the tool does not fit into the corner between this move and the one before it: it would gouge";
        // A line must still lead forwards, an arc must not pass its programmed end by more than
        // rounding.
        let fits = self.entry
            || match self.shape {
                Shape::Line(direction) => dot(direction, sub(end, self.start)) >= 0.0,
                Shape::Arc {
                    center,
                    radius,
                    counter_clockwise,
                } => {
                    let was = sweep(center, self.start, self.end, counter_clockwise);
                    let is = sweep(center, self.start, end, counter_clockwise);
                    (is - was) * radius <= LARGEST_ARC_GROWTH * tool_radius
                }
            };
        if fits {
            Ok(())
        } else {
            Err(Problem::Compensation { message })
        }
    }
}

/// How the tool goes from one move to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum CornerKind {
    /// The moves meet as they are.
    Smooth,
    /// It rolls about the corner.
    Outside,
    /// The first move ends where the offset paths cross.
    Inside,
}

/// The joint of a move with one that enters the corner in a direction, the tool to the left, or to
/// the right where `left` is negative.
pub(crate) fn joint(last: &Edge, enters: Vec2, next: Shape, left: f64) -> CornerKind {
    // Turn angle between the directions, positive towards the tool's side.
    let turn = math::atan2(cross2(last.leaves, enters), dot(last.leaves, enters));
    let inwards = if left > 0.0 { turn } else { -turn };
    if inwards.abs() >= PI - SMOOTH_TURN_RAD {
        // Straight back: an arc that bends away from the tool comes into the tool's way, the next
        // one, or the last one before a line.
        let in_the_way = if matches!(next, Shape::Line(_)) {
            last.shape
        } else {
            next
        };
        if in_the_way.bends_away(left) {
            CornerKind::Inside
        } else {
            CornerKind::Outside
        }
    } else if inwards > SMOOTH_TURN_RAD {
        CornerKind::Inside
    } else if inwards.abs() <= SMOOTH_TURN_RAD {
        CornerKind::Smooth
    } else {
        CornerKind::Outside
    }
}

impl Shape {
    /// Whether it is an arc that the tool is outside of.
    const fn bends_away(&self, left: f64) -> bool {
        match *self {
            Shape::Line(_) => false,
            Shape::Arc {
                counter_clockwise, ..
            } => counter_clockwise != (left > 0.0),
        }
    }

    /// Direction of travel at a point.
    fn heading(&self, at: Vec2) -> Vec2 {
        match *self {
            Shape::Line(direction) => direction,
            Shape::Arc {
                center,
                counter_clockwise,
                ..
            } => {
                let left = left_of(sub(at, center));
                if counter_clockwise {
                    left
                } else {
                    [-left[0], -left[1]]
                }
            }
        }
    }
}

/// Where the offset of one move crosses that of the next. Of two crossings it is the one at which
/// the path turns towards the tool's side: before it, the tool has not yet reached the second move,
/// after it, it would cut into that. `a_at` and `b_at` are points of the paths.
pub(crate) fn crossing(a: Shape, a_at: Vec2, b: Shape, b_at: Vec2, left: f64) -> Option<Vec2> {
    let turns_in = |at: Vec2| cross2(a.heading(at), b.heading(at)) * left > 0.0;
    let [first, second] = crossings(a, a_at, b, b_at)?;
    Some(if turns_in(first) { first } else { second })
}

fn crossings(a: Shape, a_at: Vec2, b: Shape, b_at: Vec2) -> Option<[Vec2; 2]> {
    match (a, b) {
        (Shape::Line(u), Shape::Line(v)) => {
            // Parallel lines do not cross.
            let slope = cross2(u, v);
            if slope == 0.0 {
                return None;
            }
            Some([along(a_at, u, cross2(sub(b_at, a_at), v) / slope); 2])
        }
        (Shape::Line(u), Shape::Arc { center, radius, .. }) => line_circle(a_at, u, center, radius),
        (Shape::Arc { center, radius, .. }, Shape::Line(v)) => line_circle(b_at, v, center, radius),
        (
            Shape::Arc {
                center: c,
                radius: r,
                ..
            },
            Shape::Arc {
                center: d,
                radius: s,
                ..
            },
        ) => circles(c, r, d, s),
    }
}

fn line_circle(at: Vec2, u: Vec2, center: Vec2, radius: f64) -> Option<[Vec2; 2]> {
    // Foot point of the centre on the line, then half the chord to either side.
    let foot = along(at, u, dot(sub(center, at), u));
    let away = distance2(foot, center);
    if away > radius {
        return None;
    }
    let half = (radius * radius - away * away).sqrt();
    Some([along(foot, u, half), along(foot, u, -half)])
}

fn circles(c: Vec2, r: f64, d: Vec2, s: f64) -> Option<[Vec2; 2]> {
    // Circles about one centre, apart, or inside one another do not cross.
    let u = direction2(c, d)?;
    let gap = distance2(c, d);
    if gap > r + s || gap < (r - s).abs() {
        return None;
    }
    // Both crossings lie on the radical line, which is square to the line of centres.
    let to_foot = (gap * gap + r * r - s * s) / (2.0 * gap);
    let half = (r * r - to_foot * to_foot).max(0.0).sqrt();
    let foot = along(c, u, to_foot);
    Some([
        along(foot, left_of(u), half),
        along(foot, left_of(u), -half),
    ])
}
