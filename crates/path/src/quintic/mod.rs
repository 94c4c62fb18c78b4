//! Polynomial piece of degree five in each axis.

mod bernstein;
mod eval;

use crate::PathError;
use crate::derivs::within;
use crate::error::finite;
use bernstein::{largest, row};
use lostmotion_base::{AXES, Coords};
use serde::{Deserialize, Serialize};

/// One end of a polynomial piece.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HermiteEnd {
    /// Position, mm and rad.
    pub p: Coords,
    /// First derivative by s.
    pub d1: Coords,
    /// Second derivative by s.
    pub d2: Coords,
}

/// A polynomial piece of degree five in each axis, for blends and smoothed runs.
///
/// Its parameter is nominal: s = u * length with the polynomial's own u in `[0, 1]`, and |d1| in X
/// Y Z need not be 1.
///
/// ```
/// use lostmotion_base::Coords;
/// use lostmotion_path::{Curve, HermiteEnd, Quintic};
///
/// // A blend from the direction of X into that of Y, without curvature at its ends.
/// let end = |p, d1| HermiteEnd { p, d1, d2: Coords::ZERO };
/// let blend = Curve::from(Quintic::hermite(
///     end(Coords::ZERO, Coords::xyz(1.0, 0.0, 0.0)),
///     end(Coords::xyz(5.0, 5.0, 0.0), Coords::xyz(0.0, 1.0, 0.0)),
///     8.0,
/// )?);
/// let [x, y, _] = blend.point(4.0).linear();
/// assert!((x + y - 5.0).abs() < 1e-12 && x > y);
/// assert!(blend.curvature(0.0) < 1e-12 && blend.curvature(4.0) > 0.1);
/// # Ok::<(), lostmotion_path::PathError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quintic {
    /// Where it begins; the control points are relative to it, so that derivatives lose nothing to
    /// large coordinates.
    origin: Coords,
    /// Bernstein control points 1 to 5 relative to the origin.
    control: [Coords; 5],
    length: f64,
}

impl Quintic {
    /// From position and two derivatives by s at both ends, and the nominal length in s.
    ///
    /// # Errors
    /// Numbers that are not finite, a length that is not positive.
    pub fn hermite(start: HermiteEnd, end: HermiteEnd, length: f64) -> Result<Quintic, PathError> {
        // Of degree five: the first difference of control points at an end is p' L/5, the second
        // p'' L^2/20.
        let (v0, a0) = (
            start.d1 * (length / 5.0),
            start.d2 * (length * length / 20.0),
        );
        let (v1, a1) = (end.d1 * (length / 5.0), end.d2 * (length * length / 20.0));
        let last = end.p - start.p;
        let control = [v0, v0 * 2.0 + a0, last - v1 * 2.0 + a1, last - v1, last];
        Quintic::checked(Quintic {
            origin: start.p,
            control,
            length,
        })
    }

    /// From its six Bernstein control points and the nominal length in s.
    ///
    /// # Errors
    /// Numbers that are not finite, a length that is not positive.
    pub fn from_control_points(points: [Coords; 6], length: f64) -> Result<Quintic, PathError> {
        let [origin, rest @ ..] = points;
        Quintic::checked(Quintic {
            origin,
            control: rest.map(|p| p - origin),
            length,
        })
    }

    fn checked(self) -> Result<Quintic, PathError> {
        if !(self.length.is_finite() && self.length > 0.0) {
            return Err(PathError::Length {
                value_mm: self.length,
            });
        }
        finite("the start of a polynomial piece", &self.origin.0)?;
        for point in &self.control {
            finite("a control point of a polynomial piece", &point.0)?;
        }
        Ok(self)
    }

    /// Where it begins.
    pub const fn start(&self) -> Coords {
        self.origin
    }

    pub(crate) fn moved(&self, by: Coords) -> Quintic {
        Quintic {
            origin: self.origin + by,
            ..*self
        }
    }

    /// Where it ends.
    pub fn end(&self) -> Coords {
        self.origin + self.control[4]
    }

