//! The box around a curve that has no closed form for it.

use crate::{Bounds, Curve};
use lostmotion_base::{AXES, Coords};

/// How far the box may reach beyond the curve, mm or rad: far below any travel limit's meaning.
const BOX_TOLERANCE: f64 = 1e-6;
const MAX_BOX_HALVINGS: u32 = 24;

/// The box around a curve, never too small and at most a nanometre too large: a stretch of length h
/// lies within M h^2 / 8 of its chord, M bounding the second derivative; stretches which could
/// reach further out than what is known are halved.
pub(crate) fn search(curve: &Curve) -> Bounds {
    let mut bounds = Bounds::of(curve.start(), curve.end());
    let mut slack = Coords::ZERO;
    grow(
        curve,
        (0.0, curve.length()),
        (curve.start(), curve.end()),
        MAX_BOX_HALVINGS,
        &mut bounds,
        &mut slack,
    );
    Bounds {
        min: bounds.min - slack,
        max: bounds.max + slack,
    }
}

fn grow(
    curve: &Curve,
    (s0, s1): (f64, f64),
    (p0, p1): (Coords, Coords),
    depth: u32,
    bounds: &mut Bounds,
    slack: &mut Coords,
) {
    let second = curve.max_derivatives(s0, s1).1;
    let h = s1 - s0;
    let mut halve = false;
    let mut reach = Coords::ZERO;
    for axis in 0..AXES {
        let bulge = second.0[axis] * h * h / 8.0;
        let (low, high) = (p0.0[axis].min(p1.0[axis]), p0.0[axis].max(p1.0[axis]));
        let beyond = (bounds.min.0[axis] - (low - bulge)).max(high + bulge - bounds.max.0[axis]);
        halve |= beyond > BOX_TOLERANCE;
        reach.0[axis] = beyond.max(0.0);
    }
    if halve && depth > 0 {
        let middle = 0.5 * (s0 + s1);
        let p = curve.point(middle);
        bounds.include(p);
        grow(curve, (s0, middle), (p0, p), depth - 1, bounds, slack);
        grow(curve, (middle, s1), (p, p1), depth - 1, bounds, slack);
    } else {
        for axis in 0..AXES {
            slack.0[axis] = slack.0[axis].max(reach.0[axis]);
        }
    }
}
