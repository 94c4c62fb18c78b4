//! An arc as programs describe it.

use crate::error::finite;
use crate::{PathError, Plane};
use lostmotion_base::{Coords, math};
use std::f64::consts::TAU;

/// An arc whose end is nearer than this to its start, along the circle, is a full turn, mm. Offsets
/// and inches leave the two ends of a programmed circle some 1e-12 mm apart; a programmed
/// arc is longer than a nanometre.
const SAME_POINT_MM: f64 = 1e-6;

/// An arc as RS274 describes it.
///
/// ```
/// use lostmotion_base::{Coords, Plane};
/// use lostmotion_path::{Arc, ArcSpec, Curve};
///
/// // G2 X10 Y0 I5 with the tool at zero: half a circle, clockwise, 4 mm deep.
/// let arc = Arc::new(ArcSpec {
///     start: Coords::ZERO,
///     end: Coords::xyz(10.0, 0.0, -4.0),
///     plane: Plane::Xy,
///     center: [5.0, 0.0],
///     rotation: -1,
/// })?;
/// assert!((arc.sweep() + std::f64::consts::PI).abs() < 1e-12);
/// let helix = Curve::from(arc);
/// let middle = helix.point(0.5 * helix.length());
/// assert!((middle.linear()[1] - 5.0).abs() < 1e-12 && (middle.linear()[2] + 2.0).abs() < 1e-12);
/// # Ok::<(), lostmotion_path::PathError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcSpec {
    /// Where it begins, mm and rad.
    pub start: Coords,
    /// Where it ends, mm and rad. It need not lie on the circle through the start: the radius then
    /// changes linearly in angle.
    pub end: Coords,
    /// Plane of the circle.
    pub plane: Plane,
    /// Centre, in the order of the plane's axes ([`Plane::axes`]), mm.
    pub center: [f64; 2],
    /// Positive: counter-clockwise about the plane's normal. 1: at most one turn, 2: one turn more,
    /// and so on; negative numbers clockwise. Equal start and end angle make a full turn.
    pub rotation: i32,
}

/// Offset from the centre in the plane: first and second axis.
pub(crate) fn from_center(point: &Coords, plane: Plane, center: [f64; 2]) -> [f64; 2] {
    let [first, second, _] = plane.axes();
    [point.0[first] - center[0], point.0[second] - center[1]]
}

/// Signed sweep from one offset to another, rad.
pub(crate) fn sweep_between(from: [f64; 2], to: [f64; 2], rotation: i32, radius: f64) -> f64 {
    let sign = if rotation > 0 { 1.0 } else { -1.0 };
    let between = math::atan2(
        from[0] * to[1] - from[1] * to[0],
        from[0] * to[0] + from[1] * to[1],
    ) * sign;
    let smallest = SAME_POINT_MM / radius.max(SAME_POINT_MM);
    // Within one turn: the smallest angles of either sign count as the full turn that they are
    // meant to be.
    let first = if between <= smallest {
        between + TAU
    } else {
        between
    };
    sign * (first + TAU * f64::from(rotation.unsigned_abs() - 1))
}

/// Refuses numbers that are not finite.
pub(crate) fn check(spec: &ArcSpec) -> Result<(), PathError> {
    finite("the start of the arc", &spec.start.0)?;
    finite("the end of the arc", &spec.end.0)?;
    finite("the centre of the arc", &spec.center)
}
