//! When a motion passes the vertices of its way.

use super::Motion;
use crate::condition::tube::Cubic;
use crate::condition::tube::way::unit;
use lostmotion_base::vec::{dot, norm, sub};

/// Halvings of a quarter of an interval after which a chord tells the time of a vertex well enough: to some
/// millionths of an interval.
const PASSAGE_HALVINGS: u32 = 6;
/// Distances from a vertex, in units of the tolerance, at which the curve is beside it, and beyond
/// which it has not come to it. Choices.
const NEAR: f64 = 2.0;
const FAR: f64 = 16.0;
/// Intervals by which a vertex may be passed later than it was before.
const LATER_INTERVALS: usize = 16;

impl Motion<'_, '_> {
    /// When each vertex is passed, and where the curve leads to there: where it is nearest to it, one
    /// after the other.
    pub(super) fn pass(&mut self) {
        let states = self.breaks.states(&self.coefficients);
        let last = self.breaks.intervals();
        let width = |k: usize| self.breaks.0[k + 1] - self.breaks.0[k];
        let cubic = |k: usize| Cubic::new(&states[k], &states[k + 1], width(k));
        let (mut k, mut x) = (0, 0.0);
        let mut here = cubic(0);
        let mut passed = vec![0.0; self.passed.len()];
        let mut found = 0;
        for vertex in 1..self.way.legs() {
            let place = self.way.vertex(vertex);
            let ahead = self.ahead[vertex];
            let tolerance = self.way.vertex_tolerance(vertex);
            // Behind the vertex or beside it, and farther from it ever after. Past a sharp corner the
            // distance grows before it falls.
            let is_past = |cubic: &Cubic, x: f64| {
                let at = cubic.at(x);
                let off = sub(at.p, place);
                dot(off, at.d1) >= 0.0 && (dot(off, ahead) >= 0.0 || norm(off) <= NEAR * tolerance)
            };
            // Not much later than it was before.
            let until =
                (self.breaks.interval(self.passed[vertex]).max(k) + LATER_INTERVALS).min(last);
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
            passed[vertex] = self.breaks.0[k] + x;
            self.directions[vertex] = unit(here.at(x).d1);
            self.spread(&mut passed, found, vertex);
            found = vertex;
        }
        let end = passed.len() - 1;
        passed[end] = self.breaks.0[last];
        self.spread(&mut passed, found, end);
        self.passed = passed;
    }

    /// Those between two vertices come one after the other, as on the way.
    fn spread(&self, passed: &mut [f64], first: usize, last: usize) {
        let w = self.way.parameters();
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
}
