//! Numbers side by side: a [`Number`] with as many lanes as the processor's vectors have.

use crate::number::{Number, clamp};
use pulp::Simd;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// From here on every number is whole: 2^52, the spacing of doubles is 1 there.
const ALL_WHOLE: f64 = (1_u64 << 52) as f64;

/// A vector.
///
/// ```
/// use lostmotion_base::{Number, Wide};
/// use pulp::{Arch, Simd, WithSimd};
///
/// /// Halves all that whole vectors hold.
/// struct Halve<'a>(&'a mut [f64]);
///
/// impl WithSimd for Halve<'_> {
///     type Output = ();
///
///     fn with_simd<S: Simd>(self, simd: S) {
///         for part in 0..self.0.len() / S::F64_LANES {
///             let value = Wide::get(simd, self.0, part);
///             (value * value.constant(0.5)).put(self.0, part);
///         }
///     }
/// }
///
/// let mut values = [3.0; 8];
/// Arch::new().dispatch(Halve(&mut values));
/// assert_eq!(values, [1.5; 8]);
/// ```
#[derive(Clone, Copy)]
pub struct Wide<S: Simd> {
    simd: S,
    lanes: S::f64s,
}

/// Answers of a comparison.
#[derive(Clone, Copy)]
pub struct WideMask<S: Simd> {
    simd: S,
    lanes: S::m64s,
}

impl<S: Simd> Wide<S> {
    /// A vector's part of these numbers: those from `part` times its lanes on.
    ///
    /// # Panics
    /// Where there are fewer.
    #[inline(always)]
    pub fn get(simd: S, values: &[f64], part: usize) -> Wide<S> {
        Wide {
            simd,
            lanes: S::as_simd_f64s(values).0[part],
        }
    }

    /// Puts it there.
    ///
    /// # Panics
    /// As [`Wide::get`].
    #[inline(always)]
    pub fn put(self, values: &mut [f64], part: usize) {
        S::as_mut_simd_f64s(values).0[part] = self.lanes;
    }

    /// As `f64::sqrt`.
    #[must_use]
    #[inline(always)]
    pub fn sqrt(self) -> Wide<S> {
        Wide {
            lanes: self.simd.sqrt_f64s(self.lanes),
            ..self
        }
    }

    /// The least of the lanes.
    #[inline(always)]
    pub fn least(self) -> f64 {
        self.simd.reduce_min_f64s(self.lanes)
    }

    /// The same number in all lanes.
    #[inline(always)]
    pub fn all(simd: S, value: f64) -> Wide<S> {
        Wide {
            simd,
            lanes: simd.splat_f64s(value),
        }
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
    fn copysign(self, sign: Wide<S>) -> Wide<S> {
        let simd = self.simd;
        let only = simd.transmute_u64s_f64s(simd.splat_f64s(-0.0));
        let sign = simd.and_u64s(only, simd.transmute_u64s_f64s(sign.lanes));
        let size = simd.transmute_u64s_f64s(simd.abs_f64s(self.lanes));
        Wide {
            simd,
            lanes: simd.transmute_f64s_u64s(simd.or_u64s(size, sign)),
        }
    }

    /// On x86 the larger and the lesser of two that are equal or not ordered is the second, as the comparisons have it,
    /// in an instruction each; a single lane is no vector.
    #[inline(always)]
    fn clamp(self, least: Wide<S>, most: Wide<S>) -> Wide<S> {
        if S::F64_LANES == 1 || !cfg!(target_arch = "x86_64") {
            return clamp(self, least, most);
        }
        let simd = self.simd;
        Wide {
            simd,
            lanes: simd.min_f64s(most.lanes, simd.max_f64s(least.lanes, self.lanes)),
        }
    }

    #[inline(always)]
    fn none(mask: WideMask<S>) -> bool {
        mask.simd.first_true_m64s(mask.lanes) == S::F64_LANES
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
    use super::*;
    use pulp::{Arch, WithSimd};

    /// Whole vectors of every width.
    const WIDTH: usize = 16;

    struct Rounds<'a>(&'a mut [f64]);

    impl WithSimd for Rounds<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            for part in 0..self.0.len() / S::F64_LANES {
                Wide::get(simd, self.0, part).round().put(self.0, part);
            }
        }
    }

    struct Clamps<'a>(&'a mut [f64], [f64; 2]);

    impl WithSimd for Clamps<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let [least, most] = self.1.map(|bound| Wide::all(simd, bound));
            for part in 0..self.0.len() / S::F64_LANES {
                let clamped = Wide::get(simd, self.0, part).clamp(least, most);
                clamped.put(self.0, part);
            }
        }
    }

    #[test]
    fn it_clamps_as_comparisons_do() {
        let values: [f64; 8] = [
            0.0,
            -0.0,
            f64::NAN,
            -f64::NAN,
            0.5,
            -3.0,
            f64::INFINITY,
            f64::NEG_INFINITY,
        ];
        for bounds in [[-1.0, 1.0], [0.0, 0.0], [-0.0, 0.0], [0.0, -0.0]] {
            let expected = values.map(|value| clamp(value, bounds[0], bounds[1]).to_bits());
            let (mut wide, mut single) = (values, values);
            Arch::new().dispatch(Clamps(&mut wide, bounds));
            Clamps(&mut single, bounds).with_simd(pulp::Scalar::new());
            assert_eq!(wide.map(f64::to_bits), expected, "{bounds:?}");
            assert_eq!(single.map(f64::to_bits), expected, "{bounds:?}");
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
            let mut row = [0.0; WIDTH];
            row[..chunk.len()].copy_from_slice(chunk);
            Arch::new().dispatch(Rounds(&mut row));
            for (x, rounded) in chunk.iter().zip(row) {
                assert_eq!(rounded.to_bits(), x.round().to_bits(), "{x}");
            }
        }
    }
}
