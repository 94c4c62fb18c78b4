//! Offsets of lines and arcs in a plane, and where they meet.

use crate::ops::{Plane, Position};
use crate::problem::Problem;
use crate::state::held::{Edge, Point, Shape};
use lostmotion_base::math;
use std::f64::consts::{PI, TAU};

/// Moves whose directions differ by less than this, rad, go on without a corner (LinuxCNC: 0.05).
pub(crate) const STRAIGHT_ON: f64 = 0.05;
/// By how much of the tool's radius an arc may grow when its end is fixed.
const ARC_GROWTH: f64 = 0.01;

/// A place in the plane.
pub(crate) fn in_plane(plane: Plane, position: &Position) -> Point {
    let [first, second, _] = plane.axes();
    [position[first], position[second]]
}

pub(crate) fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

pub(crate) fn along(from: Point, direction: Point, length: f64) -> Point {
    [
        from[0] + length * direction[0],
        from[1] + length * direction[1],
    ]
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(crate) fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(crate) fn distance(a: Point, b: Point) -> f64 {
    math::hypot(b[0] - a[0], b[1] - a[1])
}

/// A quarter turn counter-clockwise.
pub(crate) const fn left_of(direction: Point) -> Point {
    [-direction[1], direction[0]]
}

/// Direction from one point to another; none if they are the same.
pub(crate) fn direction(from: Point, to: Point) -> Option<Point> {
    let length = distance(from, to);
    if length > 0.0 {
        Some([(to[0] - from[0]) / length, (to[1] - from[1]) / length])
    } else {
        None
    }
}

/// Sweep of an arc, in its direction, above 0 and up to a full turn.
fn sweep(center: Point, from: Point, to: Point, counter_clockwise: bool) -> f64 {
    let (a, b) = (minus(from, center), minus(to, center));
    let angle = math::atan2(cross(a, b), dot(a, b));
    let angle = if counter_clockwise { angle } else { -angle };
    if angle <= 0.0 { angle + TAU } else { angle }
}

impl Edge {
    /// Refuses an end that would send the tool backwards, or round an arc further than programmed.
    /// A move of entry is off the path in any case and may go anywhere.
    pub(crate) fn check(&self, end: Point, tool_radius: f64) -> Result<(), Problem> {
        let message = "the tool does not fit into the corner between this move and the one before it: it would gouge";
        let fits = self.entry
            || match self.shape {
                Shape::Line(direction) => dot(direction, minus(end, self.start)) >= 0.0,
                Shape::Arc {
                    center,
                    radius,
                    counter_clockwise,
                } => {
                    let was = sweep(center, self.start, self.end, counter_clockwise);
                    let is = sweep(center, self.start, end, counter_clockwise);
                    (is - was) * radius <= ARC_GROWTH * tool_radius
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
pub(crate) enum Joint {
    /// The moves meet as they are.
    Smooth,
    /// It rolls about the corner.
    Outside,
    /// The first move ends where the offset paths cross.
    Inside,
}

/// The joint of a move with one that enters the corner in a direction, the tool to the left, or to
/// the right where `left` is negative.
pub(crate) fn joint(last: &Edge, enters: Point, next: Shape, left: f64) -> Joint {
    let turn = math::atan2(cross(last.leaves, enters), dot(last.leaves, enters));
    let inwards = if left > 0.0 { turn } else { -turn };
    if inwards.abs() >= PI - STRAIGHT_ON {
        // Straight back: an arc that bends away from the tool comes into the tool's way, the next
        // one, or the last one before a line.
        let in_the_way = if matches!(next, Shape::Line(_)) {
            last.shape
        } else {
            next
        };
        if in_the_way.bends_away(left) {
            Joint::Inside
        } else {
            Joint::Outside
        }
    } else if inwards > STRAIGHT_ON {
        Joint::Inside
    } else if inwards.abs() <= STRAIGHT_ON {
        Joint::Smooth
    } else {
        Joint::Outside
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
    fn heading(&self, at: Point) -> Point {
        match *self {
            Shape::Line(direction) => direction,
            Shape::Arc {
                center,
                counter_clockwise,
                ..
            } => {
                let left = left_of(minus(at, center));
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
pub(crate) fn crossing(a: Shape, a_at: Point, b: Shape, b_at: Point, left: f64) -> Option<Point> {
    let turns_in = |at: Point| cross(a.heading(at), b.heading(at)) * left > 0.0;
    let [first, second] = crossings(a, a_at, b, b_at)?;
    Some(if turns_in(first) { first } else { second })
}

fn crossings(a: Shape, a_at: Point, b: Shape, b_at: Point) -> Option<[Point; 2]> {
    match (a, b) {
        (Shape::Line(u), Shape::Line(v)) => {
            let slope = cross(u, v);
            if slope == 0.0 {
                return None;
            }
            Some([along(a_at, u, cross(minus(b_at, a_at), v) / slope); 2])
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

fn line_circle(at: Point, u: Point, center: Point, radius: f64) -> Option<[Point; 2]> {
    let foot = along(at, u, dot(minus(center, at), u));
    let away = distance(foot, center);
    if away > radius {
        return None;
    }
    let half = (radius * radius - away * away).sqrt();
    Some([along(foot, u, half), along(foot, u, -half)])
}

fn circles(c: Point, r: f64, d: Point, s: f64) -> Option<[Point; 2]> {
    let u = direction(c, d)?;
    let gap = distance(c, d);
    if gap > r + s || gap < (r - s).abs() {
        return None;
    }
    let to_foot = (gap * gap + r * r - s * s) / (2.0 * gap);
    let half = (r * r - to_foot * to_foot).max(0.0).sqrt();
    let foot = along(c, u, to_foot);
    Some([
        along(foot, left_of(u), half),
        along(foot, left_of(u), -half),
    ])
}
