//! Numbers that kinematics are written in: plain `f64`, or a [`Jet`](crate::Jet) that carries
//! derivatives along.

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
    fn constant(value: f64) -> f64 {
        value
    }
    fn value(self) -> f64 {
        self
    }
    fn sin(self) -> f64 {
        math::sin(self)
    }
    fn cos(self) -> f64 {
        math::cos(self)
    }
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    fn atan2(self, x: f64) -> f64 {
        math::atan2(self, x)
    }
}
