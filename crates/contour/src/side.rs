//! Small vector algebra, and the side on which a point lies.

use lostmotion_base::math;
use lostmotion_path::{Curve, Plane};

pub(crate) type Vector = [f64; 3];

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(crate) fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// Angle between two directions, rad, accurate for small angles; 0 if either has no length.
pub(crate) fn angle(a: Vector, b: Vector) -> f64 {
    math::atan2(norm(cross(a, b)), dot(a, b))
}

/// Part of a distance below which its component to the side says nothing about a side.
const SIDELESS: f64 = 1e-2;

/// +1 to the left of `travel` in the plane, -1 to the right. A point off the plane has the side of
/// its shadow on the plane. +1 where there is no side: travel along the normal, or an error along
/// the travel or the normal to within a hundredth.
pub(crate) fn side(error: Vector, travel: Vector, plane: Plane) -> f64 {
    let [first, second, _] = plane.axes();
    let shadow = math::hypot(travel[first], travel[second]);
    let left = travel[first] * error[second] - travel[second] * error[first];
    if left < -SIDELESS * shadow * norm(error) {
        -1.0
    } else {
        1.0
    }
}

/// Unit tangent and curvature vector (1/mm) of a curve in X Y Z.
pub(crate) fn frame(curve: &Curve, s: f64) -> (Vector, Vector) {
    let derivs = curve.eval(s);
    let (d1, d2) = (derivs.d1.linear(), derivs.d2.linear());
    let square = dot(d1, d1);
    if square <= 0.0 {
        return ([0.0; 3], [0.0; 3]);
    }
    let along = dot(d1, d2) / square;
    let speed = square.sqrt();
    (
        d1.map(|c| c / speed),
        std::array::from_fn(|i| (d2[i] - along * d1[i]) / square),
    )
}
