//! What is varied, and the cell: one level of each.

use crate::error::StudyError;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Something that is varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Factor {
    /// Name for tables.
    pub name: &'static str,
    /// Its levels, as a cell's name has them.
    pub levels: &'static [&'static str],
}

const fn factor(name: &'static str, levels: &'static [&'static str]) -> Factor {
    Factor { name, levels }
}

/// Number of factors.
pub const COUNT: usize = 9;

/// Index of each factor.
pub const SHAPE: usize = 0;
/// Index of the feed.
pub const FEED: usize = 1;
/// Index of the direction.
pub const WAY: usize = 2;
/// Index of the gap.
pub const GAP: usize = 3;
/// Index of the Coulomb friction.
pub const FRICTION: usize = 4;
/// Index of the viscous friction.
pub const VISCOUS: usize = 5;
/// Index of the inertia ratio.
pub const INERTIA: usize = 6;
/// Index of the encoder.
pub const ENCODER: usize = 7;
/// Index of the drift.
pub const DRIFT: usize = 8;

/// Every factor, in the order of a cell's name.
///
/// Feeds are in mm/min, total gaps in um at the slide, Coulomb friction in per cent of the motor's
/// rated torque; viscous friction `v20` is 0.2 of the rated torque at the rated speed; the inertia
/// is that of the load over that of the motor; encoders by their bits a turn. `drift` is
/// described in [`super::machine`].
pub const FACTORS: [Factor; COUNT] = [
    factor(
        "motion",
        &[
            "circle5",
            "circle10",
            "circle25",
            "circle50",
            "circle150",
            "square",
            "rounded",
            "lissajous",
            "zigzag",
            "pocket",
        ],
    ),
    factor("feed", &["f300", "f1000", "f3000", "f10000"]),
    factor("way", &["ccw", "cw"]),
    factor("gap", &["g2", "g5", "g10", "g20", "g60", "g300"]),
    factor("friction", &["t0", "t2", "t10", "t30"]),
    factor("viscous", &["v0", "v20"]),
    factor("inertia", &["j0.5", "j1", "j2", "j4", "j8"]),
    factor("encoder", &["ideal", "e23", "e20", "e17"]),
    factor("drift", &["steady", "drift"]),
];

/// One level of each factor. Its text is the levels' names with `-` between:
/// `circle25-f3000-ccw-g10-t10-v0-j2-e20-steady`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell(pub(super) [u8; COUNT]);

impl Cell {
    /// The level of a factor, as an index into its levels.
    pub fn level(&self, factor: usize) -> usize {
        self.0.get(factor).map_or(0, |level| usize::from(*level))
    }

    /// The name of the level of a factor.
    pub fn level_name(&self, factor: usize) -> &'static str {
        FACTORS
            .get(factor)
            .and_then(|f| f.levels.get(self.level(factor)))
            .copied()
            .unwrap_or_default()
    }

    /// The number in the name of a level: 3000 of `f3000`. 0 where there is none.
    pub fn number(&self, factor: usize) -> f64 {
        self.level_name(factor)
            .trim_start_matches(|c: char| c.is_ascii_alphabetic())
            .parse()
            .unwrap_or(0.0)
    }

    /// The cell of a name.
    ///
    /// # Errors
    /// The part of the name that is no level, with the levels that exist.
    pub fn parse(id: &str) -> Result<Cell, StudyError> {
        let error = |reason: String| StudyError::CellName {
            id: id.to_owned(),
            reason,
        };
        // One part a factor, in the order of the factors.
        let parts: Vec<&str> = id.split('-').collect();
        if parts.len() != COUNT {
            return Err(error(format!(
                "a name has {COUNT} parts with `-` between, such as {}",
                Cell::default()
            )));
        }
        let mut levels = [0; COUNT];
        for ((level, part), factor) in levels.iter_mut().zip(parts).zip(&FACTORS) {
            let found = factor.levels.iter().position(|name| *name == part);
            let found = found.ok_or_else(|| {
                error(format!(
                    "{} is one of {}, not `{part}`",
                    factor.name,
                    factor.levels.join(", ")
                ))
            })?;
            *level = found as u8;
        }
        Ok(Cell(levels))
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for factor in 0..COUNT {
            let dash = if factor == 0 { "" } else { "-" };
            write!(f, "{dash}{}", self.level_name(factor))?;
        }
        Ok(())
    }
}

impl Serialize for Cell {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Cell {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Cell, D::Error> {
        let text = String::deserialize(deserializer)?;
        Cell::parse(&text).map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_comes_back_as_its_cell() {
        for cell in super::super::sample::sample(60, 3).unwrap() {
            assert_eq!(Cell::parse(&cell.to_string()).unwrap(), cell);
        }
    }

    #[test]
    fn numbers_are_those_of_the_names() {
        let cell = Cell::parse("circle25-f3000-cw-g60-t30-v20-j0.5-e20-steady").unwrap();
        let numbers: Vec<f64> = (0..COUNT).map(|factor| cell.number(factor)).collect();
        assert_eq!(
            numbers,
            [25.0, 3000.0, 0.0, 60.0, 30.0, 20.0, 0.5, 20.0, 0.0]
        );
    }

    #[test]
    fn what_is_wrong_with_a_name_is_told() {
        let text = |id: &str| Cell::parse(id).unwrap_err().to_string();
        assert!(text("circle25").contains("9 parts"), "{}", text("circle25"));
        let other = text("circle25-f3000-cw-g61-t30-v20-j0.5-e20-steady");
        assert!(
            other.contains("gap is one of g2, g5") && other.contains("g61"),
            "{other}"
        );
    }
}
