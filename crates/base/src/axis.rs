//! The nine axes a part program can name, sets of them, and the planes of arcs.

use serde::{Deserialize, Serialize};

/// How many axes a part program can name: X Y Z A B C U V W.
pub const AXES: usize = 9;

/// An axis of the part program.
///
/// The discriminant is its index in [`crate::Coords`].
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[repr(u8)]
pub enum AxisId {
    /// Linear, mm.
    #[default]
    X,
    /// Linear, mm.
    Y,
    /// Linear, mm.
    Z,
    /// Rotary about X, rad.
    A,
    /// Rotary about Y, rad.
    B,
    /// Rotary about Z, rad.
    C,
    /// Linear, parallel to X, mm.
    U,
    /// Linear, parallel to Y, mm.
    V,
    /// Linear, parallel to Z, mm.
    W,
}

impl AxisId {
    /// Every axis in index order.
    pub const ALL: [AxisId; AXES] = [
        AxisId::X,
        AxisId::Y,
        AxisId::Z,
        AxisId::A,
        AxisId::B,
        AxisId::C,
        AxisId::U,
        AxisId::V,
        AxisId::W,
    ];

    /// Index in a [`crate::Coords`], 0 for X to 8 for W.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The axis at an index, if it is below [`AXES`].
    pub fn from_index(index: usize) -> Option<AxisId> {
        Self::ALL.get(index).copied()
    }

    /// The axis of a letter, upper or lower case.
    pub fn from_letter(letter: char) -> Option<AxisId> {
        let upper = letter.to_ascii_uppercase();
        Self::ALL.into_iter().find(|axis| axis.letter() == upper)
    }

    /// The upper-case letter.
    pub const fn letter(self) -> char {
        match self {
            AxisId::X => 'X',
            AxisId::Y => 'Y',
            AxisId::Z => 'Z',
            AxisId::A => 'A',
            AxisId::B => 'B',
            AxisId::C => 'C',
            AxisId::U => 'U',
            AxisId::V => 'V',
            AxisId::W => 'W',
        }
    }

    /// True for A, B and C, whose coordinates are angles.
    pub const fn is_rotary(self) -> bool {
        matches!(self, AxisId::A | AxisId::B | AxisId::C)
    }

    /// Column name with the unit that files use: `x_mm`, `a_deg`.
    pub const fn column(self) -> &'static str {
        match self {
            AxisId::X => "x_mm",
            AxisId::Y => "y_mm",
            AxisId::Z => "z_mm",
            AxisId::A => "a_deg",
            AxisId::B => "b_deg",
            AxisId::C => "c_deg",
            AxisId::U => "u_mm",
            AxisId::V => "v_mm",
            AxisId::W => "w_mm",
        }
    }
}

impl std::fmt::Display for AxisId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.letter())
    }
}

/// A set of axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct AxisSet(u16);

impl AxisSet {
    /// No axis.
    pub const EMPTY: AxisSet = AxisSet(0);

    /// With one axis more.
    #[must_use]
    pub const fn with(self, axis: AxisId) -> AxisSet {
        // One bit per axis, at its index.
        AxisSet(self.0 | 1 << axis as u16)
    }

    /// Whether the axis is in the set.
    pub const fn contains(self, axis: AxisId) -> bool {
        self.0 & (1 << axis as u16) != 0
    }

    /// Whether no axis is in the set.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// How many axes are in the set.
    pub const fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// The axes in index order.
    pub fn iter(self) -> impl Iterator<Item = AxisId> {
        AxisId::ALL
            .into_iter()
            .filter(move |axis| self.contains(*axis))
    }
}

impl FromIterator<AxisId> for AxisSet {
    fn from_iter<T: IntoIterator<Item = AxisId>>(axes: T) -> AxisSet {
        axes.into_iter().fold(AxisSet::EMPTY, AxisSet::with)
    }
}

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
    #[inline]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_and_indices_round_trip() {
        for (index, axis) in AxisId::ALL.into_iter().enumerate() {
            assert_eq!(axis.index(), index);
            assert_eq!(AxisId::from_index(index), Some(axis));
            assert_eq!(
                AxisId::from_letter(axis.letter().to_ascii_lowercase()),
                Some(axis)
            );
        }
        assert_eq!(AxisId::from_letter('E'), None);
    }

    #[test]
    fn a_set_holds_what_was_put_in() {
        let set: AxisSet = [AxisId::Z, AxisId::A].into_iter().collect();
        assert_eq!(set.iter().collect::<Vec<_>>(), [AxisId::Z, AxisId::A]);
        assert_eq!(set.len(), 2);
        assert!(!set.contains(AxisId::X));
    }
}
