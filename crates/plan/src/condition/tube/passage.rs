//! When a curve passes the vertices of its way.

use super::Cubic;
use super::spline::Breaks;
use super::way::{Way, unit};
use lostmotion_base::vec::{Vec3, dot, norm, sub};
use lostmotion_path::HermiteEnd;

/// Halvings of a quarter of an interval after which a chord tells the time of a vertex well enough: to some
/// millionths of an interval.
const PASSAGE_HALVINGS: u32 = 6;
/// Distances from a vertex, in units of the tolerance, at which the curve is beside it, and beyond
/// which it has not come to it. Choices.
const NEAR: f64 = 2.0;
const FAR: f64 = 16.0;
/// Intervals by which a vertex may be passed later than it was before.
const LATER_INTERVALS: usize = 16;

/// Where on a curve, given by its states at breaks, each vertex of its way is passed: where it is nearest to
/// it, one after the other. `ahead` is where the way leads to past each, and `before` where each was passed
/// before. What is found is told with where the curve leads to there.
pub(super) fn passed(
    way: &Way<'_>,
    (breaks, states): (&Breaks, &[HermiteEnd]),
    ahead: impl Fn(usize) -> Vec3,
    before: &[f64],
    mut tell: impl FnMut(usize, Vec3),
) -> Vec<f64> {
    let last = breaks.intervals();
    let width = |k: usize| breaks.0[k + 1] - breaks.0[k];
    let cubic = |k: usize| Cubic::new(&states[k], &states[k + 1], width(k));
    let (mut k, mut x) = (0, 0.0);
    let mut here = cubic(0);
    let mut passed = vec![0.0; before.len()];
    let mut found = 0;
    for vertex in 1..way.legs() {
        let place = way.vertex(vertex);
        let ahead = ahead(vertex);
        let tolerance = way.vertex_tolerance(vertex);
        // Behind the vertex or beside it, and farther from it ever after. Past a sharp corner the
        // distance grows before it falls.
        let is_past = |cubic: &Cubic, x: f64| {
            let at = cubic.at(x);
            let off = sub(at.p, place);
            dot(off, at.d1) >= 0.0 && (dot(off, ahead) >= 0.0 || norm(off) <= NEAR * tolerance)
        };
        // Not much later than it was before.
        let until = (breaks.interval(before[vertex]).max(k) + LATER_INTERVALS).min(last);
        let (mut at, mut y, mut there) = (k, x, here);
        let mut low = y;
        let is_found = loop {
            if is_past(&there, y) {
                break true;
            }
            low = y;
            if y < width(at) {
                y = (y + 0.25 * width(at)).min(width(at));
            } else if at + 1 < until {
                (at, y, low) = (at + 1, 0.0, 0.0);
                there = cubic(at);
            } else {
                break false;
            }
        };
        if !is_found {
            continue;
        }
        if low < y {
            for _ in 0..PASSAGE_HALVINGS {
                let middle = 0.5 * (low + y);
                if is_past(&there, middle) {
                    y = middle;
                } else {
                    low = middle;
                }
            }
            // How far the curve is past the vertex, by its speed.
            let [before, behind] = [low, y].map(|x| {
                let at = there.at(x);
                dot(sub(at.p, place), at.d1)
            });
            if before < 0.0 && behind > 0.0 {
                y -= (y - low) * (behind / (behind - before));
            }
        }
        if norm(sub(there.at(y).p, place)) > FAR * tolerance {
            continue;
        }
        (k, x, here) = (at, y, there);
        passed[vertex] = breaks.0[k] + x;
        tell(vertex, unit(here.at(x).d1));
        spread(way, &mut passed, found, vertex);
        found = vertex;
    }
    let end = passed.len() - 1;
    passed[end] = breaks.0[last];
    spread(way, &mut passed, found, end);
    passed
}

/// Those between two vertices come one after the other, as on the way.
fn spread(way: &Way<'_>, passed: &mut [f64], first: usize, last: usize) {
    let w = way.parameters();
    let (from, span) = (passed[first], w[last] - w[first]);
    for k in first + 1..last {
        let part = if span > 0.0 {
            (w[k] - w[first]) / span
        } else {
            0.0
        };
        passed[k] = from + (passed[last] - from) * part;
    }
}
