//! Blends: a polynomial piece in place of the last stretch of one curve and the first of the next.

use super::tube::LinearJoint;
use crate::piece::{PathStep, Piece, Programmed, Soft, size};
use lostmotion_base::Coords;
use lostmotion_path::{Curve, CurveDerivs, HermiteEnd, Quintic};

/// Parts of either half of a blend on which its deviation is bounded. A choice: the bound holds
/// whatever their number; more make it tighter and cost time.
const DEVIATION_PARTS: usize = 8;
/// How often a blend that leaves its tolerance is shortened before the corner is given up. A
/// choice: each shortens to between 0.3 and 0.97 of the length, and a few suffice where the first
/// guess is near.
const MAX_ATTEMPTS: usize = 24;
/// Largest deviation of a blend of half length d at a corner with the tangents t0 and t1, in units
/// of d |t1 - t0|: 3/16, by the quintic's value in the middle.
const CORNER_DEVIATION: f64 = 0.1875;
/// Largest deviation at a step k of the second derivative, in units of d2 k. Derived: 0.01074 for
/// the quintic over that step (computed), rounded up.
const CURVATURE_DEVIATION: f64 = 0.0108;

/// Lengths of a blend that are tried: one that takes all of its room may bend more than a shorter
/// one. A choice: each costs a comparison with a stop.
const LENGTH_TRIES: usize = 3;
/// Length of each try as a part of the one before. A choice: three tries reach half of the first
/// length.
const LENGTH_FACTOR: f64 = 0.7;

/// Decides between a blend and a stop.
pub(crate) trait Judge {
    /// Whether the blend is faster than coming to rest at the corner, whose tolerance is given in
    /// mm.
    fn is_faster(
        &self,
        blend: &Piece,
        before: &Programmed,
        next: &Programmed,
        tolerance: f64,
    ) -> bool;

    /// About how long the motion along steps takes from rest to rest, s.
    fn time_s(&self, steps: &[PathStep]) -> f64;

    /// The same with each piece by itself, if jerk cost no more than the longest window.
    fn ideal_s(&self, steps: &[PathStep]) -> f64;

    /// A part of the time; `None` where even a straight way as long at the same feeds takes that
    /// long.
    fn time_to_beat_s(&self, steps: &[PathStep], part: f64) -> Option<f64>;

    /// The joints that a straight way at a place moves; none where that cannot be told.
    fn joints_at(&self, place: &Coords, tool_mm: &[f64; 3]) -> Vec<LinearJoint>;

    /// How soft the motions before and after a stop should be, so that they may overlap.
    fn soft(&self, before: &Programmed, next: &Programmed, tolerance: f64) -> Option<Soft>;
}

/// A blend that keeps its tolerance.
#[derive(Clone, Copy, Debug)]
struct Blend {
    quintic: Quintic,
    /// Length taken from either neighbour.
    half: f64,
}

/// The longest blend between two moves that takes at most `longest` of either and is faster than a
/// stop; `None` if there is none.
pub(super) fn best_blend(
    before: &Programmed,
    next: &Programmed,
    tolerance: f64,
    longest: f64,
    judge: &dyn Judge,
) -> Option<(f64, Piece)> {
    let mut room = longest;
    // The longest blend first. Where it bends so much that a stop is faster, a shorter one may
    // still win.
    for _ in 0..LENGTH_TRIES {
        let blend = longest_blend(&before.curve, &next.curve, tolerance, room)?;
        let piece = join(&blend, before, next);
        if judge.is_faster(&piece, before, next, tolerance) {
            return Some((blend.half, piece));
        }
        room = LENGTH_FACTOR * blend.half;
    }
    None
}

/// The piece that a blend makes.
fn join(blend: &Blend, before: &Programmed, next: &Programmed) -> Piece {
    let marks = [
        before.mark(0.0, before.length - blend.half),
        next.mark(blend.half, 0.0),
    ];
    let heeds = before.heeds.max(next.heeds);
    Piece {
        curve: blend.quintic.into(),
        marks,
        more: Box::default(),
        feed: before.feed.min(next.feed),
        heeds,
        tool_mm: next.tool_mm,
    }
}

/// The longest blend between the end of one curve and the start of the next that stays within the
/// tolerance, at most `longest` on either side; `None` if even a tiny one does not.
fn longest_blend(before: &Curve, after: &Curve, tolerance: f64, longest: f64) -> Option<Blend> {
    let (end, start) = (before.eval(before.length()), after.eval(0.0));
    // First guess: the deviations that the steps of tangent and curvature alone would cause.
    let corner = size(&(start.d1 - end.d1));
    let step = size(&(start.d2 - end.d2));
    let mut half = longest;
    half = half.min(tolerance / (CORNER_DEVIATION * corner).max(f64::MIN_POSITIVE));
    half = half.min((tolerance / (CURVATURE_DEVIATION * step).max(f64::MIN_POSITIVE)).sqrt());
    for _ in 0..MAX_ATTEMPTS {
        if half <= longest * 1e-9 {
            return None;
        }
        let blend = Blend {
            quintic: hermite(before, after, half)?,
            half,
        };
        let deviation = deviation(&blend, before, after);
        if deviation <= tolerance {
            return Some(blend);
        }
        // Shortened by about what the deviation is too large.
        half *= (tolerance / deviation).clamp(0.3, 0.97);
    }
    None
}

fn hermite(before: &Curve, after: &Curve, half: f64) -> Option<Quintic> {
    let end = |derivs: CurveDerivs| HermiteEnd {
        p: derivs.p,
        d1: derivs.d1,
        d2: derivs.d2,
    };
    let (first, last) = (before.eval(before.length() - half), after.eval(half));
    Quintic::hermite(end(first), end(last), 2.0 * half).ok()
}

/// Upper bound of the distance between the blend and the curves that it replaces, point by point at
/// the same parameter.
fn deviation(blend: &Blend, before: &Curve, after: &Curve) -> f64 {
    let half = blend.half;
    let start = before.length() - half;
    let third = |curve: &Curve, s0: f64, s1: f64| size(&curve.max_derivatives(s0, s1).2);
    // On either half the difference has a third derivative of at most the sum of both.
    let first =
        third(before, start, before.length()) + size(&blend.quintic.max_derivatives(0.0, half).2);
    let second = third(after, 0.0, half) + size(&blend.quintic.max_derivatives(half, 2.0 * half).2);
    let at = |s: f64| blend.quintic.eval(s);
    one_side(half, first, |x| difference(&at(x), &before.eval(start + x))).max(one_side(
        half,
        second,
        |x| difference(&at(half + x), &after.eval(x)),
    ))
}

/// Distance of two points, and of their second derivatives.
fn difference(a: &CurveDerivs, b: &CurveDerivs) -> (f64, f64) {
    (size(&(a.p - b.p)), size(&(a.d2 - b.d2)))
}

/// Bound of a difference over `[0, length]` from its values, its second derivatives and a bound of
/// its third: a function leaves the chord of an interval h by at most h2/8 times its largest second
/// derivative.
fn one_side(length: f64, third: f64, at: impl Fn(f64) -> (f64, f64)) -> f64 {
    let step = length / DEVIATION_PARTS as f64;
    let mut bound = 0.0_f64;
    let mut left = at(0.0);
    for part in 1..=DEVIATION_PARTS {
        let right = at(step * part as f64);
        // Between two places the second derivative passes the larger one by at most half the step
        // times the third.
        let second = left.1.max(right.1) + 0.5 * step * third;
        bound = bound.max(left.0.max(right.0) + step * step / 8.0 * second);
        left = right;
    }
    bound
}
