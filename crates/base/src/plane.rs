//! The plane of arcs.

use serde::{Deserialize, Serialize};

/// The plane in which arcs run, and in which a contour error has a side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Plane {
    /// G17: X to Y, normal Z.
    #[default]
    Xy,
    /// G18: Z to X, normal Y.
    Zx,
    /// G19: Y to Z, normal X.
    Yz,
}

impl Plane {
    /// Indices of the first and second axis and of the normal, right-handed.
    pub const fn axes(self) -> [usize; 3] {
        // Cyclic permutations of X Y Z: right-handed.
        match self {
            Plane::Xy => [0, 1, 2],
            Plane::Zx => [2, 0, 1],
            Plane::Yz => [1, 2, 0],
        }
    }

    /// Name as the canonical operations of RS274/NGC have it: XY, XZ or YZ.
    pub const fn name(self) -> &'static str {
        match self {
            Plane::Xy => "XY",
            Plane::Zx => "XZ",
            Plane::Yz => "YZ",
        }
    }
}
