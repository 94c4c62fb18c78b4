//! Vectors of a group's rows: one axis in each lane.

use super::lanes::Row;
use lostmotion_base::Wide;
use pulp::Simd;

/// Part of a row's lanes: those that one vector holds.
#[derive(Clone, Copy)]
pub(super) struct Part<S: Simd> {
    pub(super) simd: S,
    pub(super) part: usize,
}

impl<S: Simd> Part<S> {
    #[inline(always)]
    pub(super) fn get(self, row: &Row) -> Wide<S> {
        Wide::get(self.simd, &row.0, self.part)
    }

    #[inline(always)]
    pub(super) fn put(self, row: &mut Row, value: Wide<S>) {
        value.put(&mut row.0, self.part);
    }

    /// A constant in all lanes.
    #[inline(always)]
    pub(super) fn all(self, value: f64) -> Wide<S> {
        Wide::all(self.simd, value)
    }
}
