//! Polynomial piece of degree five in each axis.
//!
//! Bounds come from Bernstein coefficients of one axis, kept in rows of six from the front. Evaluation
//! takes all axes that move at once, so that the compiler makes vectors of them.

use crate::derivs::within;
use crate::error::finite;
use crate::{CurveDerivs, PathError};
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

/// The coefficients over the stretch from `u0` to `u1` of the first N of a row.
fn row<const N: usize>(row: &[f64; 6], u0: f64, u1: f64) -> [f64; N] {
    let mut points = [0.0; N];
    points.copy_from_slice(&row[..N]);
    // The beginning up to u1 first; u0 is then at u0 / u1 of it.
    let head = if u1 < 1.0 {
        split(points, u1).0
    } else {
        points
    };
    if u0 > 0.0 && u1 > 0.0 {
        split(head, u0 / u1).1
    } else {
        head
    }
}

/// De Casteljau's subdivision: coefficients before and after u.
fn split<const N: usize>(points: [f64; N], u: f64) -> ([f64; N], [f64; N]) {
    let (mut work, mut head, mut tail) = (points, points, points);
    for level in 0..N {
        // The outermost points of each level are control points of the two parts.
        head[level] = work[0];
        tail[N - 1 - level] = work[N - 1 - level];
        for i in 0..N - 1 - level {
            work[i] += (work[i + 1] - work[i]) * u;
        }
    }
    (head, tail)
}

/// Bernstein polynomials of degree N - 1 at u.
fn bernstein<const N: usize>(u: f64) -> [f64; N] {
    let mut basis = [0.0; N];
    basis[0] = 1.0;
    for degree in 1..N {
        raise(&mut basis[..=degree], u);
    }
    basis
}

/// Those of the next degree from those of one: M is N + 1.
fn raised<const N: usize, const M: usize>(basis: &[f64; N], u: f64) -> [f64; M] {
    let mut next = [0.0; M];
    next[..N].copy_from_slice(basis);
    raise(&mut next, u);
    next
}

fn raise(basis: &mut [f64], u: f64) {
    // Downwards: each entry needs its lower neighbour of the degree before.
    for i in (1..basis.len()).rev() {
        basis[i] = basis[i] * (1.0 - u) + basis[i - 1] * u;
    }
    basis[0] *= 1.0 - u;
}

/// Sum of rows with their weights, axis by axis.
fn mixed<const N: usize, const M: usize>(rows: &[[f64; N]; M], weights: &[f64; M]) -> [f64; N] {
    let mut sum = [0.0; N];
    for (row, weight) in rows.iter().zip(weights) {
        for (sum, value) in sum.iter_mut().zip(row) {
            *sum += value * weight;
        }
    }
    sum
}

/// Differences of neighbouring rows: L is M - 1.
fn differences<const N: usize, const M: usize, const L: usize>(
    rows: &[[f64; N]; M],
) -> [[f64; N]; L] {
    std::array::from_fn(|i| std::array::from_fn(|axis| rows[i + 1][axis] - rows[i][axis]))
}

/// Largest magnitude.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}

/// Axes evaluated where only X, Y and Z move: four fill a vector register, a fourth costs nothing.
const LINEAR_LANES: usize = 4;

impl Quintic {
    /// The point at s; s is held within the piece.
    pub fn point(&self, s: f64) -> Coords {
        let u = self.parameter(s);
        if self.moving() == 3 {
            self.point_of::<LINEAR_LANES>(u)
        } else {
            self.point_of::<AXES>(u)
        }
    }

    fn point_of<const N: usize>(&self, u: f64) -> Coords {
        let mut point = self.origin;
        add(&mut point, &mixed(&self.columns::<N>(), &bernstein::<6>(u)));
        point
    }

    /// Point and derivatives by s.
    pub fn eval(&self, s: f64) -> CurveDerivs {
        let u = self.parameter(s);
        if self.moving() == 3 {
            self.eval_of::<LINEAR_LANES>(u)
        } else {
            self.eval_of::<AXES>(u)
        }
    }

