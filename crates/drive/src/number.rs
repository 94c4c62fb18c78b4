//! The numbers that the laws of drive, plant and twin are written over: one axis at a time they
//! are `f64`, in a batch they are vectors with one axis in each lane ([`crate::batch`]).
//!
//! Products and sums are never contracted and keep the order in which a law is written, so a lane
//! of a vector has the bits of the single axis.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// A number of one axis, or one number each of several axes.
pub(crate) trait Number:
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

    /// `yes` where the mask holds, else `no`.
    fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// As `f64::clamp`, for bounds that are in order.
    #[inline(always)]
    fn clamp(self, least: Self, most: Self) -> Self {
        let low = Self::choose(self.less(least), least, self);
        Self::choose(most.less(low), most, low)
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
    fn choose(mask: bool, yes: f64, no: f64) -> f64 {
        if mask { yes } else { no }
    }
}

/// Declares a struct whose fields are numbers of the same kind, with the two conversions that
/// take it from axes to vectors.
macro_rules! numbers {
    ($(#[$meta:meta])* $name:ident { $($(#[$field_meta:meta])* $field:ident,)+ }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default)]
        pub(crate) struct $name<N> {
            $($(#[$field_meta])* pub(crate) $field: N,)+
        }

        impl<N> $name<N> {
            /// Every number through a function.
            #[inline(always)]
            pub(crate) fn map<M>(&self, function: impl Fn(&N) -> M) -> $name<M> {
                $name { $($field: function(&self.$field),)+ }
            }

            /// Puts every number into its place in another such struct.
            pub(crate) fn put<M>(&mut self, values: &$name<M>, place: impl Fn(&mut N, &M)) {
                $(place(&mut self.$field, &values.$field);)+
            }
        }
    };
}
pub(crate) use numbers;
