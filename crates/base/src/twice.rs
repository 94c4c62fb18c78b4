//! Two numbers that are computed at once.
//!
//! A law is mostly a chain, in which each step waits for the one before; of two chains that are written one
//! after the other a processor sees too little at a time to compute both at once.

use crate::number::Number;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// Two numbers, step by step.
///
/// ```
/// use lostmotion_base::{Number, Twice};
///
/// let sum = Twice([1.0, 2.0]) + Twice([3.0, -7.0]);
/// assert_eq!(sum.abs().0, [4.0, 5.0]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twice<N>(pub [N; 2]);

macro_rules! operator {
    ($trait:ident, $name:ident) => {
        impl<N: Number> $trait for Twice<N> {
            type Output = Twice<N>;

            #[inline(always)]
            fn $name(self, other: Twice<N>) -> Twice<N> {
                let (Twice([a, b]), Twice([c, d])) = (self, other);
                Twice([a.$name(c), b.$name(d)])
            }
        }
    };
}
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl<N: Number> Neg for Twice<N> {
    type Output = Twice<N>;

    #[inline(always)]
    fn neg(self) -> Twice<N> {
        let Twice([a, b]) = self;
        Twice([-a, -b])
    }
}

/// Answers of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwiceMask<M>([M; 2]);

impl<M: BitAnd<Output = M>> BitAnd for TwiceMask<M> {
    type Output = TwiceMask<M>;

    #[inline(always)]
    fn bitand(self, other: TwiceMask<M>) -> TwiceMask<M> {
        let (TwiceMask([a, b]), TwiceMask([c, d])) = (self, other);
        TwiceMask([a & c, b & d])
    }
}

impl<M: BitOr<Output = M>> BitOr for TwiceMask<M> {
    type Output = TwiceMask<M>;

    #[inline(always)]
    fn bitor(self, other: TwiceMask<M>) -> TwiceMask<M> {
        let (TwiceMask([a, b]), TwiceMask([c, d])) = (self, other);
        TwiceMask([a | c, b | d])
    }
}

macro_rules! single {
    ($($name:ident)+) => {
        $(#[inline(always)]
        fn $name(self) -> Twice<N> {
            let Twice([a, b]) = self;
            Twice([a.$name(), b.$name()])
        })+
    };
}

macro_rules! comparison {
    ($($name:ident)+) => {
        $(#[inline(always)]
        fn $name(self, other: Twice<N>) -> TwiceMask<N::Mask> {
            let (Twice([a, b]), Twice([c, d])) = (self, other);
            TwiceMask([a.$name(c), b.$name(d)])
        })+
    };
}

impl<N: Number> Number for Twice<N> {
    type Mask = TwiceMask<N::Mask>;

    single!(abs round);

    comparison!(less at_most equals);

    #[inline(always)]
    fn constant(self, value: f64) -> Twice<N> {
        let value = self.0[0].constant(value);
        Twice([value, value])
    }

    #[inline(always)]
    fn copysign(self, sign: Twice<N>) -> Twice<N> {
        let (Twice([a, b]), Twice([c, d])) = (self, sign);
        Twice([a.copysign(c), b.copysign(d)])
    }

    #[inline(always)]
    fn none(mask: TwiceMask<N::Mask>) -> bool {
        let TwiceMask([a, b]) = mask;
        N::none(a) && N::none(b)
    }

    #[inline(always)]
    fn choose(mask: TwiceMask<N::Mask>, yes: Twice<N>, no: Twice<N>) -> Twice<N> {
        let (TwiceMask([m, n]), Twice([a, b]), Twice([c, d])) = (mask, yes, no);
        Twice([N::choose(m, a, c), N::choose(n, b, d)])
    }

    #[inline(always)]
    fn clamp(self, least: Twice<N>, most: Twice<N>) -> Twice<N> {
        let (Twice([a, b]), Twice([c, d]), Twice([e, f])) = (self, least, most);
        Twice([a.clamp(c, e), b.clamp(d, f)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_are_computed_as_single_ones_are() {
        let values = [-2.5, -0.0, 0.3, 7.0, f64::NAN];
        let law = |x: f64, y: f64| (x - y).clamp(-1.0, 1.0) * y.abs() / (x.round() + 0.5) + -y;
        for a in values {
            for b in values {
                let (x, y) = (Twice([a, b]), Twice([b, 0.7]));
                let one = x.constant(1.0);
                let both = (x - y).clamp(-one, one) * y.abs() / (x.round() + x.constant(0.5)) + -y;
                let single = [law(a, b), law(b, 0.7)];
                assert_eq!(
                    both.0.map(f64::to_bits),
                    single.map(f64::to_bits),
                    "{a} {b}"
                );
                let chosen = Twice::choose(x.less(y) | x.equals(y), x, y).0;
                assert_eq!(
                    chosen.map(f64::to_bits),
                    [(a, b), (b, 0.7)].map(|(x, y)| if x <= y { x } else { y }.to_bits())
                );
                assert_eq!(
                    Twice::<f64>::none(x.less(y) & x.at_most(y)),
                    !(a < b || b < 0.7)
                );
            }
        }
    }
}
