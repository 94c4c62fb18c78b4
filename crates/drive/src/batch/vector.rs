//! Arithmetic on one vector of the rows.

use super::lanes::Row;
use pulp::Simd;

/// From here on every number is whole.
const ALL_WHOLE: f64 = (1_u64 << 52) as f64;

/// Part of the lanes, as many as a vector holds.
#[derive(Clone, Copy)]
pub(super) struct Wide<S: Simd> {
    pub(super) simd: S,
    pub(super) part: usize,
}

impl<S: Simd> Wide<S> {
    #[inline(always)]
    pub(super) fn get(self, row: &Row) -> S::f64s {
        S::as_simd_f64s(&row.0).0[self.part]
    }

    #[inline(always)]
    pub(super) fn put(self, row: &mut Row, value: S::f64s) {
        S::as_mut_simd_f64s(&mut row.0).0[self.part] = value;
    }

    #[inline(always)]
    pub(super) fn all(self, value: f64) -> S::f64s {
        self.simd.splat_f64s(value)
    }

    #[inline(always)]
    pub(super) fn add(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.simd.add_f64s(a, b)
    }

    #[inline(always)]
    pub(super) fn sub(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.simd.sub_f64s(a, b)
    }

    #[inline(always)]
    pub(super) fn mul(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.simd.mul_f64s(a, b)
    }

    #[inline(always)]
    pub(super) fn div(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.simd.div_f64s(a, b)
    }

    #[inline(always)]
    pub(super) fn abs(self, a: S::f64s) -> S::f64s {
        self.simd.abs_f64s(a)
    }

    #[inline(always)]
    pub(super) fn less(self, a: S::f64s, b: S::f64s) -> S::m64s {
        self.simd.less_than_f64s(a, b)
    }

    #[inline(always)]
    pub(super) fn both(self, a: S::m64s, b: S::m64s) -> S::m64s {
        self.simd.and_m64s(a, b)
    }

    #[inline(always)]
    pub(super) fn choose(self, condition: S::m64s, a: S::f64s, b: S::f64s) -> S::f64s {
        self.simd.select_f64s(condition, a, b)
    }

    /// As `f64::clamp`.
    #[inline(always)]
    pub(super) fn clamp(self, x: S::f64s, least: S::f64s, most: S::f64s) -> S::f64s {
        let low = self.choose(self.less(x, least), least, x);
        self.choose(self.less(most, low), most, low)
    }

    /// As `f64::round`: halves away from zero, zeros as they are.
    #[inline(always)]
    pub(super) fn round(self, x: S::f64s) -> S::f64s {
        let (size, zero, whole) = (self.abs(x), self.all(0.0), self.all(ALL_WHOLE));
        // halves to even, exactly
        let even = self.sub(self.add(size, whole), whole);
        let short = self.simd.equal_f64s(self.sub(size, even), self.all(0.5));
        let rounded = self.choose(short, self.add(even, self.all(1.0)), even);
        let signed = self.choose(self.less(x, zero), self.simd.neg_f64s(rounded), rounded);
        let fractional = self.both(self.less(size, whole), self.less(zero, size));
        self.choose(fractional, signed, x)
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
                let vector = Wide { simd, part };
                let value = vector.round(vector.get(self.0));
                vector.put(self.0, value);
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
