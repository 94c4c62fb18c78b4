//! Directions of travel, and the side of the path on which a point lies.

use lostmotion_base::math;
use lostmotion_base::vec::{Vec3, add, dot, norm, scale, unit};
use lostmotion_path::{Curve, Plane};

/// Least share of an error that has to point to the right for its sign to be negative. A choice:
/// 0.6 degrees.
const MIN_SIDE_SHARE: f64 = 1e-2;

/// Length of the sum of two unit tangents below which they point against each other. A choice:
/// within 1e-6 rad of a straight return no bisector has a meaning.
const STRAIGHT_BACK: f64 = 1e-6;

/// Directions of travel at a foot point: of its segment and, at a joint, of the neighbours.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tangents {
    pub(crate) own: Vec3,
    /// Of the segment before, where the foot point is its end.
    pub(crate) before: Option<Vec3>,
    /// Of the segment after, where the foot point is its start.
    pub(crate) after: Option<Vec3>,
}

impl Tangents {
    /// The mean direction, not of unit length: at a joint the bisector.
    pub(crate) fn mean(&self) -> Vec3 {
        let mut travel = self.own;
        for neighbour in [self.before, self.after].into_iter().flatten() {
            travel = add(travel, neighbour);
        }
        // Straight back: there is no bisector, the segment's own direction is taken.
        if norm(travel) < STRAIGHT_BACK {
            self.own
        } else {
            travel
        }
    }

    /// The unit direction of travel at right angles to an error whose foot point this is.
    ///
    /// On the outside of a corner the error turns about the vertex from a right angle to the
    /// direction before to a right angle to the one after; the direction of travel turns with it.
    pub(crate) fn across(&self, off: Vec3) -> Vec3 {
        if self.before.is_none() && self.after.is_none() {
            return self.own;
        }
        let (first, last) = (
            self.before.unwrap_or(self.own),
            self.after.unwrap_or(self.own),
        );
        // Of all combinations a first + b last with a, b >= 0, the one that off is across.
        let (a, b) = (-dot(off, last), dot(off, first));
        let turned = add(scale(first, a.max(0.0)), scale(last, b.max(0.0)));
        // Across both, as above a corner of the plane, or on the path: the bisector.
        unit(turned)
            .or_else(|| unit(self.mean()))
            .unwrap_or(self.own)
    }
}

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
