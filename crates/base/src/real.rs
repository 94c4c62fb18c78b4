//! Numbers that kinematics are written in: plain `f64`, or a [`Jet`] that carries derivatives
//! along.
//!
//! Planning in joint space needs the joints' derivatives by path length up to the third. Writing a
//! kinematics once over [`Real`] and evaluating it on jets gives them exactly, without differences.

use crate::math;
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number or something that behaves like one.
pub trait Real:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Send
    + Sync
    + 'static
{
    /// A constant.
    fn constant(value: f64) -> Self;
    /// The value without derivatives.
    fn value(self) -> f64;
    /// Sine; the argument in rad.
    fn sin(self) -> Self;
    /// Cosine; the argument in rad.
    fn cos(self) -> Self;
    /// Square root. At zero the derivatives of a jet are not finite.
    fn sqrt(self) -> Self;
    /// Angle in rad of the vector (x, self), in (-pi, pi].
    fn atan2(self, x: Self) -> Self;
}

impl Real for f64 {
    #[inline]
    fn constant(value: f64) -> f64 {
        value
    }
    #[inline]
    fn value(self) -> f64 {
        self
    }
    #[inline]
    fn sin(self) -> f64 {
        math::sin(self)
    }
    #[inline]
    fn cos(self) -> f64 {
        math::cos(self)
    }
    #[inline]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    #[inline]
    fn atan2(self, x: f64) -> f64 {
        math::atan2(self, x)
    }
}

/// Value and derivatives d/ds, d2/ds2, d3/ds3.
///
/// ```
/// use lostmotion_base::Jet;
///
/// // s^2 at s = 3: value 9, slope 6, curvature 2
/// let s = Jet::new(3.0, 1.0, 0.0, 0.0);
/// assert_eq!((s * s).0, [9.0, 6.0, 2.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jet(pub [f64; 4]);

impl Jet {
    /// A value and its three derivatives.
    pub const fn new(value: f64, d1: f64, d2: f64, d3: f64) -> Jet {
        Jet([value, d1, d2, d3])
    }

    /// The value of a smooth function of this jet, from the function's value and first three
    /// derivatives at it (Faà di Bruno's formula to third order).
    fn compose(self, f0: f64, f1: f64, f2: f64, f3: f64) -> Jet {
        let [_, x1, x2, x3] = self.0;
        Jet([
            f0,
            f1 * x1,
            f2 * x1 * x1 + f1 * x2,
            f3 * x1 * x1 * x1 + 3.0 * f2 * x1 * x2 + f1 * x3,
        ])
    }

    /// The derivatives after a change of parameter s -> t with the given ds/dt, d2s/dt2, d3s/dt3.
    #[must_use]
    pub fn reparametrize(self, v: f64, a: f64, j: f64) -> Jet {
        // The chain rule to third order.
        let [q, q1, q2, q3] = self.0;
        Jet([
            q,
            q1 * v,
            q2 * v * v + q1 * a,
            q3 * v * v * v + 3.0 * q2 * v * a + q1 * j,
        ])
    }
}

impl Add for Jet {
    type Output = Jet;
    fn add(self, o: Jet) -> Jet {
        Jet([
            self.0[0] + o.0[0],
            self.0[1] + o.0[1],
            self.0[2] + o.0[2],
            self.0[3] + o.0[3],
        ])
    }
}

impl Sub for Jet {
    type Output = Jet;
    fn sub(self, o: Jet) -> Jet {
        Jet([
            self.0[0] - o.0[0],
            self.0[1] - o.0[1],
            self.0[2] - o.0[2],
            self.0[3] - o.0[3],
        ])
    }
}

impl Neg for Jet {
    type Output = Jet;
    fn neg(self) -> Jet {
        Jet(self.0.map(|c| -c))
    }
}

impl Mul for Jet {
    type Output = Jet;
    fn mul(self, o: Jet) -> Jet {
        // Leibniz' rule to third order.
        let ([a, a1, a2, a3], [b, b1, b2, b3]) = (self.0, o.0);
        Jet([
            a * b,
            a1 * b + a * b1,
            a2 * b + 2.0 * a1 * b1 + a * b2,
            a3 * b + 3.0 * (a2 * b1 + a1 * b2) + a * b3,
        ])
    }
}

impl Div for Jet {
    type Output = Jet;
    fn div(self, o: Jet) -> Jet {
        let r = 1.0 / o.0[0];
        // The product with 1/o, whose derivatives by o are -r^2, 2 r^3 and -6 r^4.
        self * o.compose(r, -r * r, 2.0 * r * r * r, -6.0 * r * r * r * r)
    }
}

impl Real for Jet {
    fn constant(value: f64) -> Jet {
        Jet([value, 0.0, 0.0, 0.0])
    }
    fn value(self) -> f64 {
        self.0[0]
    }
    fn sin(self) -> Jet {
        let (s, c) = crate::math::sin_cos(self.0[0]);
        // Value and derivatives by the angle: sin, cos, -sin, -cos.
        self.compose(s, c, -s, -c)
    }
    fn cos(self) -> Jet {
        let (s, c) = crate::math::sin_cos(self.0[0]);
        self.compose(c, -s, -c, s)
    }
    fn sqrt(self) -> Jet {
        let r = self.0[0].sqrt();
        let x = self.0[0];
        // By x: 1/(2 r), -1/(4 r x), 3/(8 r x^2).
        self.compose(r, 0.5 / r, -0.25 / (r * x), 0.375 / (r * x * x))
    }
    fn atan2(self, x: Jet) -> Jet {
        // d(atan2(y, x)) = (x y' - y x') / (x^2 + y^2); the jet of that quotient, shifted by one
        // order.
        let angle = crate::math::atan2(self.0[0], x.0[0]);
        let shift = |j: Jet| Jet([j.0[1], j.0[2], j.0[3], 0.0]);
        let rate = (x * shift(self) - self * shift(x)) / (x * x + self * self);
        Jet([angle, rate.0[0], rate.0[1], rate.0[2]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A smooth function that uses every operation, at s.
    fn sample<R: Real>(s: R) -> R {
        let two = R::constant(2.0);
        let a = (s * s + two).sqrt() / (s.cos() + two);
        (a * s.sin()).atan2(s + two) - (-s) * a
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let (s, h) = (0.7, 1e-3);
        let f = |k: f64| sample(s + k * h);
        let jet = sample(Jet::new(s, 1.0, 0.0, 0.0));
        let d1 = (f(-2.0) - 8.0 * f(-1.0) + 8.0 * f(1.0) - f(2.0)) / (12.0 * h);
        let d2 =
            (-f(-2.0) + 16.0 * f(-1.0) - 30.0 * f(0.0) + 16.0 * f(1.0) - f(2.0)) / (12.0 * h * h);
        let d3 = (f(-3.0) - 8.0 * f(-2.0) + 13.0 * f(-1.0) - 13.0 * f(1.0) + 8.0 * f(2.0) - f(3.0))
            / (8.0 * h * h * h);
        assert!((jet.0[0] - f(0.0)).abs() < 1e-15);
        assert!((jet.0[1] - d1).abs() < 1e-10, "{} {d1}", jet.0[1]);
        assert!((jet.0[2] - d2).abs() < 1e-8, "{} {d2}", jet.0[2]);
        assert!((jet.0[3] - d3).abs() < 1e-5, "{} {d3}", jet.0[3]);
    }
}
