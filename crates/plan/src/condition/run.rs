//! Runs: polylines that stand for curves, replaced by a smooth curve through their vertices.
//!
//! A cubic spline by chord length through the vertices gives first and second derivatives there;
//! polynomial pieces of degree five take them over, so that neighbours agree exactly in both. A
//! spline's third derivative is nearly that of the curve which the program's vertices were taken
//! from, which is what keeps the jerk low. Each piece is bounded against its chord; where it leaves
//! the tolerance its ends fall back to the direction of their longer chord, which cannot.

use super::fair::{self, Point};
use crate::piece::size;
use crate::piece::{Piece, Programmed};
use lostmotion_base::Coords;
use lostmotion_path::{Curve, HermiteEnd, Quintic};

/// Part of the tolerance by which a vertex may be moved. Record 38 of the decisions.
const FAIRED_PART: f64 = 0.88;
/// Tries with bounds narrowed near a piece that leaves the tolerance, and as many more in which
/// bounds there are zero; then the piece falls back. A choice: four halvings leave a sixteenth of
/// the bound.
const MAX_FAIRINGS: usize = 4;
/// Factor on the bounds near a piece that leaves the tolerance. A choice: with `MAX_FAIRINGS` a
/// sixteenth is left before vertices are held.
const BOUND_SHRINK: f64 = 0.5;

/// A vertex with the derivatives that the pieces on both sides share.
pub(super) type RunKnot = HermiteEnd;

/// A chord of a run: part of a programmed line.
#[derive(Clone, Copy, Debug)]
pub(super) struct RunChord<'a> {
    pub(super) line: &'a Programmed,
    pub(super) from: f64,
    pub(super) to: f64,
}

impl RunChord<'_> {
    pub(super) fn length(&self) -> f64 {
        self.to - self.from
    }

    fn direction(&self) -> Coords {
        self.line.curve.eval(0.0).d1
    }

    /// The programmed line itself has these derivatives.
    pub(super) fn knot(&self, s: f64) -> RunKnot {
        RunKnot {
            p: self.line.curve.point(s),
            d1: self.direction(),
            d2: Coords::ZERO,
        }
    }
}

