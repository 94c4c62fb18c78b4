//! A point in the space of the nine program axes.

use crate::axis::{AXES, AxisId};
use crate::vec::norm;
use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign, Index, IndexMut, Mul, Neg, Sub};

/// Coordinates of the nine axes X Y Z A B C U V W: linear axes in mm, rotary axes in rad.
///
/// Used for positions, differences and derivatives; which frame they are in (part, machine, joint)
/// is told by the field or argument that holds them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Coords(pub [f64; AXES]);

impl Coords {
    /// All zero.
    pub const ZERO: Coords = Coords([0.0; AXES]);

    /// A linear position, the other axes zero.
    #[inline]
    pub const fn xyz(x: f64, y: f64, z: f64) -> Coords {
        Coords([x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    /// X, Y, Z in mm.
    #[inline]
    pub const fn linear(&self) -> [f64; 3] {
        [self.0[0], self.0[1], self.0[2]]
    }

    /// A, B, C in rad.
    #[inline]
    pub const fn rotary(&self) -> [f64; 3] {
        [self.0[3], self.0[4], self.0[5]]
    }

    /// Sum of products of all nine coordinates. Mixes mm and rad: only for tests against zero and
    /// for scaling.
    #[inline]
    pub fn dot(&self, other: &Coords) -> f64 {
        // In index order, so that the same sum has the same bits everywhere.
        let mut sum = 0.0;
        for i in 0..AXES {
            sum += self.0[i] * other.0[i];
        }
        sum
    }

    /// Length of the X, Y, Z part in mm.
    #[inline]
    pub fn linear_norm(&self) -> f64 {
        norm(self.linear())
    }

    /// Whether every coordinate is a finite number.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.0.iter().all(|c| c.is_finite())
    }

    /// Each coordinate through a function.
    #[inline]
    #[must_use]
    pub fn map(self, f: impl Fn(f64) -> f64) -> Coords {
        Coords(self.0.map(f))
    }

    /// The point a fraction `u` of the way to another one.
    #[inline]
    #[must_use]
    pub fn lerp(self, to: Coords, u: f64) -> Coords {
        self + (to - self) * u
    }
}

impl Index<AxisId> for Coords {
    type Output = f64;
    #[inline]
    fn index(&self, axis: AxisId) -> &f64 {
        &self.0[axis.index()]
    }
}

impl IndexMut<AxisId> for Coords {
    #[inline]
    fn index_mut(&mut self, axis: AxisId) -> &mut f64 {
        &mut self.0[axis.index()]
    }
}

impl Add for Coords {
    type Output = Coords;
    #[inline]
    fn add(mut self, other: Coords) -> Coords {
        self += other;
        self
    }
}

impl AddAssign for Coords {
    #[inline]
    fn add_assign(&mut self, other: Coords) {
        for i in 0..AXES {
            self.0[i] += other.0[i];
        }
    }
}

impl Sub for Coords {
    type Output = Coords;
    #[inline]
    fn sub(mut self, other: Coords) -> Coords {
        for i in 0..AXES {
            self.0[i] -= other.0[i];
        }
        self
    }
}

impl Mul<f64> for Coords {
    type Output = Coords;
    #[inline]
    fn mul(self, factor: f64) -> Coords {
        self.map(|c| c * factor)
    }
}

impl Neg for Coords {
    type Output = Coords;
    #[inline]
    fn neg(self) -> Coords {
        self.map(|c| -c)
    }
}
