//! Bounds of an arc's derivatives over a stretch.

use crate::derivs::within;
use crate::{Arc, Bounds};
use lostmotion_base::{Coords, math};
use std::f64::consts::{FRAC_PI_2, PI};

/// Largest |cos| over the angles from `a` to `b`.
fn max_abs_cos(a: f64, b: f64) -> f64 {
    let (low, high) = (a.min(b), a.max(b));
    // A multiple of pi lies between them.
    if (high / PI).floor() * PI >= low {
        1.0
    } else {
        math::cos(low).abs().max(math::cos(high).abs())
    }
}

impl Arc {
    /// Upper bounds of the magnitude of each axis' first three derivatives by s, from `s0` to `s1`.
    /// Exact on circles and helices; on spirals exact in the limit of short stretches and small
    /// change of radius.
    pub fn max_derivatives(&self, s0: f64, s1: f64) -> (Coords, Coords, Coords) {
        if self.length <= 0.0 {
            return (Coords::ZERO, Coords::ZERO, Coords::ZERO);
        }
        let (u0, u1) = (self.fraction(s0), self.fraction(s1));
        let spiral = self.spiral();
        let (k, b) = (spiral.k, spiral.b.abs());
        let (ra, rb) = (spiral.radius(u0), spiral.radius(u1));
        let r = ra.max(rb);
        // The fastest u runs where the radius is smallest: see `rates` for the terms.
        let w = 1.0 / spiral.speed(if ra < rb { u0 } else { u1 });
        // Bounds of the derivatives of w = du/ds by s.
        let (w_d1, w_d2) = (k * b * w * w * w, 5.0 * k * k * b * b * w * w * w * w * w);
        let (a0, a1) = (
            self.start_angle + self.sweep * u0,
            self.start_angle + self.sweep * u1,
        );
        // Parts of the radial and the tangential direction in each axis of the plane.
        let cos = max_abs_cos(a0, a1);
        let sin = max_abs_cos(a0 - FRAC_PI_2, a1 - FRAC_PI_2);

        let mut bounds = (
            (self.end - self.start).map(|c| c.abs() / self.length),
            Coords::ZERO,
            Coords::ZERO,
        );
        let [first, second, normal] = self.plane.axes();
        for (axis, along, across) in [(first, cos, sin), (second, sin, cos)] {
            // Derivatives by u, radial and tangential terms by magnitude; then the chain rule to s.
            let p1 = b * along + r * k * across;
            let p2 = r * k * k * along + 2.0 * b * k * across;
            let p3 = 3.0 * b * k * k * along + r * k * k * k * across;
            bounds.0.0[axis] = (p1 * w).min(1.0);
            bounds.1.0[axis] = p2 * w * w + p1 * w_d1;
            bounds.2.0[axis] = p3 * w * w * w + 3.0 * p2 * w * w_d1 + p1 * w_d2;
        }
        let lift = self.lift().abs();
        bounds.0.0[normal] = lift * w;
        bounds.1.0[normal] = lift * w_d1;
        bounds.2.0[normal] = lift * w_d2;
        bounds
    }

    /// Upper bounds of the magnitude of each axis' fourth and fifth derivative by s: exact for
    /// circles and helices at some place; on spirals each order gets as much more as the radius
    /// changes on a turn of one rad, several times.
    pub(crate) fn higher_derivatives(&self) -> (Coords, Coords) {
        if self.length <= 0.0 {
            return (Coords::ZERO, Coords::ZERO);
        }
        let spiral = self.spiral();
        let (ra, rb) = (spiral.radius(0.0), spiral.radius(1.0));
        // Angle per length where it is largest, rad/mm, and relative change of the radius per rad.
        let rate = spiral.k / spiral.speed(if ra < rb { 0.0 } else { 1.0 });
        let change = spiral.b.abs() / (spiral.k * ra.min(rb)).max(f64::MIN_POSITIVE);
        let grown = rate * (1.0 + 6.0 * change);
        let mut bounds = (Coords::ZERO, Coords::ZERO);
        let [first, second, normal] = self.plane.axes();
        for axis in [first, second, normal] {
            // The normal is linear in angle, which is linear in s unless the radius changes.
            let size = if axis == normal {
                change.min(1.0) * self.lift().abs() / spiral.k
            } else {
                ra.max(rb)
            };
            // The n-th derivative on a circle is r rate^n.
            let square = grown * grown;
            bounds.0.0[axis] = size * square * square;
            bounds.1.0[axis] = size * square * square * grown;
        }
        bounds
    }

    /// The box around it, where it is a circle or helix: the ends and every quarter point passed.
    pub(crate) fn circle_bounds(&self) -> Bounds {
        let mut bounds = Bounds::of(self.start, self.end);
        let (low, high) = (
            self.start_angle.min(self.start_angle + self.sweep),
            self.start_angle.max(self.start_angle + self.sweep),
        );
        let [first, second, _] = self.plane.axes();
        let r = self.start_radius;
        // The first quarter point on the arc; a fifth would be the first one again.
        let quarter = (low / FRAC_PI_2).ceil();
        for n in 0..4 {
            let turn = quarter + f64::from(n);
            if turn * FRAC_PI_2 > high {
                break;
            }
            // Which quarter of the circle, 0 to 3, as a float.
            match within(turn - 4.0 * (turn / 4.0).floor(), 0.0, 3.0) {
                q if q < 0.5 => bounds.include_axis(first, self.center[0] + r),
                q if q < 1.5 => bounds.include_axis(second, self.center[1] + r),
                q if q < 2.5 => bounds.include_axis(first, self.center[0] - r),
                _ => bounds.include_axis(second, self.center[1] - r),
            }
        }
        bounds
    }
}
