//! Turns that bring one direction onto another: the closed forms behind every analytic inverse
//! here.
//!
//! Paden and Kahan's subproblems in the form of R. M. Murray, Z. Li, S. S. Sastry, A Mathematical
//! Introduction to Robotic Manipulation, CRC Press 1994, chapter 3.3.

use crate::rotation::Turning;
use lostmotion_base::Real;
use lostmotion_base::vec::{Vec3, constant, cross, dot, norm, scale, sub};

/// How far the cosine of a direction may lie beyond 1 and still be rounding.
const REACH_TOLERANCE: f64 = 1e-9;
/// Square of the sine of the angle to an axis below which a direction counts as the axis itself:
/// 1e-11 rad. Derived: there rounding of the direction (1e-16) makes the angle uncertain by 1e-5
/// rad.
const POLE_SINE_SQUARED: f64 = 1e-22;

/// Distance from 1 of the largest (or from -1 of the smallest) cosine that a pair of joints can give
/// at which the pole itself can be reached: rounding of the description's numbers.
const POLE_COSINE_ERROR: f64 = 1e-12;

/// Angles x that fulfil a cos x + b sin x = d: x = atan2(b, a) + / - atan2(sqrt((h - d)(h + d)), d)
/// with h = |(a, b)|. `above` and `below` are h - d and h + d, given because they may be known more
/// exactly than by subtraction. `None` if no angle does.
pub(crate) fn cosine<R: Real>(a: R, b: R, d: R, above: R, below: R) -> Option<[R; 2]> {
    let size = (a.value() * a.value() + b.value() * b.value()).sqrt();
    // Beyond the reach by more than rounding, or a pair that does not turn at all.
    if above.value() < -REACH_TOLERANCE * (1.0 + size)
        || below.value() < -REACH_TOLERANCE * (1.0 + size)
        || size == 0.0
    {
        return None;
    }
    // h^2 - d^2 as a product keeps its digits near a pole.
    let square = above * below;
    let root = if square.value() > 0.0 {
        square.sqrt()
    } else {
        R::constant(0.0)
    };
    let (middle, half) = (b.atan2(a), root.atan2(d));
    Some([middle + half, middle - half])
}

/// The angle about `u` that turns `from` to `to`, both seen along `u`; `None` if either lies on `u`.
pub(crate) fn about<R: Real>(u: [f64; 3], from: Vec3<R>, to: Vec3<R>) -> Option<R> {
    let along = constant(u);
    // What lies along u is taken off first: near u it would drown the rest.
    let flat = |v: Vec3<R>| sub(v, scale(along, dot(along, v)));
    let (p, q) = (flat(from), flat(to));
    let (sin, cos) = (dot(along, cross(p, q)), dot(p, q));
    let size = dot(from, from).value() * dot(to, to).value();
    let seen = sin.value() * sin.value() + cos.value() * cos.value();
    (seen > POLE_SINE_SQUARED * size * size).then(|| sin.atan2(cos))
}

/// Angles (a, b) with R(u1, a) R(u2, b) t = d for unit vectors. The first angle of a pair is `None`
/// where the direction lies on `u1` (the pole), so that any does.
///
/// With t = t_u u2 + t_p, u1 . R(u2, b) t = t_u (u1 . u2) + (u1 . t_p) cos b + u1 . (u2 x t) sin b
/// has to be u1 . d, which has two solutions or none; a follows from each.
pub(crate) fn two<R: Real>(
    u1: &Turning,
    u2: &Turning,
    t: [f64; 3],
    d: Vec3<R>,
) -> Option<[(Option<R>, R); 2]> {
    let along = dot(t, u2.u);
    let lean = dot(u1.u, u2.u);
    let a = dot(u1.u, t) - along * lean;
    let b = dot(u1.u, cross(u2.u, t));
    let h = (a * a + b * b).sqrt();
    let seen = dot(constant(u1.u), d);
    let offset = along * lean;
    // Near a pole u1 . d is near 1 and says nothing any more; the chord from u1 to d does.
    let chord = |sign: f64| {
        let away = sub(d, constant(u1.u.map(|c| sign * c)));
        dot(away, away) * R::constant(0.5)
    };
    // Cosines of the directions nearest to u1 and to its opposite that the second joint reaches.
    let (most, least) = (offset + h, offset - h);
    let above = if (most - 1.0).abs() < POLE_COSINE_ERROR {
        chord(1.0)
    } else {
        R::constant(most) - seen
    };
    let below = if (least + 1.0).abs() < POLE_COSINE_ERROR {
        chord(-1.0)
    } else {
        seen - R::constant(least)
    };
    let angles = cosine(
        R::constant(a),
        R::constant(b),
        seen - R::constant(offset),
        above,
        below,
    )?;
    Some(angles.map(|angle| (about(u1.u, u2.by(constant(t), angle), d), angle)))
}

/// The angle with R(u, a) t = d; `None` if no angle does, `Some(None)` where any does.
pub(crate) fn one(u: &Turning, t: [f64; 3], d: [f64; 3]) -> Option<Option<f64>> {
    let angle = about(u.u, t, d);
    let reached = u.by(t, angle.unwrap_or(0.0));
    (norm(sub(reached, d)) < REACH_TOLERANCE).then_some(angle)
}
