//! From space to a plane.

use super::scale::Range;
use super::trace::ContourTrace;

/// A coordinate plane to look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    /// X to the right, Y up.
    Xy,
    /// X to the right, Z up.
    Xz,
    /// Y to the right, Z up.
    Yz,
}

impl Plane {
    /// The plane that shows most of the traces: without the direction of smallest extent, XY when
    /// in doubt.
    pub fn of(traces: &[ContourTrace]) -> Plane {
        let extent = |axis: usize| {
            Range::of(
                traces
                    .iter()
                    .flat_map(ContourTrace::points)
                    .map(|p| p.foot_mm[axis]),
            )
            .map_or(0.0, |range| range.span())
        };
        let [x, y, z] = [extent(0), extent(1), extent(2)];
        if z <= x.min(y) * 1.5 || (z <= x && z <= y) {
            Plane::Xy
        } else if y <= x {
            Plane::Xz
        } else {
            Plane::Yz
        }
    }

    const fn indices(self) -> [usize; 2] {
        match self {
            Plane::Xy => [0, 1],
            Plane::Xz => [0, 2],
            Plane::Yz => [1, 2],
        }
    }

    /// The two coordinates seen.
    pub fn project(self, point: [f64; 3]) -> [f64; 2] {
        self.indices().map(|axis| point[axis])
    }

    /// Labels of the horizontal and the vertical direction.
    pub fn labels(self) -> [&'static str; 2] {
        self.indices().map(|axis| ["X, mm", "Y, mm", "Z, mm"][axis])
    }
}
