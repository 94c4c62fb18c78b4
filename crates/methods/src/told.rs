//! What a drive is told of its axis, and by how much that may be wrong.
//!
//! Gap, friction and stiffness of a machine are measured to some tens of per cent, wear, and change
//! with temperature. A method that works only with exact values works on paper; [`Misled`] makes
//! the description that a drive with wrong values has, so that the same axis can be run with it.

use crate::memory::{LARGEST_HALF_GAP_RAD, LearnedOn};
use crate::{AxisConfig, AxisMemory};
use lostmotion_drive::Learned;
use lostmotion_drive::config::{Load, Reflected};
use serde::{Deserialize, Serialize};

/// By how much a value of an axis may be off if nobody says, as a part of it: in comparisons, in
/// rewritten programs, and among what is worth measuring. A choice: what a gap wears, and friction
/// changes with temperature and lubrication, between two visits of service.
pub const USUAL_SHARE: f64 = 0.3;

/// A quantity that a method may be told, by the settings of an axis or by what was learned before.
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
    /// The description of an axis as a drive has it that is told this quantity wrong: by the
    /// settings of its methods, and by its memory.
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
        // A memory is as wrong, and of the axis as the drive has it.
        told.compensation.learned = axis.compensation.learned.map(|memory| AxisMemory {
            learned: self.remembered(memory.learned),
            learned_on: LearnedOn::of(&told),
        });
        told
    }

    /// A memory that is wrong in this quantity: of an axis that has changed since, or of another one.
    /// The stiffness is not learned.
    #[must_use]
    pub fn remembered(self, learned: Learned) -> Learned {
        match self.what {
            Told::Gap => Learned {
                half_gap_rad: (learned.half_gap_rad * self.factor).min(LARGEST_HALF_GAP_RAD),
                ..learned
            },
            Told::Friction => Learned {
                coulomb_nm: learned.coulomb_nm * self.factor,
                viscous_nm_s_per_rad: learned.viscous_nm_s_per_rad * self.factor,
                ..learned
            },
            Told::Stiffness => learned,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_memory_is_as_wrong_as_the_description_and_of_the_same_axis() {
        let mut axis = AxisConfig::paper();
        let learned = Learned {
            half_gap_rad: 0.25,
            load_inertia_kgm2: 0.01,
            coulomb_nm: 1.0,
            viscous_nm_s_per_rad: 0.1,
            ..Learned::default()
        };
        axis.compensation.learned = Some(AxisMemory::new(learned, &axis));
        let told = |what, factor| {
            let told = Misled { what, factor }.of(&axis);
            let memory = told.compensation.learned.unwrap_or_default();
            assert_eq!(memory.check(&told), Ok(()), "{what:?}");
            memory.learned
        };
        assert!((told(Told::Gap, 0.5).half_gap_rad - 0.125).abs() < 1e-15);
        // no more than is looked for
        assert!((told(Told::Gap, 1.5).half_gap_rad - LARGEST_HALF_GAP_RAD).abs() < 1e-15);
        let friction = told(Told::Friction, 2.0);
        assert_eq!(
            (friction.coulomb_nm, friction.viscous_nm_s_per_rad),
            (2.0, 0.2)
        );
        assert_eq!(told(Told::Stiffness, 2.0).half_gap_rad, 0.25);
        // of a stiffness that is told otherwise, a memory is another axis'
        let stiffer = Misled {
            what: Told::Stiffness,
            factor: 2.0,
        }
        .of(&axis);
        let memory = axis.compensation.learned.unwrap_or_default();
        assert!(memory.check(&stiffer).is_err());
    }
}
