//! The numbers that laws are written over which are computed alone and side by side: alone they are
//! `f64`, side by side vectors with one number of each in a lane ([`crate::wide`]).
//!
//! Products and sums are never contracted and keep the order in which a law is written, so a lane
//! of a vector has the bits of the single number.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// A number, or one number each of several.
///
/// ```
/// use lostmotion_base::Number;
///
/// /// What friction leaves of a torque.
/// fn left<N: Number>(torque: N, friction: N) -> N {
///     torque - torque.clamp(-friction, friction)
/// }
/// assert_eq!([left(3.0, 1.0), left(-0.5, 1.0)], [2.0, 0.0]);
/// ```
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Answer of a comparison, lane by lane.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask>;

    /// A constant, in as many lanes as this number has.
    fn constant(self, value: f64) -> Self;

    /// As `f64::abs`.
    fn abs(self) -> Self;

    /// As `f64::round`: halves away from zero.
    fn round(self) -> Self;

    /// Whether this is below the other.
    fn less(self, other: Self) -> Self::Mask;

    /// Whether this is not above the other.
    fn at_most(self, other: Self) -> Self::Mask;

    /// Whether the two are equal.
    fn equals(self, other: Self) -> Self::Mask;

    /// As `f64::copysign`: this with the sign of the other, that of a zero, too.
    fn copysign(self, sign: Self) -> Self;

    /// Whether a mask holds nowhere.
    fn none(mask: Self::Mask) -> bool;

    /// `yes` where the mask holds, else `no`.
    fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// As `f64::clamp`, for bounds that are in order.
    #[inline(always)]
    fn clamp(self, least: Self, most: Self) -> Self {
        clamp(self, least, most)
    }

    /// The larger of both; `other` where this is no number.
    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self::choose(other.less(self), self, other)
    }

    /// The lesser of both; `other` where this is no number.
    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        Self::choose(self.less(other), self, other)
    }

    /// Zero.
    #[inline(always)]
    fn zero(self) -> Self {
        self.constant(0.0)
    }

    /// 1 where the mask holds, else 0.
    #[inline(always)]
    fn flag(self, mask: Self::Mask) -> Self {
        Self::choose(mask, self.constant(1.0), self.zero())
    }

    /// 0 where the mask holds, else 1.
    #[inline(always)]
    fn unless(self, mask: Self::Mask) -> Self {
        Self::choose(mask, self.zero(), self.constant(1.0))
    }
}

/// [`Number::clamp`] by comparisons.
#[inline(always)]
pub(crate) fn clamp<N: Number>(value: N, least: N, most: N) -> N {
    let low = N::choose(value.less(least), least, value);
    N::choose(most.less(low), most, low)
}

impl Number for f64 {
    type Mask = bool;

    #[inline(always)]
    fn constant(self, value: f64) -> f64 {
        value
    }

    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }

    #[inline(always)]
    fn round(self) -> f64 {
        f64::round(self)
    }

    #[inline(always)]
    fn less(self, other: f64) -> bool {
        self < other
    }

    #[inline(always)]
    fn at_most(self, other: f64) -> bool {
        self <= other
    }

    #[inline(always)]
    fn equals(self, other: f64) -> bool {
        self == other
    }

    #[inline(always)]
    fn copysign(self, sign: f64) -> f64 {
        f64::copysign(self, sign)
    }

    #[inline(always)]
    fn none(mask: bool) -> bool {
        !mask
    }

    #[inline(always)]
    fn choose(mask: bool, yes: f64, no: f64) -> f64 {
        if mask { yes } else { no }
    }
}
