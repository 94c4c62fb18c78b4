//! Vectors in the plane and in space, over plain numbers and jets alike.
//!
//! A vector is an array, so that it costs nothing to pass on and every crate can name its
//! coordinates. Sums run from the first coordinate to the last: results are the same to the bit
//! wherever the same formula is used.
//!
//! ```
//! use lostmotion_base::vec::{cross, dot, norm, sub};
//!
//! let (a, b) = ([1.0, 2.0, 2.0], [1.0, 0.0, 0.0]);
//! assert_eq!(norm(a), 3.0);
//! assert_eq!(dot(cross(a, b), a), 0.0);
//! assert_eq!(sub(a, b), [0.0, 2.0, 2.0]);
//! ```

use crate::math;
use crate::real::Real;

/// Two coordinates in a plane.
pub type Vec2<R = f64> = [R; 2];
/// X, Y, Z.
pub type Vec3<R = f64> = [R; 3];

/// Shortest vector that [`unit`] takes for one with a direction. Tuned: a tenth of the smallest
/// length that machine files state, in mm or without a unit.
const SHORTEST_DIRECTION: f64 = 1e-9;

/// A vector of constants.
#[inline]
pub fn constant<R: Real, const N: usize>(v: [f64; N]) -> [R; N] {
    v.map(R::constant)
}

/// Sum.
#[inline]
pub fn add<R: Real, const N: usize>(a: [R; N], b: [R; N]) -> [R; N] {
    std::array::from_fn(|i| a[i] + b[i])
}

/// Difference `a - b`.
#[inline]
pub fn sub<R: Real, const N: usize>(a: [R; N], b: [R; N]) -> [R; N] {
    std::array::from_fn(|i| a[i] - b[i])
}

/// Product with a number.
#[inline]
pub fn scale<R: Real, const N: usize>(a: [R; N], factor: R) -> [R; N] {
    a.map(|c| c * factor)
}

/// The place a length along a direction from another place.
#[inline]
pub fn along<R: Real, const N: usize>(from: [R; N], direction: [R; N], length: R) -> [R; N] {
    std::array::from_fn(|i| from[i] + length * direction[i])
}

/// Scalar product.
#[inline]
pub fn dot<R: Real, const N: usize>(a: [R; N], b: [R; N]) -> R {
    const { assert!(N > 0, "a vector has at least one coordinate") };
    let mut sum = a[0] * b[0];
    for i in 1..N {
        sum = sum + a[i] * b[i];
    }
    sum
}

/// Cross product in space.
#[inline]
pub fn cross<R: Real>(a: Vec3<R>, b: Vec3<R>) -> Vec3<R> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Cross product in the plane: the signed area spanned, positive where `b` is to the left of `a`.
#[inline]
pub fn cross2<R: Real>(a: Vec2<R>, b: Vec2<R>) -> R {
    a[0] * b[1] - a[1] * b[0]
}

/// A vector of the plane turned by a quarter counter-clockwise.
#[inline]
pub const fn left_of([x, y]: Vec2) -> Vec2 {
    [-y, x]
}

/// Length: the root of the sum of squares.
#[inline]
pub fn norm<R: Real, const N: usize>(a: [R; N]) -> R {
    dot(a, a).sqrt()
}

/// Distance between two places of the plane, by `hypot`: right to the last digits, too, where the
/// squares would overflow or vanish.
#[inline]
pub fn distance2(a: Vec2, b: Vec2) -> f64 {
    math::hypot(b[0] - a[0], b[1] - a[1])
}

/// Direction of length 1 from one place of the plane to another; `None` if they are the same.
#[inline]
pub fn direction2(from: Vec2, to: Vec2) -> Option<Vec2> {
    let length = distance2(from, to);
    (length > 0.0).then(|| [(to[0] - from[0]) / length, (to[1] - from[1]) / length])
}

/// A vector of length 1 in the same direction; `None` for a vector shorter than 1e-9 or not finite.
#[inline]
pub fn unit(a: Vec3) -> Option<Vec3> {
    let length = norm(a);
    // An infinite length would pass the comparison alone, and give a vector of zeros.
    (length.is_finite() && length > SHORTEST_DIRECTION).then(|| a.map(|c| c / length))
}

/// A unit vector at right angles to a unit vector.
#[inline]
pub fn across(u: Vec3) -> Vec3 {
    // The coordinate axis that `u` is farthest from gives the best conditioned product.
    let farthest = if u[0].abs() <= u[1].abs() && u[0].abs() <= u[2].abs() {
        [1.0, 0.0, 0.0]
    } else if u[1].abs() <= u[2].abs() {
        [0.0, 1.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    let v = cross(u, farthest);
    scale(v, 1.0 / norm(v))
}

/// Angle between two directions, rad in [0, pi], accurate for small angles; 0 if either has no
/// length.
#[inline]
pub fn angle(a: Vec3, b: Vec3) -> f64 {
    // From sine and cosine together: acos alone loses half of the digits near 0 and pi.
    math::atan2(norm(cross(a, b)), dot(a, b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Jet;

    #[test]
    fn the_products_of_space_agree_with_each_other() {
        let (a, b) = ([1.0, -2.0, 0.5], [0.3, 4.0, -1.0]);
        let normal = cross(a, b);
        assert!(dot(normal, a).abs() < 1e-15 && dot(normal, b).abs() < 1e-15);
        // Lagrange: |a x b|^2 + (a . b)^2 = |a|^2 |b|^2
        let left = dot(normal, normal) + dot(a, b) * dot(a, b);
        assert!((left - dot(a, a) * dot(b, b)).abs() < 1e-12);
        let right_angle = across(unit(a).unwrap());
        assert!(dot(right_angle, a).abs() < 1e-15);
        assert!((norm(right_angle) - 1.0).abs() < 1e-15);
        assert!((angle(a, normal) - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    }

    #[test]
    fn jets_carry_their_derivatives_through_a_norm() {
        // |(s, 2 s, 2 s)| = 3 s at s = 1
        let s = Jet::new(1.0, 1.0, 0.0, 0.0);
        let two = Jet::constant(2.0);
        assert_eq!(norm([s, two * s, two * s]).0, [3.0, 3.0, 0.0, 0.0]);
    }

    #[test]
    fn a_vector_without_length_has_no_direction() {
        assert_eq!(unit([0.0, 0.0, 1e-10]), None);
        assert_eq!(unit([f64::NAN, 0.0, 1.0]), None);
        assert_eq!(direction2([1.0, 2.0], [1.0, 2.0]), None);
        assert_eq!(direction2([1.0, 2.0], [1.0, 4.0]), Some([0.0, 1.0]));
        assert_eq!(left_of([0.0, 1.0]), [-1.0, 0.0]);
        assert_eq!(cross2([1.0, 0.0], [0.0, 1.0]), 1.0);
        assert!((distance2([0.0, 0.0], [3e200, 4e200]) / 5e200 - 1.0).abs() < 1e-15);
    }
}
