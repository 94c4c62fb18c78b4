//! Numbers that are worked on side by side, in vectors as wide as the processor has them.
//!
//! Each lane is computed as a number by itself would be, in the same order, so that no bit depends on the
//! width.

use pulp::Simd;
use std::ops::{Add, Div, Mul, Sub};

/// Numbers side by side: as many as the widest vector has lanes.
pub(crate) const LANES: usize = 8;

/// A number in each lane.
pub(crate) type Lanes = [f64; LANES];

/// Which of the lanes a vector holds.
#[derive(Clone, Copy)]
pub(crate) struct Part<S: Simd> {
    simd: S,
    part: usize,
}

/// A vector: some of the lanes.
#[derive(Clone, Copy)]
pub(crate) struct Wide<S: Simd> {
    simd: S,
    lanes: S::f64s,
}

/// The vectors that hold all lanes.
#[inline(always)]
pub(crate) fn parts<S: Simd>(simd: S) -> impl Iterator<Item = Part<S>> {
    (0..LANES / S::F64_LANES).map(move |part| Part { simd, part })
}

// Nothing here takes a closure with vectors in it: one that is not inlined has not the code of vectors.
impl<S: Simd> Part<S> {
    #[inline(always)]
    pub(crate) fn get(self, lanes: &Lanes) -> Wide<S> {
        Wide {
            simd: self.simd,
            lanes: S::as_simd_f64s(lanes).0[self.part],
        }
    }

    #[inline(always)]
    pub(crate) fn get_three(self, [a, b, c]: &[Lanes; 3]) -> [Wide<S>; 3] {
        [self.get(a), self.get(b), self.get(c)]
    }

    /// The lanes' numbers of a row of numbers, each with the two that follow it.
    #[inline(always)]
    pub(crate) fn get_following(self, numbers: &[f64]) -> [Wide<S>; 3] {
        [
            self.get_at(numbers, 0),
            self.get_at(numbers, 1),
            self.get_at(numbers, 2),
        ]
    }

    #[inline(always)]
    fn get_at(self, numbers: &[f64], first: usize) -> Wide<S> {
        Wide {
            simd: self.simd,
            lanes: S::as_simd_f64s(&numbers[first..first + LANES]).0[self.part],
        }
    }

    #[inline(always)]
    pub(crate) fn put(self, value: Wide<S>, lanes: &mut Lanes) {
        S::as_mut_simd_f64s(lanes).0[self.part] = value.lanes;
    }

    #[inline(always)]
    pub(crate) fn put_three(self, values: [Wide<S>; 3], [a, b, c]: &mut [Lanes; 3]) {
        self.put(values[0], a);
        self.put(values[1], b);
        self.put(values[2], c);
    }

    /// The same number in all lanes.
    #[inline(always)]
    pub(crate) fn all(self, value: f64) -> Wide<S> {
        Wide::all(self.simd, value)
    }
}

/// The sum of three products.
#[inline(always)]
pub(crate) fn dot<S: Simd>(a: [Wide<S>; 3], b: [Wide<S>; 3]) -> Wide<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(crate) fn scaled<S: Simd>(a: [Wide<S>; 3], by: Wide<S>) -> [Wide<S>; 3] {
    [a[0] * by, a[1] * by, a[2] * by]
}

impl<S: Simd> Wide<S> {
    /// The same number in all lanes.
    #[inline(always)]
    pub(crate) fn all(simd: S, value: f64) -> Wide<S> {
        let lanes = simd.splat_f64s(value);
        Wide { simd, lanes }
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Wide<S> {
        let lanes = self.simd.sqrt_f64s(self.lanes);
        Wide { lanes, ..self }
    }

    /// The larger of both; `other` where this is no number.
    #[inline(always)]
    pub(crate) fn max(self, other: Wide<S>) -> Wide<S> {
        other.if_less(self, self, other)
    }

    /// The lesser of both; `other` where this is no number.
    #[inline(always)]
    pub(crate) fn min(self, other: Wide<S>) -> Wide<S> {
        self.if_less(other, self, other)
    }

    /// The one value where this is less than a bound, else the other.
    #[inline(always)]
    pub(crate) fn if_less(self, bound: Wide<S>, yes: Wide<S>, no: Wide<S>) -> Wide<S> {
        let mask = self.simd.less_than_f64s(self.lanes, bound.lanes);
        let lanes = self.simd.select_f64s(mask, yes.lanes, no.lanes);
        Wide { lanes, ..self }
    }

    /// Where this is at most a bound 1, else and where either is no number 0.
    #[inline(always)]
    pub(crate) fn at_most(self, bound: Wide<S>) -> Wide<S> {
        let mask = self.simd.less_than_or_equal_f64s(self.lanes, bound.lanes);
        let (one, zero) = (Wide::all(self.simd, 1.0), Wide::all(self.simd, 0.0));
        let lanes = self.simd.select_f64s(mask, one.lanes, zero.lanes);
        Wide { lanes, ..self }
    }

    /// The least of the lanes.
    #[inline(always)]
    pub(crate) fn least(self) -> f64 {
        self.simd.reduce_min_f64s(self.lanes)
    }
}

macro_rules! operator {
    ($trait:ident, $name:ident, $simd:ident) => {
        impl<S: Simd> $trait for Wide<S> {
            type Output = Wide<S>;

            #[inline(always)]
            fn $name(self, other: Wide<S>) -> Wide<S> {
                let lanes = self.simd.$simd(self.lanes, other.lanes);
                Wide { lanes, ..self }
            }
        }
    };
}
operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);
