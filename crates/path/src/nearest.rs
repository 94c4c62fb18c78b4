//! Global nearest point on a piece of curve, with proof.
//!
//! Branch and bound over the curve's own parameter t. On an interval of half width h about m, with
//! q = P - point: the distance is at least |q(m)| - h max|P'|; half the square's derivatives are f1
//! = q.P' and f2 = P'.P' + q.P'', and f2 varies by no more than h (3 max|P'.P''| + max|q|
//! max|P'''|). So an interval is dropped when it is too far, when f1 keeps its sign, or when f2
//! stays negative (the minimum is then at an end, which belongs to a neighbour too); where f2 stays
//! positive the one minimum is found by Newton's method in a bracket; else it is halved.

use crate::derivs::within;
use crate::{Arc, Foot, Quintic};
use lostmotion_base::root::Bracket;
use lostmotion_base::vec::{dot, norm, sub};

/// Position with two derivatives by t.
pub(crate) struct Local {
    pub(crate) p: [f64; 3],
    pub(crate) d1: [f64; 3],
    pub(crate) d2: [f64; 3],
}

/// Bounds over an interval of t.
pub(crate) struct Rates {
    /// max |P'|
    pub(crate) d1: f64,
    /// max |P'.P''|
    pub(crate) d1_d2: f64,
    /// max |P'''|
    pub(crate) d3: f64,
}

/// A curve in X Y Z over its natural parameter.
pub(crate) trait Piece {
    fn local(&self, t: f64) -> Local;
    fn rates(&self, t0: f64, t1: f64) -> Rates;
}

/// Most intervals examined before the best foot so far is returned; only a curve that runs at a
/// constant distance around the point, and is no exact circle, comes near it.
const MAX_INTERVALS: usize = 20_000;
/// Halvings of the range, which also bounds the stack: one entry for each.
const MAX_DEPTH: usize = 60;

/// Most steps of Newton's method on an interval of proven convexity, against a rounding that never
/// settles; a few are the rule.
const MAX_NEWTON_STEPS: usize = 60;
/// Step after which Newton's method ends, in parts of the interval. Derived: the error left is at
/// most the square.
const LAST_STEP_SHARE: f64 = 1e-8;

/// The t in the range that is nearest to the point and its distance, to within the tolerance in mm.
pub(crate) fn search(
    piece: &impl Piece,
    point: [f64; 3],
    range: (f64, f64),
    tolerance: f64,
) -> (f64, f64) {
    let mut best = Best {
        piece,
        point,
        t: range.0,
        distance: f64::INFINITY,
    };
    // Both ends first: an interval is dropped where its minimum lies at an end.
    best.offer(range.0);
    best.offer(range.1);
    let mut stack = Vec::with_capacity(8);
    stack.push((range.0, range.1, 0_usize));
    for _ in 0..MAX_INTERVALS {
        let Some((a, b, depth)) = stack.pop() else {
            break;
        };
        let middle = 0.5 * (a + b);
        match best.examine(a, b, tolerance) {
            Verdict::Done => {}
            _ if depth >= MAX_DEPTH => {}
            Verdict::Halve {
                first_half_first: true,
            } => {
                // The half into which the distance falls is examined first: a near foot drops much
                // of the rest.
                stack.push((middle, b, depth + 1));
                stack.push((a, middle, depth + 1));
            }
            Verdict::Halve {
                first_half_first: false,
            } => {
                stack.push((a, middle, depth + 1));
                stack.push((middle, b, depth + 1));
            }
        }
    }
    (best.t, best.distance)
}

enum Verdict {
    Done,
    Halve { first_half_first: bool },
}

struct Best<'a, P> {
    piece: &'a P,
    point: [f64; 3],
    t: f64,
    distance: f64,
}

impl<P: Piece> Best<'_, P> {
    fn offer(&mut self, t: f64) {
        let distance = norm(sub(self.piece.local(t).p, self.point));
        if distance < self.distance {
            (self.t, self.distance) = (t, distance);
        }
    }

    fn examine(&mut self, a: f64, b: f64, tolerance: f64) -> Verdict {
        let (middle, h) = (0.5 * (a + b), 0.5 * (b - a));
        let local = self.piece.local(middle);
        let q = sub(local.p, self.point);
        let distance = norm(q);
        if distance < self.distance {
            (self.t, self.distance) = (middle, distance);
        }
        let rates = self.piece.rates(a, b);
        let reach = rates.d1 * h;
        // Too far: no point of the interval can beat the best so far.
        if distance - reach >= self.distance {
            return Verdict::Done;
        }
        let f1 = dot(q, local.d1);
        let f2 = dot(local.d1, local.d1) + dot(q, local.d2);
        let spread = h * (3.0 * rates.d1_d2 + (distance + reach) * rates.d3);
        // No stationary point, or only a maximum, inside: the ends have been offered already.
        let keeps_sign = f1.abs() > h * (f2.abs() + spread);
        if keeps_sign || f2 + spread < 0.0 {
            return Verdict::Done;
        }
        // Convex throughout: one minimum.
        if f2 - spread > 0.0 {
            let t = self.stationary(a, b);
            self.offer(t);
            return Verdict::Done;
        }
        // Lower bound of the squared distance to second order; good where the curve runs around the
        // point.
        let lower = distance * distance - 2.0 * f1.abs() * h - (spread - f2).max(0.0) * h * h;
        let enough = (self.distance - tolerance).max(0.0);
        if lower >= enough * enough || h <= f64::EPSILON * middle.abs() {
            return Verdict::Done;
        }
        Verdict::Halve {
            first_half_first: f1 > 0.0,
        }
    }

    /// The minimum in an interval on which the squared distance is convex.
    fn stationary(&self, a: f64, b: f64) -> f64 {
        let mut bracket = Bracket::new(a, b);
        let mut t = 0.5 * (a + b);
        for _ in 0..MAX_NEWTON_STEPS {
            let local = self.piece.local(t);
            let q = sub(local.p, self.point);
            let f1 = dot(q, local.d1);
            bracket.narrow(t, f1);
            let next = within(t - f1 / (dot(local.d1, local.d1) + dot(q, local.d2)), a, b);
            // On an interval of proven convexity the error after a step e is at most e^2 / (b - a).
            if (next - t).abs() <= LAST_STEP_SHARE * (b - a) {
                return next;
            }
            // An end of the interval may be the minimum: the bracket's ends count as inside.
            t = if next < bracket.low || next > bracket.high {
                bracket.middle()
            } else {
                next
            };
        }
        t
    }
}

