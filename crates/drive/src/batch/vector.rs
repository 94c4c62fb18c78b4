//! Vectors of a group's rows: one axis in each lane.

use super::lanes::Row;
use lostmotion_base::{Number, Twice, Wide};
use pulp::Simd;

/// A part of a row's lanes as a number.
pub(super) trait Reach: Copy {
    /// What holds them.
    type Value: Number;

    /// Those of a row.
    fn get(self, row: &Row) -> Self::Value;

    /// Puts them into a row.
    fn put(self, row: &mut Row, value: Self::Value);

    /// A constant in all lanes.
    fn all(self, value: f64) -> Self::Value;
}

/// Those that one vector holds.
#[derive(Clone, Copy)]
pub(super) struct Part<S: Simd> {
    pub(super) simd: S,
    pub(super) part: usize,
}

impl<S: Simd> Reach for Part<S> {
    type Value = Wide<S>;

    #[inline(always)]
    fn get(self, row: &Row) -> Wide<S> {
        Wide::get(self.simd, &row.0, self.part)
    }

    #[inline(always)]
    fn put(self, row: &mut Row, value: Wide<S>) {
        value.put(&mut row.0, self.part);
    }

    #[inline(always)]
    fn all(self, value: f64) -> Wide<S> {
        Wide::all(self.simd, value)
    }
}

/// Those of a vector and the next one.
#[derive(Clone, Copy)]
pub(super) struct Pair<S: Simd>(pub(super) Part<S>);

impl<S: Simd> Pair<S> {
    #[inline(always)]
    fn second(self) -> Part<S> {
        Part {
            part: self.0.part + 1,
            ..self.0
        }
    }
}

impl<S: Simd> Reach for Pair<S> {
    type Value = Twice<Wide<S>>;

    #[inline(always)]
    fn get(self, row: &Row) -> Twice<Wide<S>> {
        Twice([self.0.get(row), self.second().get(row)])
    }

    #[inline(always)]
    fn put(self, row: &mut Row, Twice([first, second]): Twice<Wide<S>>) {
        self.0.put(row, first);
        self.second().put(row, second);
    }

    #[inline(always)]
    fn all(self, value: f64) -> Twice<Wide<S>> {
        Twice([self.0.all(value); 2])
    }
}
