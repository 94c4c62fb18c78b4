//! What all curves can do.

use crate::{Arc, Line, Quintic};
use lostmotion_base::Coords;
use serde::{Deserialize, Serialize};

/// The plane in which arcs run and in which a contour error has a side.
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
    /// Indices of the two axes in the plane and of its normal, in right-handed order.
    pub const fn axes(self) -> [usize; 3] {
        match self {
            Plane::Xy => [0, 1, 2],
            Plane::Zx => [2, 0, 1],
            Plane::Yz => [1, 2, 0],
        }
    }
}

/// The point of a curve nearest to some point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// Parameter of the foot point on the curve, mm.
    pub s: f64,
    /// Distance in the X Y Z space, mm, never negative.
    pub distance: f64,
}

/// A piece of path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Curve {
    /// Straight in all axes.
    Line(Line),
    /// Circular, helical or spiral in X Y Z, other axes linear.
    Arc(Arc),
    /// A polynomial piece of degree five in each axis (blends, smoothed runs).
    Quintic(Quintic),
}
