//! What a drive is told of its axis, and by how much that may be wrong.
//!
//! Gap, friction and stiffness of a machine are measured to some tens of per cent, wear, and change
//! with temperature. A method that works only with exact values works on paper; [`Misled`] makes
//! the description that a drive with wrong values has, so that the same axis can be run with it.

use crate::AxisConfig;
use lostmotion_drive::config::{Load, Reflected};
use serde::{Deserialize, Serialize};

/// By how much a value of an axis may be off if nobody says, as a part of it: in comparisons, in
/// rewritten programs, and among what is worth measuring. A choice: what a gap wears, and friction
/// changes with temperature and lubrication, between two visits of service.
pub const USUAL_SHARE: f64 = 0.3;

/// A quantity that a method may be told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Told {
    /// The total gap, from the settings of a method or from the axis.
    #[default]
    Gap,
    /// Coulomb and viscous friction of the load.
    Friction,
    /// Stiffness of the shaft.
    Stiffness,
}

impl Told {
    /// Every quantity.
    pub const ALL: [Told; 3] = [Told::Gap, Told::Friction, Told::Stiffness];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Told::Gap => "gap",
            Told::Friction => "friction",
            Told::Stiffness => "stiffness",
        }
    }
}

/// One quantity that is told wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Misled {
    /// Which.
    pub what: Told,
    /// Told over true; above zero.
    pub factor: f64,
}

impl Misled {
    /// The description of an axis as a drive has it that is told this quantity wrong.
    #[must_use]
    pub fn of(self, axis: &AxisConfig) -> AxisConfig {
        let mut told = axis.clone();
        let load = axis.reflected_load();
        let load = match self.what {
            Told::Gap => {
                told.compensation.scale_gaps(self.factor);
                Reflected {
                    gap_rad: load.gap_rad * self.factor,
                    ..load
                }
            }
            Told::Friction => Reflected {
                coulomb_nm: load.coulomb_nm * self.factor,
                viscous_nm_s_per_rad: load.viscous_nm_s_per_rad * self.factor,
                ..load
            },
            // The damping stays: it is told as a number of its own.
            Told::Stiffness => Reflected {
                stiffness_nm_per_rad: load.stiffness_nm_per_rad * self.factor,
                ..load
            },
        };
        told.load = Load::Reflected(load);
        told
    }
}
