//! A polynomial piece at a place: all axes that move at once, so that the compiler makes vectors of
//! them.

use super::Quintic;
use super::bernstein::{bernstein, differences, mixed, raised};
use crate::CurveDerivs;
use lostmotion_base::{AXES, Coords};

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