    /// Its nominal length: the range of s.
    pub const fn length(&self) -> f64 {
        self.length
    }

    /// Its six Bernstein control points.
    pub fn control_points(&self) -> [Coords; 6] {
        self.relative().map(|p| self.origin + p)
    }

    /// Control points relative to the start.
    pub(crate) fn relative(&self) -> [Coords; 6] {
        let [a, b, c, d, e] = self.control;
        [Coords::ZERO, a, b, c, d, e]
    }

    /// Control points of an axis and their first three differences.
    fn axis(&self, axis: usize) -> [[f64; 6]; 4] {
        let [a, b, c, d, e] = self.control.map(|point| point.0[axis]);
        let mut rows = [[0.0, a, b, c, d, e], [0.0; 6], [0.0; 6], [0.0; 6]];
        // Differences of control points are those of the derivatives, but for the factors n/L.
        for order in 1..4 {
            for i in 0..6 - order {
                rows[order][i] = rows[order - 1][i + 1] - rows[order - 1][i];
            }
        }
        rows
    }

    fn parameter(&self, s: f64) -> f64 {
        within(s / self.length, 0.0, 1.0)
    }

    /// Factors from differences of control points to derivatives by s.
    fn factors(&self) -> (f64, f64, f64) {
        let k1 = 5.0 / self.length;
        let k2 = k1 * 4.0 / self.length;
        (k1, k2, k2 * 3.0 / self.length)
    }

    /// Upper bounds of the magnitude of each axis' first three derivatives by s, from `s0` to `s1`:
    /// the largest Bernstein coefficient of each derivative over the stretch.
    pub fn max_derivatives(&self, s0: f64, s1: f64) -> (Coords, Coords, Coords) {
        let mut bounds = (Coords::ZERO, Coords::ZERO, Coords::ZERO);
        for axis in 0..self.moving() {
            let (first, second, third) = self.derivative_points(axis, s0, s1);
            bounds.0.0[axis] = largest(&first);
            bounds.1.0[axis] = largest(&second);
            bounds.2.0[axis] = largest(&third);
        }
        bounds
    }

    /// How many of the axes, from the first on, hold all that move: mostly three.
    pub fn moving(&self) -> usize {
        // All coordinates beyond X Y Z at once, without a branch for each.
        let mut bits = 0_u64;
        for point in &self.control {
            for value in &point.0[3..] {
                bits |= value.to_bits();
            }
        }
        // Both zeros stand still.
        if bits << 1 == 0 { 3 } else { AXES }
    }

    /// Bernstein coefficients of an axis' first, second and third derivative by s over the stretch
    /// from `s0` to `s1`, 5, 4 and 3 of them: between the least and the largest of them lies the
    /// derivative.
    pub fn derivative_points(
        &self,
        axis: usize,
        s0: f64,
        s1: f64,
    ) -> ([f64; 5], [f64; 4], [f64; 3]) {
        let [_, first, second, third] = self.axis(axis);
        let (k1, k2, k3) = self.factors();
        let (u0, u1) = (self.parameter(s0), self.parameter(s1));
        (
            row(&first, u0, u1).map(|d| d * k1),
            row(&second, u0, u1).map(|d| d * k2),
            row(&third, u0, u1).map(|d| d * k3),
        )
    }

    /// The stretch from `s0` to `s1`.
    pub fn sub(&self, s0: f64, s1: f64) -> Quintic {
        let s0 = within(s0, 0.0, self.length);
        let s1 = within(s1, s0, self.length);
        let (u0, u1) = (self.parameter(s0), self.parameter(s1));
        let mut sub = Quintic {
            origin: self.origin,
            control: [Coords::ZERO; 5],
            length: s1 - s0,
        };
        for axis in 0..self.moving() {
            // The first control point of the stretch becomes the new origin.
            let [first, rest @ ..] = row::<6>(&self.axis(axis)[0], u0, u1);
            sub.origin.0[axis] = self.origin.0[axis] + first;
            for (control, point) in sub.control.iter_mut().zip(rest) {
                control.0[axis] = point - first;
            }
        }
        sub
    }
}