    fn eval_of<const N: usize>(&self, u: f64) -> CurveDerivs {
        let (k1, k2, k3) = self.factors();
        // Bernstein bases of degree 2 to 5, each raised from the one before.
        let b3 = bernstein::<3>(u);
        let b2 = raised::<3, 4>(&b3, u);
        let b1 = raised::<4, 5>(&b2, u);
        let points = self.columns::<N>();
        // Control points of the derivatives, but for the factors n/L.
        let first: [_; 5] = differences(&points);
        let second: [_; 4] = differences(&first);
        let third: [_; 3] = differences(&second);
        let mut out = CurveDerivs {
            p: self.origin,
            ..CurveDerivs::default()
        };
        add(&mut out.p, &mixed(&points, &raised::<5, 6>(&b1, u)));
        out.d1.0[..N].copy_from_slice(&mixed(&first, &b1).map(|d| d * k1));
        out.d2.0[..N].copy_from_slice(&mixed(&second, &b2).map(|d| d * k2));
        out.d3.0[..N].copy_from_slice(&mixed(&third, &b3).map(|d| d * k3));
        out
    }

    /// Place, velocity and acceleration where s has the given speed and acceleration.
    pub(crate) fn travel(&self, s: f64, v: f64, a: f64) -> [Coords; 3] {
        let u = self.parameter(s);
        if self.moving() == 3 {
            self.travel_of::<LINEAR_LANES>(u, v, a)
        } else {
            self.travel_of::<AXES>(u, v, a)
        }
    }

    fn travel_of<const N: usize>(&self, u: f64, v: f64, a: f64) -> [Coords; 3] {
        let (k1, k2, _) = self.factors();
        // As in eval, without the third derivative.
        let b2 = bernstein::<4>(u);
        let b1 = raised::<4, 5>(&b2, u);
        let points = self.columns::<N>();
        let first: [_; 5] = differences(&points);
        let second: [_; 4] = differences(&first);
        let mut out = [self.origin, Coords::ZERO, Coords::ZERO];
        add(&mut out[0], &mixed(&points, &raised::<5, 6>(&b1, u)));
        let (d1, d2) = (mixed(&first, &b1), mixed(&second, &b2));
        for axis in 0..N {
            // By time: the chain rule with speed and acceleration of s.
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

    /// Magnitudes of each axis' fourth derivative, the larger one of both ends of the stretch from
    /// `s0` to `s1`, and of the constant fifth.
    pub(crate) fn higher_derivatives(&self, s0: f64, s1: f64) -> (Coords, Coords) {
        let ends = [self.parameter(s0), self.parameter(s1)];
        if self.moving() == 3 {
            self.higher_of::<LINEAR_LANES>(ends)
        } else {
            self.higher_of::<AXES>(ends)
        }
    }

    fn higher_of<const N: usize>(&self, [u0, u1]: [f64; 2]) -> (Coords, Coords) {
        let k4 = self.factors().2 * 2.0 / self.length;
        let first: [_; 5] = differences(&self.columns::<N>());
        let second: [_; 4] = differences(&first);
        let third: [_; 3] = differences(&second);
        let [left, right]: [_; 2] = differences(&third);
        let mut bounds = (Coords::ZERO, Coords::ZERO);
        for axis in 0..N {
            // The fourth derivative is linear in u: its largest magnitude is at an end.
            let slope = right[axis] - left[axis];
            bounds.0.0[axis] = (left[axis] + slope * u0)
                .abs()
                .max((left[axis] + slope * u1).abs())
                * k4;
            bounds.1.0[axis] = slope.abs() * (k4 / self.length);
        }
        bounds
    }
}

/// Adds to the first axes.
fn add<const N: usize>(point: &mut Coords, what: &[f64; N]) {
    for (point, what) in point.0.iter_mut().zip(what) {
        *point += what;
    }
}
