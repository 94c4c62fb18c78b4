//! Runs: polylines that stand for curves, replaced by a smooth curve through their vertices.
//!
//! A cubic spline by chord length through the vertices gives first and second derivatives there; polynomial pieces of degree
//! five take them over, so that neighbours agree exactly in both. A spline's third derivative is nearly that of the curve
//! which the program's vertices were taken from, which is what keeps the jerk low. Each piece is bounded against its chord;
//! where it leaves the tolerance its ends fall back to the direction of their longer chord, which cannot.

use super::blend::size;
use super::piece::{Piece, Programmed};
use lostmotion_base::Coords;
use lostmotion_path::{Curve, HermiteEnd, Quintic};

/// A vertex with the derivatives that the pieces on both sides share.
pub(super) type Knot = HermiteEnd;

/// A chord of a run: part of a programmed line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chord {
    pub(super) line: Programmed,
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Chord {
    pub(super) fn length(&self) -> f64 {
        self.to - self.from
    }

    fn direction(&self) -> Coords {
        self.line.curve.eval(0.0).d1
    }

    /// The programmed line itself has these derivatives.
    pub(super) fn knot(&self, s: f64) -> Knot {
        Knot { p: self.line.curve.point(s), d1: self.direction(), d2: Coords::ZERO }
    }
}

/// Knots of a run from its first one, which is given, to the end of its last chord, whose direction it takes there.
pub(super) fn knots(first: Knot, chords: &[Chord], tolerance: f64) -> Vec<Knot> {
    let mut knots = vec![first];
    for chord in chords {
        knots.push(chord.knot(chord.to));
    }
    smooth(&mut knots, chords);
    settle(&mut knots, chords, tolerance);
    knots
}

/// First and second derivatives of the cubic spline with given slopes at both ends.
fn smooth(knots: &mut [Knot], chords: &[Chord]) {
    let n = chords.len();
    let secant = |j: usize, knots: &[Knot]| (knots[j + 1].p - knots[j].p) * (1.0 / chords[j].length());
    let mut factor = vec![0.0; n + 1];
    for j in 1..n {
        let (left, right) = (1.0 / chords[j - 1].length(), 1.0 / chords[j].length());
        let sum = (secant(j - 1, knots) * left + secant(j, knots) * right) * 3.0;
        let pivot = 2.0 * (left + right) - left * factor[j - 1];
        factor[j] = right / pivot;
        let known = knots[j - 1].d1;
        knots[j].d1 = (sum - known * left) * (1.0 / pivot);
    }
    for j in (1..n).rev() {
        let next = knots[j + 1].d1;
        knots[j].d1 = knots[j].d1 - next * factor[j];
    }
    for j in 1..n {
        let bend = secant(j, knots) * 6.0 - knots[j].d1 * 4.0 - knots[j + 1].d1 * 2.0;
        knots[j].d2 = bend * (1.0 / chords[j].length());
    }
}

/// Falls back where a piece leaves the tolerance, until none does.
fn settle(knots: &mut [Knot], chords: &[Chord], tolerance: f64) {
    let mut fallen = vec![false; knots.len()];
    let mut again = true;
    while again {
        again = false;
        for (j, chord) in chords.iter().enumerate() {
            if quintic(&knots[j], &knots[j + 1], chord).is_some_and(|q| deviation(&q, chord) <= tolerance) {
                continue;
            }
            for k in [j, j + 1] {
                if k > 0 && k < chords.len() && !fallen[k] {
                    fallen[k] = true;
                    again = true;
                    let longer = if chords[k - 1].length() >= chords[k].length() { &chords[k - 1] } else { &chords[k] };
                    knots[k].d1 = longer.direction();
                    knots[k].d2 = Coords::ZERO;
                }
            }
        }
    }
}

fn quintic(from: &Knot, to: &Knot, chord: &Chord) -> Option<Quintic> {
    Quintic::hermite(*from, *to, chord.length()).ok()
}

/// Bound of the distance between a piece and its chord: that of its control points, after halving it.
fn deviation(quintic: &Quintic, chord: &Chord) -> f64 {
    let (start, direction, length) = (chord.line.curve.point(chord.from), chord.direction(), chord.length());
    let axis = Coords::xyz(direction.0[0], direction.0[1], direction.0[2]);
    let middle = 0.5 * length;
    let halves = [quintic.sub(0.0, middle), quintic.sub(middle, length)];
    let points = halves.into_iter().flat_map(|half| half.control_points());
    points
        .map(|point| {
            let along = (point - start).dot(&axis).max(0.0).min(length);
            size(&(point - (start + direction * along)))
        })
        .fold(0.0, f64::max)
}

/// The piece over a chord.
pub(super) fn piece(from: &Knot, to: &Knot, chord: &Chord) -> Piece {
    let part = chord.line.part(chord.from, chord.to);
    match quintic(from, to, chord) {
        Some(quintic) => Piece { curve: Curve::Quintic(quintic), ..part },
        None => part,
    }
}
