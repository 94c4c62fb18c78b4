//! Vectors of a group's rows: a [`Number`] with one axis in each lane.

use super::lanes::Row;
use crate::number::Number;
use pulp::Simd;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// From here on every number is whole: 2^52, the spacing of doubles is 1 there.
const ALL_WHOLE: f64 = (1_u64 << 52) as f64;

/// Part of a row's lanes: those that one vector holds.
#[derive(Clone, Copy)]
pub(super) struct Part<S: Simd> {
    pub(super) simd: S,
    pub(super) part: usize,
}

impl<S: Simd> Part<S> {
    #[inline(always)]
    pub(super) fn get(self, row: &Row) -> Wide<S> {
        Wide {
            simd: self.simd,
            lanes: S::as_simd_f64s(&row.0).0[self.part],
        }
    }

    #[inline(always)]
    pub(super) fn put(self, row: &mut Row, value: Wide<S>) {
        S::as_mut_simd_f64s(&mut row.0).0[self.part] = value.lanes;
    }

    /// A constant in all lanes.
    #[inline(always)]
    pub(super) fn all(self, value: f64) -> Wide<S> {
        Wide {
            simd: self.simd,
            lanes: self.simd.splat_f64s(value),
        }
    }
}

/// A vector.
#[derive(Clone, Copy)]
pub(super) struct Wide<S: Simd> {
    simd: S,
    lanes: S::f64s,
}

/// Answers of a comparison.
#[derive(Clone, Copy)]
pub(super) struct WideMask<S: Simd> {
    simd: S,
    lanes: S::m64s,
}

impl<S: Simd> WideMask<S> {
    /// Whether it is true in no lane.
    #[inline(always)]
    pub(super) fn none(self) -> bool {
        self.simd.first_true_m64s(self.lanes) == S::F64_LANES
    }
}

macro_rules! operator {
    ($trait:ident, $name:ident, $simd:ident) => {
        impl<S: Simd> $trait for Wide<S> {
            type Output = Wide<S>;

            #[inline(always)]
            fn $name(self, other: Wide<S>) -> Wide<S> {
                Wide {
                    simd: self.simd,
                    lanes: self.simd.$simd(self.lanes, other.lanes),
                }
            }
        }
    };
}
operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

macro_rules! mask_operator {
    ($trait:ident, $name:ident, $simd:ident) => {
        impl<S: Simd> $trait for WideMask<S> {
            type Output = WideMask<S>;

            #[inline(always)]
            fn $name(self, other: WideMask<S>) -> WideMask<S> {
                WideMask {
                    simd: self.simd,
                    lanes: self.simd.$simd(self.lanes, other.lanes),
                }
            }
        }
    };
}
mask_operator!(BitAnd, bitand, and_m64s);
mask_operator!(BitOr, bitor, or_m64s);

impl<S: Simd> Neg for Wide<S> {
    type Output = Wide<S>;

    #[inline(always)]
    fn neg(self) -> Wide<S> {
        Wide {
            simd: self.simd,
            lanes: self.simd.neg_f64s(self.lanes),
        }
    }
}

impl<S: Simd> Number for Wide<S> {
    type Mask = WideMask<S>;

    #[inline(always)]
    fn constant(self, value: f64) -> Wide<S> {
        Wide {
            simd: self.simd,
            lanes: self.simd.splat_f64s(value),
        }
    }

    #[inline(always)]
    fn abs(self) -> Wide<S> {
        Wide {
            simd: self.simd,
            lanes: self.simd.abs_f64s(self.lanes),
        }
    }

    /// No processor's vectors round halves away from zero: adding 2^52 rounds them to even, and
    /// those that went down by a half are raised by one.
    #[inline(always)]
    fn round(self) -> Wide<S> {
        let (size, whole) = (self.abs(), self.constant(ALL_WHOLE));
        let even = (size + whole) - whole;
        let short = (size - even).equals(self.constant(0.5));
        let rounded = Wide::choose(short, even + self.constant(1.0), even);
        let signed = Wide::choose(self.less(self.zero()), -rounded, rounded);
        // zeros keep their sign, and what is whole already stays
        let fractional = size.less(whole) & self.zero().less(size);
        Wide::choose(fractional, signed, self)
    }

    #[inline(always)]
    fn less(self, other: Wide<S>) -> WideMask<S> {
        WideMask {
            simd: self.simd,
            lanes: self.simd.less_than_f64s(self.lanes, other.lanes),
        }
    }

    #[inline(always)]
    fn at_most(self, other: Wide<S>) -> WideMask<S> {
        WideMask {
            simd: self.simd,
            lanes: self.simd.less_than_or_equal_f64s(self.lanes, other.lanes),
        }
    }

    #[inline(always)]
    fn equals(self, other: Wide<S>) -> WideMask<S> {
        WideMask {
            simd: self.simd,
            lanes: self.simd.equal_f64s(self.lanes, other.lanes),
        }
    }

    #[inline(always)]
    fn choose(mask: WideMask<S>, yes: Wide<S>, no: Wide<S>) -> Wide<S> {
        Wide {
            simd: yes.simd,
            lanes: yes.simd.select_f64s(mask.lanes, yes.lanes, no.lanes),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::lanes::WIDTH;
    use super::*;
    use pulp::{Arch, WithSimd};

    struct Rounds<'a>(&'a mut Row);

    impl WithSimd for Rounds<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            for part in 0..WIDTH / S::F64_LANES {
                let part = Part { simd, part };
                part.put(self.0, part.get(self.0).round());
            }
        }
    }

    #[test]
    fn it_rounds_as_the_standard_library_does() {
        let below_half = f64::from_bits(0.5_f64.to_bits() - 1);
        let edge = ALL_WHOLE - 0.5;
        let mut values = vec![
            0.0,
            -0.0,
            0.5,
            -0.5,
            1.5,
            2.5,
            -2.5,
            below_half,
            -below_half,
            0.2,
            -0.2,
            edge,
            -edge,
            ALL_WHOLE,
            ALL_WHOLE + 1.0,
            1e300,
        ];
        values.extend([
            f64::INFINITY,
            f64::NEG_INFINITY,
            5e-324,
            -5e-324,
            4_503_599_627_370_495.5,
            123_456.5,
            123_457.5,
            -123_456.499,
        ]);
        values.extend((0..200).map(|n| (f64::from(n) - 100.0) * 0.25 * 1.000_000_1));
        for chunk in values.chunks(WIDTH) {
            let mut row = Row([0.0; WIDTH]);
            row.0[..chunk.len()].copy_from_slice(chunk);
            Arch::new().dispatch(Rounds(&mut row));
            for (x, rounded) in chunk.iter().zip(row.0) {
                assert_eq!(rounded.to_bits(), x.round().to_bits(), "{x}");
            }
        }
    }
}
