//! Rows of numbers that are worked on side by side, in vectors as wide as the processor has them.
//!
//! Each lane is computed as a number by itself would be, in the same order, so that no bit depends on the
//! width.

use lostmotion_base::Wide;
use pulp::Simd;

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

/// The vectors that hold all lanes.
#[inline(always)]
pub(crate) fn parts<S: Simd>(simd: S) -> impl Iterator<Item = Part<S>> {
    (0..LANES / S::F64_LANES).map(move |part| Part { simd, part })
}

// Nothing here takes a closure with vectors in it: one that is not inlined has not the code of vectors.
impl<S: Simd> Part<S> {
    #[inline(always)]
    pub(crate) fn get(self, lanes: &Lanes) -> Wide<S> {
        Wide::get(self.simd, lanes, self.part)
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
        Wide::get(self.simd, &numbers[first..first + LANES], self.part)
    }

    #[inline(always)]
    pub(crate) fn put(self, value: Wide<S>, lanes: &mut Lanes) {
        value.put(lanes, self.part);
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