/// Knots of a run from its first one, which is given, to the end of its last chord, whose direction
/// it takes there.
///
/// The knots after the first one are `carried` over from the run's last part, the others are
/// faired: see [`fair`].
pub(super) fn knots(
    first: RunKnot,
    chords: &[RunChord<'_>],
    carried: &[Coords],
    tolerance: f64,
    length: f64,
) -> Vec<RunKnot> {
    let mut vertices = vec![first];
    for chord in chords {
        vertices.push(chord.knot(chord.to));
    }
    for (knot, p) in vertices.iter_mut().skip(1).zip(carried) {
        knot.p = *p;
    }
    // Given vertices stay: the first, those carried over, and the last.
    let mut bounds = vec![FAIRED_PART * tolerance; vertices.len()];
    bounds[..=carried.len().min(chords.len())].fill(0.0);
    bounds[chords.len()] = 0.0;
    let mut knots = Vec::new();
    // The exact bound of each piece judges the fairing. Where it fails vertices may move less, in
    // the end not at all.
    for tries in 0..2 * MAX_FAIRINGS {
        knots = faired(&vertices, chords, &bounds, length);
        smooth(&mut knots, chords);
        let mut kept = true;
        for (j, chord) in chords.iter().enumerate() {
            if !keeps(&knots[j], &knots[j + 1], chord, tolerance) {
                kept = false;
                tighten(
                    &mut bounds,
                    j,
                    if tries < MAX_FAIRINGS {
                        BOUND_SHRINK
                    } else {
                        0.0
                    },
                );
            }
        }
        if kept {
            return knots;
        }
    }
    settle(&mut knots, chords, tolerance);
    knots
}

/// Narrows the bounds at both ends of a chord; where that is to nothing, its neighbours' too.
fn tighten(bounds: &mut [f64], chord: usize, factor: f64) {
    let around = if factor > 0.0 { 0 } else { 1 };
    let last = bounds.len().min(chord + 2 + around);
    if let Some(bounds) = bounds.get_mut(chord.saturating_sub(around)..last) {
        bounds.iter_mut().for_each(|bound| *bound *= factor);
    }
}

/// The vertices moved to where the curve through them bends evenly; it goes on as the first knot
/// and the last chord say.
fn faired(
    vertices: &[RunKnot],
    chords: &[RunChord<'_>],
    bounds: &[f64],
    length: f64,
) -> Vec<RunKnot> {
    let mut points = Vec::with_capacity(vertices.len() + 4);
    let (Some(first), Some(last)) = (vertices.first(), vertices.last()) else {
        return Vec::new();
    };
    let outside = |knot: &RunKnot, u: f64, x: f64| Point {
        p: knot.p + (knot.d1 + knot.d2 * (0.5 * x)) * x,
        u: u + x,
        bound: 0.0,
    };
    let (h, g) = (
        chords.first().map_or(1.0, RunChord::length),
        chords.last().map_or(1.0, RunChord::length),
    );
    // Two fixed points beyond either end continue direction and bend there, so that the third
    // differences at the ends count.
    points.extend([-2.0, -1.0].map(|k| outside(first, 0.0, k * h)));
    let mut u = 0.0;
    for (k, (vertex, bound)) in vertices.iter().zip(bounds).enumerate() {
        points.push(Point {
            p: vertex.p,
            u,
            bound: *bound,
        });
        u += chords.get(k).map_or(0.0, RunChord::length);
    }
    points.extend([1.0, 2.0].map(|k| outside(last, u, k * g)));
    let offsets = fair::offsets(&points, length);
    vertices
        .iter()
        .zip(&offsets[2..])
        .map(|(vertex, offset)| RunKnot {
            p: vertex.p + *offset,
            ..*vertex
        })
        .collect()
}

fn keeps(from: &RunKnot, to: &RunKnot, chord: &RunChord<'_>, tolerance: f64) -> bool {
    quintic(from, to, chord).is_some_and(|q| deviation(&q, chord, tolerance) <= tolerance)
}

/// First and second derivatives of the cubic spline with given slopes at both ends.
fn smooth(knots: &mut [RunKnot], chords: &[RunChord<'_>]) {
    let n = chords.len();
    let secant =
        |j: usize, knots: &[RunKnot]| (knots[j + 1].p - knots[j].p) * (1.0 / chords[j].length());
    let mut factor = vec![0.0; n + 1];
    // Continuity of the second derivative gives a tridiagonal system for the slopes (elimination,
    // then back substitution).
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
    // Second derivatives from the slopes at both ends of the chord after the vertex.
    for j in 1..n {
        let bend = secant(j, knots) * 6.0 - knots[j].d1 * 4.0 - knots[j + 1].d1 * 2.0;
        knots[j].d2 = bend * (1.0 / chords[j].length());
    }
}

/// Falls back where a piece leaves the tolerance, until none does.
fn settle(knots: &mut [RunKnot], chords: &[RunChord<'_>], tolerance: f64) {
    let mut fallen = vec![false; knots.len()];
    let mut again = true;
    while again {
        again = false;
        for (j, chord) in chords.iter().enumerate() {
            if keeps(&knots[j], &knots[j + 1], chord, tolerance) {
                continue;
            }
            for k in [j, j + 1] {
                if let Some(knot) = knots
                    .get_mut(k)
                    .filter(|_| k > 0 && k < chords.len() && !fallen[k])
                {
                    fallen[k] = true;
                    again = true;
                    // At the programmed vertex in the direction of its longer chord a piece cannot
                    // leave the tolerance.
                    let longer = if chords[k - 1].length() >= chords[k].length() {
                        &chords[k - 1]
                    } else {
                        &chords[k]
                    };
                    *knot = RunKnot {
                        d1: longer.direction(),
                        d2: Coords::ZERO,
                        ..chords[k - 1].knot(chords[k - 1].to)
                    };
                }
            }
        }
    }
}

fn quintic(from: &RunKnot, to: &RunKnot, chord: &RunChord<'_>) -> Option<Quintic> {
    Quintic::hermite(*from, *to, chord.length()).ok()
}

/// Bound of the distance between a piece and its chord: that of its control points, after halving
/// it where that is not near enough.
fn deviation(quintic: &Quintic, chord: &RunChord<'_>, tolerance: f64) -> f64 {
    let (start, direction, length) = (
        chord.line.curve.point(chord.from),
        chord.direction(),
        chord.length(),
    );
    let axis = Coords::xyz(direction.0[0], direction.0[1], direction.0[2]);
    // The curve lies within the hull of its control points.
    let farthest = |part: &Quintic| {
        let distance = |point: Coords| {
            let along = (point - start).dot(&axis).max(0.0).min(length);
            size(&(point - (start + direction * along)))
        };
        part.control_points()
            .into_iter()
            .map(distance)
            .fold(0.0, f64::max)
    };
    // Those of the halves are means of them, and no farther.
    let whole = farthest(quintic);
    if whole <= tolerance {
        return whole;
    }
    let middle = 0.5 * length;
    farthest(&quintic.sub(0.0, middle)).max(farthest(&quintic.sub(middle, length)))
}

/// The piece over a chord.
pub(super) fn piece(from: &RunKnot, to: &RunKnot, chord: &RunChord<'_>) -> Piece {
    let part = chord.line.part(chord.from, chord.to);
    match quintic(from, to, chord) {
        Some(quintic) => Piece {
            curve: Curve::Quintic(quintic),
            ..part
        },
        None => part,
    }
}
