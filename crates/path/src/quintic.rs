//! Polynomial piece of degree five in each axis.

use crate::bernstein::{bernstein, differences, largest, mixed, raised, row};
use crate::derivs::within;
use crate::error::finite;
use crate::{CurveDerivs, PathError};
use lostmotion_base::{AXES, Coords};
use serde::{Deserialize, Serialize};

/// Axes looked at where only X, Y and Z move: a fourth one costs nothing.
const LINEAR: usize = 4;

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
/// Its parameter is nominal: s = u * length with the polynomial's own u in `[0, 1]`, and |d1| in X Y Z need not be 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quintic {
    /// Where it begins; the control points are relative to it, so that derivatives lose nothing to large coordinates.
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
        let (v0, a0) = (start.d1 * (length / 5.0), start.d2 * (length * length / 20.0));
        let (v1, a1) = (end.d1 * (length / 5.0), end.d2 * (length * length / 20.0));
        let last = end.p - start.p;
        let control = [v0, v0 * 2.0 + a0, last - v1 * 2.0 + a1, last - v1, last];
        Quintic::checked(Quintic { origin: start.p, control, length })
    }

    /// From its six Bernstein control points and the nominal length in s.
    ///
    /// # Errors
    /// Numbers that are not finite, a length that is not positive.
    pub fn from_control_points(points: [Coords; 6], length: f64) -> Result<Quintic, PathError> {
        let [origin, rest @ ..] = points;
        Quintic::checked(Quintic { origin, control: rest.map(|p| p - origin), length })
    }

    fn checked(self) -> Result<Quintic, PathError> {
        if !(self.length.is_finite() && self.length > 0.0) {
            return Err(PathError::Length { value_mm: self.length });
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
        Quintic { origin: self.origin + by, ..*self }
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

    /// The point at s; s is held within the piece.
    pub fn point(&self, s: f64) -> Coords {
        let u = self.parameter(s);
        if self.moving() == 3 { self.point_of::<LINEAR>(u) } else { self.point_of::<AXES>(u) }
    }

    fn point_of<const N: usize>(&self, u: f64) -> Coords {
        let mut point = self.origin;
        add(&mut point, &mixed(&self.columns::<N>(), &bernstein::<6>(u)));
        point
    }

    /// Point and derivatives by s.
    pub fn eval(&self, s: f64) -> CurveDerivs {
        let u = self.parameter(s);
        if self.moving() == 3 { self.eval_of::<LINEAR>(u) } else { self.eval_of::<AXES>(u) }
    }

    fn eval_of<const N: usize>(&self, u: f64) -> CurveDerivs {
        let (k1, k2, k3) = self.factors();
        let b3 = bernstein::<3>(u);
        let b2 = raised::<3, 4>(&b3, u);
        let b1 = raised::<4, 5>(&b2, u);
        let points = self.columns::<N>();
        let first: [_; 5] = differences(&points);
        let second: [_; 4] = differences(&first);
        let third: [_; 3] = differences(&second);
        let mut out = CurveDerivs { p: self.origin, ..CurveDerivs::default() };
        add(&mut out.p, &mixed(&points, &raised::<5, 6>(&b1, u)));
        out.d1.0[..N].copy_from_slice(&mixed(&first, &b1).map(|d| d * k1));
        out.d2.0[..N].copy_from_slice(&mixed(&second, &b2).map(|d| d * k2));
        out.d3.0[..N].copy_from_slice(&mixed(&third, &b3).map(|d| d * k3));
        out
    }

    /// Place, velocity and acceleration where s has the given speed and acceleration.
    pub(crate) fn travel(&self, s: f64, v: f64, a: f64) -> [Coords; 3] {
        let u = self.parameter(s);
        if self.moving() == 3 { self.travel_of::<LINEAR>(u, v, a) } else { self.travel_of::<AXES>(u, v, a) }
    }

    fn travel_of<const N: usize>(&self, u: f64, v: f64, a: f64) -> [Coords; 3] {
        let (k1, k2, _) = self.factors();
        let b2 = bernstein::<4>(u);
        let b1 = raised::<4, 5>(&b2, u);
        let points = self.columns::<N>();
        let first: [_; 5] = differences(&points);
        let second: [_; 4] = differences(&first);
        let mut out = [self.origin, Coords::ZERO, Coords::ZERO];
        add(&mut out[0], &mixed(&points, &raised::<5, 6>(&b1, u)));
        let (d1, d2) = (mixed(&first, &b1), mixed(&second, &b2));
        for axis in 0..N {
            let (d1, d2) = (d1[axis] * k1, d2[axis] * k2);
            out[1].0[axis] = d1 * v;
            out[2].0[axis] = d2 * v * v + d1 * a;
        }
        out
    }

    /// The first axes of the control points.
    fn columns<const N: usize>(&self) -> [[f64; N]; 6] {
        let mut columns = [[0.0; N]; 6];
        for (column, point) in columns[1..].iter_mut().zip(&self.control) {
            column.copy_from_slice(&point.0[..N]);
        }
        columns
    }

    /// Control points of an axis and their first three differences.
    fn axis(&self, axis: usize) -> [[f64; 6]; 4] {
        let [a, b, c, d, e] = self.control.map(|point| point.0[axis]);
        let mut rows = [[0.0, a, b, c, d, e], [0.0; 6], [0.0; 6], [0.0; 6]];
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

    /// Upper bounds of the magnitude of each axis' first three derivatives by s, from `s0` to `s1`: the largest Bernstein
    /// coefficient of each derivative over the stretch.
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

    /// Magnitudes of each axis' fourth derivative, the larger one of both ends of the stretch from `s0` to `s1`, and of the
    /// constant fifth.
    pub(crate) fn higher_derivatives(&self, s0: f64, s1: f64) -> (Coords, Coords) {
        let ends = [self.parameter(s0), self.parameter(s1)];
        if self.moving() == 3 { self.higher_of::<LINEAR>(ends) } else { self.higher_of::<AXES>(ends) }
    }

    fn higher_of<const N: usize>(&self, [u0, u1]: [f64; 2]) -> (Coords, Coords) {
        let k4 = self.factors().2 * 2.0 / self.length;
        let first: [_; 5] = differences(&self.columns::<N>());
        let second: [_; 4] = differences(&first);
        let third: [_; 3] = differences(&second);
        let [left, right]: [_; 2] = differences(&third);
        let mut bounds = (Coords::ZERO, Coords::ZERO);
        for axis in 0..N {
            let slope = right[axis] - left[axis];
            bounds.0.0[axis] = (left[axis] + slope * u0).abs().max((left[axis] + slope * u1).abs()) * k4;
            bounds.1.0[axis] = slope.abs() * (k4 / self.length);
        }
        bounds
    }

    /// How many of the axes, from the first on, hold all that move: mostly three.
    pub fn moving(&self) -> usize {
        let mut bits = 0_u64;
        for point in &self.control {
            for value in &point.0[3..] {
                bits |= value.to_bits();
            }
        }
        // Both zeros stand still.
        if bits << 1 == 0 { 3 } else { AXES }
    }

    /// Bernstein coefficients of an axis' first, second and third derivative by s over the stretch from `s0` to `s1`, 5, 4 and 3
    /// of them: between the least and the largest of them lies the derivative.
    pub fn derivative_points(&self, axis: usize, s0: f64, s1: f64) -> ([f64; 5], [f64; 4], [f64; 3]) {
        let [_, first, second, third] = self.axis(axis);
        let (k1, k2, k3) = self.factors();
        let (u0, u1) = (self.parameter(s0), self.parameter(s1));
        (row(&first, u0, u1).map(|d| d * k1), row(&second, u0, u1).map(|d| d * k2), row(&third, u0, u1).map(|d| d * k3))
    }

    /// The stretch from `s0` to `s1`.
    pub fn sub(&self, s0: f64, s1: f64) -> Quintic {
        let s0 = within(s0, 0.0, self.length);
        let s1 = within(s1, s0, self.length);
        let (u0, u1) = (self.parameter(s0), self.parameter(s1));
        let mut sub = Quintic { origin: self.origin, control: [Coords::ZERO; 5], length: s1 - s0 };
        for axis in 0..self.moving() {
            let [first, rest @ ..] = row::<6>(&self.axis(axis)[0], u0, u1);
            sub.origin.0[axis] = self.origin.0[axis] + first;
            for (control, point) in sub.control.iter_mut().zip(rest) {
                control.0[axis] = point - first;
            }
        }
        sub
    }
}

/// Adds to the first axes.
fn add<const N: usize>(point: &mut Coords, what: &[f64; N]) {
    for (point, what) in point.0.iter_mut().zip(what) {
        *point += what;
    }
}
