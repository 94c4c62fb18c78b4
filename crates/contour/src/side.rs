//! The side of the path on which a point lies.

use lostmotion_base::math;
use lostmotion_base::vec::{Vec3, dot, norm};
use lostmotion_path::{Curve, Plane};

/// Least share of an error that has to point to the right for its sign to be negative. A choice:
/// 0.6 degrees.
const MIN_SIDE_SHARE: f64 = 1e-2;

/// +1 to the left of `travel` in the plane, -1 to the right. A point off the plane has the side of
/// its shadow on the plane. +1 where there is no side: travel along the normal, or an error along
/// the travel or the normal to within a hundredth.
pub(crate) fn side(error: Vec3, travel: Vec3, plane: Plane) -> f64 {
    let [first, second, _] = plane.axes();
    // Cross product of travel and error, both as shadows on the plane.
    let shadow = math::hypot(travel[first], travel[second]);
    let left = travel[first] * error[second] - travel[second] * error[first];
    // Rounding must not flip the sign of an error that points along the travel or the normal.
    if left < -MIN_SIDE_SHARE * shadow * norm(error) {
        -1.0
    } else {
        1.0
    }
}

/// Unit tangent and curvature vector (1/mm) of a curve in X Y Z.
pub(crate) fn frame(curve: &Curve, s: f64) -> (Vec3, Vec3) {
    let derivs = curve.eval(s);
    let (d1, d2) = (derivs.d1.linear(), derivs.d2.linear());
    let square = dot(d1, d1);
    // X Y Z stand still: no direction, and no curvature.
    if square <= 0.0 {
        return ([0.0; 3], [0.0; 3]);
    }
    // Curvature vector: the part of p'' across the tangent, over |p'|^2.
    let along = dot(d1, d2) / square;
    let speed = square.sqrt();
    (
        d1.map(|c| c / speed),
        std::array::from_fn(|i| (d2[i] - along * d1[i]) / square),
    )
}
