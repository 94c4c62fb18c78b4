//! Where a part is looked at from.

/// A coordinate plane to look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Plane {
    /// X to the right, Y up.
    Xy,
    /// X to the right, Z up.
    Xz,
    /// Y to the right, Z up.
    Yz,
}

impl Plane {
    /// The plane that shows most by the extents along X, Y and Z: without the direction of the smallest,
    /// XY when in doubt.
    pub(crate) fn of_extents([x, y, z]: [f64; 3]) -> Plane {
        // XY unless Z clearly is larger than one of them: milled parts are looked at from above.
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
    pub(crate) fn project(self, point: [f64; 3]) -> [f64; 2] {
        self.indices().map(|axis| point[axis])
    }

    /// Labels of the horizontal and the vertical direction.
    pub(crate) fn labels(self) -> [&'static str; 2] {
        self.indices().map(|axis| ["X, mm", "Y, mm", "Z, mm"][axis])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plane_is_the_one_that_shows_most() {
        assert_eq!(Plane::of_extents([10.0, 10.0, 5.0]), Plane::Xy);
        assert_eq!(Plane::of_extents([10.0, 0.0, 5.0]), Plane::Xz);
        assert_eq!(Plane::of_extents([0.0, 10.0, 5.0]), Plane::Yz);
        assert_eq!(Plane::of_extents([10.0, 0.0, 0.0]), Plane::Xy);
    }
}