impl Piece for Arc {
    fn local(&self, u: f64) -> Local {
        let mut local = Local {
            p: [0.0; 3],
            d1: [0.0; 3],
            d2: [0.0; 3],
        };
        for (axis, jet) in self.plane.axes().into_iter().zip(self.plane_jets(u)) {
            [local.p[axis], local.d1[axis], local.d2[axis], _] = jet.0;
        }
        local
    }

    fn rates(&self, u0: f64, u1: f64) -> Rates {
        let spiral = self.spiral();
        let r = spiral.radius(u0).max(spiral.radius(u1));
        let (k, b) = (spiral.k, spiral.b.abs());
        let k2 = k * k;
        Rates {
            d1: (spiral.c2 + k2 * r * r).sqrt(),
            d1_d2: k2 * r * b,
            d3: k2 * (9.0 * b * b + k2 * r * r).sqrt(),
        }
    }
}

impl Piece for Quintic {
    fn local(&self, s: f64) -> Local {
        let derivs = self.eval(s);
        Local {
            p: derivs.p.linear(),
            d1: derivs.d1.linear(),
            d2: derivs.d2.linear(),
        }
    }

    fn rates(&self, s0: f64, s1: f64) -> Rates {
        let (d1, d2, d3) = self.max_derivatives(s0, s1);
        Rates {
            d1: d1.linear_norm(),
            d1_d2: d1.linear_norm() * d2.linear_norm(),
            d3: d3.linear_norm(),
        }
    }
}

impl Arc {
    /// The point nearest to `point` between two s: in closed form on a circle, searched with proof
    /// on helix and spiral. Among equally near points of a circle (several turns, or a point on its
    /// axis) the first is taken.
    pub fn nearest(&self, point: [f64; 3], range: (f64, f64), tolerance_mm: f64) -> Foot {
        if self.length <= 0.0 {
            return Foot {
                s: 0.0,
                distance: norm(sub(self.start.linear(), point)),
            };
        }
        if self.is_circle() {
            return self.nearest_on_circle(point, range);
        }
        let spiral = self.spiral();
        let (u, distance) = search(
            self,
            point,
            (self.fraction(range.0), self.fraction(range.1)),
            tolerance_mm,
        );
        Foot {
            s: within(spiral.length(u), range.0, range.1),
            distance,
        }
    }

    fn nearest_on_circle(&self, point: [f64; 3], range: (f64, f64)) -> Foot {
        use lostmotion_base::math;
        use std::f64::consts::TAU;
        let [first, second, normal] = self.plane.axes();
        let offset = [
            point[first] - self.center[0],
            point[second] - self.center[1],
        ];
        // A circle's distance has no minimum inside but the foot: else an end is nearest.
        let ends = [range.0, range.1].map(|s| Foot {
            s,
            distance: norm(sub(self.point(s).linear(), point)),
        });
        let [begin, finish] = ends;
        let nearer_end = if finish.distance < begin.distance {
            finish
        } else {
            begin
        };
        // On the axis every point of the circle is as near.
        if offset == [0.0, 0.0] {
            return begin;
        }
        // Angle from the start in the sense of travel, and the first turn on which it lies in the
        // range.
        let angle = (math::atan2(offset[1], offset[0]) - self.start_angle) * self.sweep.signum();
        let per_angle = self.length / self.sweep.abs();
        let turns = ((range.0 / per_angle - angle) / TAU).ceil();
        let s = (angle + turns * TAU) * per_angle;
        if s > range.1 {
            return nearer_end;
        }
        // Distance in the plane from the circle, then with the distance from the plane.
        let across = math::hypot(offset[0], offset[1]) - self.start_radius;
        let distance = math::hypot(across, point[normal] - self.start.0[normal]);
        if nearer_end.distance < distance {
            nearer_end
        } else {
            Foot {
                s: within(s, range.0, range.1),
                distance,
            }
        }
    }
}

impl Quintic {
    /// The point nearest to `point` between two s, searched with proof.
    pub fn nearest(&self, point: [f64; 3], range: (f64, f64), tolerance_mm: f64) -> Foot {
        let (s, distance) = search(self, point, range, tolerance_mm);
        Foot { s, distance }
    }
}
