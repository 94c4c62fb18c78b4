//! Curves as arcs: pairs of arcs that share the curve's points and tangents, fine enough to stay within a tolerance.

use super::spline::Spline;
use lostmotion_base::math;

/// Most halvings of a stretch of the curve.
const MOST_HALVINGS: u32 = 20;
/// Places between its ends at which a pair of arcs is held against the curve.
const CHECKS: u32 = 8;
/// An arc flatter than this, mm from chord to circle, is a line.
const FLAT_MM: f64 = 1e-9;

pub(super) type Point = [f64; 2];

/// A line, or an arc about a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stroke {
    pub(super) start: Point,
    pub(super) end: Point,
    /// Centre, and whether it runs counter-clockwise.
    pub(super) round: Option<(Point, bool)>,
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn plus(a: Point, b: Point, factor: f64) -> Point {
    [a[0] + factor * b[0], a[1] + factor * b[1]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn distance(a: Point, b: Point) -> f64 {
    math::hypot(b[0] - a[0], b[1] - a[1])
}

impl Stroke {
    /// From a point along a tangent to another point.
    fn from(start: Point, tangent: Point, end: Point) -> Stroke {
        let way = minus(end, start);
        let side = cross(tangent, way);
        let square = dot(way, way);
        // The sagitta of a shallow arc is a quarter of how far its end lies beside the tangent.
        if side.abs() < 4.0 * FLAT_MM {
            return Stroke { start, end, round: None };
        }
        let radius = square / (2.0 * side);
        Stroke { start, end, round: Some((plus(start, [-tangent[1], tangent[0]], radius), side > 0.0)) }
    }

    /// The same from the other end: along a tangent into the end.
    fn into_end(start: Point, end: Point, tangent: Point) -> Stroke {
        let back = Stroke::from(end, [-tangent[0], -tangent[1]], start);
        Stroke { start, end, round: back.round.map(|(center, ccw)| (center, !ccw)) }
    }

    /// How far a point beside it is from its circle or line.
    fn deviation(&self, point: Point) -> f64 {
        match self.round {
            Some((center, _)) => (distance(center, point) - distance(center, self.start)).abs(),
            None => {
                let way = minus(self.end, self.start);
                let length = math::hypot(way[0], way[1]);
                if length > 0.0 { (cross(way, minus(point, self.start)) / length).abs() } else { distance(self.start, point) }
            }
        }
    }

    /// Its length.
    pub(super) fn length(&self) -> f64 {
        let Some((center, ccw)) = self.round else { return distance(self.start, self.end) };
        let (from, to) = (minus(self.start, center), minus(self.end, center));
        let turn = math::atan2(cross(from, to), dot(from, to));
        let turn = if ccw { turn } else { -turn };
        let turn = if turn < 0.0 { turn + std::f64::consts::TAU } else { turn };
        turn * math::hypot(from[0], from[1])
    }
}

/// The two arcs that meet a tangent at either end and each other; none if they would have to turn back.
fn pair(start: Point, from: Point, end: Point, to: Point) -> Option<[Stroke; 2]> {
    let way = minus(end, start);
    let square = dot(way, way);
    if square == 0.0 || dot(from, to) <= 0.0 || dot(from, way) <= 0.0 || dot(to, way) <= 0.0 {
        return None;
    }
    let sum = [from[0] + to[0], from[1] + to[1]];
    let along = dot(way, sum);
    let open = 2.0 * (1.0 - dot(from, to));
    let reach = if open > 1e-12 { (-along + (along * along + open * square).sqrt()) / open } else { square / (2.0 * along) };
    let meet = plus([0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])], minus(from, to), 0.5 * reach);
    Some([Stroke::from(start, from, meet), Stroke::into_end(meet, end, to)])
}

/// Arcs along a stretch of a curve within a tolerance, in order.
pub(super) fn strokes(spline: &Spline, from: f64, to: f64, tolerance: f64, halvings: u32, out: &mut Vec<Stroke>) {
    let (start, first) = spline.at(from);
    let (end, last) = spline.at(to);
    let middle = 0.5 * (from + to);
    let splits = halvings < MOST_HALVINGS && middle > from && middle < to;
    if let (Some(first), Some(last)) = (first, last)
        && let Some(pair) = pair(start, first, end, last)
        && (!splits || fits(spline, from, to, &pair, tolerance))
    {
        out.extend(pair.into_iter().filter(|stroke| stroke.start != stroke.end));
    } else if splits && distance(start, end).max(distance(start, spline.at(middle).0)) > 0.0 {
        strokes(spline, from, middle, tolerance, halvings + 1, out);
        strokes(spline, middle, to, tolerance, halvings + 1, out);
    } else if start != end {
        out.push(Stroke { start, end, round: None });
    }
}

fn fits(spline: &Spline, from: f64, to: f64, pair: &[Stroke; 2], tolerance: f64) -> bool {
    (1..CHECKS).all(|check| {
        let (point, _) = spline.at(from + (to - from) * f64::from(check) / f64::from(CHECKS));
        pair.iter().any(|stroke| stroke.deviation(point) <= 0.5 * tolerance)
    })
}

#[cfg(test)]
impl Stroke {
    /// Distance of a point by walking along in small steps.
    pub(super) fn nearest(&self, point: Point) -> f64 {
        let steps = 50;
        let at = |step: u32| {
            let share = f64::from(step) / f64::from(steps);
            match self.round {
                None => plus(self.start, minus(self.end, self.start), share),
                Some((center, ccw)) => {
                    let from = minus(self.start, center);
                    let radius = math::hypot(from[0], from[1]);
                    let turn = share * self.length() / radius * if ccw { 1.0 } else { -1.0 };
                    let (sin, cos) = math::sin_cos(turn);
                    plus(center, [from[0] * cos - from[1] * sin, from[0] * sin + from[1] * cos], 1.0)
                }
            }
        };
        let close = (0..=steps).map(|step| distance(at(step), point)).fold(f64::INFINITY, f64::min);
        // What a chord between two steps can hide.
        (close - self.length() / f64::from(steps)).max(0.0)
    }
}
