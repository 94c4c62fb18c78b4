//! A variant of the machine: which compensator it has, and what its drives are told.

use super::skips::Skips;
use crate::machine::Memory;
use crate::method::Choice;
use lostmotion_drive::config::{Load, Reflected};
use lostmotion_drive::{AxisError, AxisRunner, Learned};
use lostmotion_methods::{AxisConfig, AxisMemory, LearnedOn, MethodId, Misled, build_runner};

/// A variant of the machine: its compensator, or the machine without a gap and without one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Variant<'a> {
    choice: Option<&'a Choice>,
    misled: Option<Misled>,
    /// Of a machine that is rehearsed: its loads and gaps are those of the memory, and this part of
    /// the correction is used, but for these stretches.
    rehearsed: Option<(f64, &'a Skips)>,
}

impl<'a> Variant<'a> {
    /// Closed gaps, no compensator.
    pub(crate) fn without_gap() -> Variant<'a> {
        Variant {
            choice: None,
            misled: None,
            rehearsed: None,
        }
    }

    /// The machine as it is, with a compensator.
    pub(crate) fn with_gap(choice: &'a Choice) -> Variant<'a> {
        Variant {
            choice: Some(choice),
            misled: None,
            rehearsed: None,
        }
    }

    /// The machine as the drives of this one have learned it, with a part of the correction of a
    /// compensator, but for some stretches.
    pub(super) fn rehearsed(&self, choice: &'a Choice, part: f64, skips: &'a Skips) -> Variant<'a> {
        Variant {
            choice: Some(choice),
            misled: self.misled,
            rehearsed: Some((part, skips)),
        }
    }

    /// Its compensator; `None` of the machine without a gap, which is there for comparison alone.
    pub(super) fn choice(&self) -> Option<&'a Choice> {
        self.choice
    }

    /// The same, whose drives are told something wrong.
    pub(crate) fn misled(choice: &'a Choice, misled: Misled) -> Variant<'a> {
        Variant {
            choice: Some(choice),
            misled: Some(misled),
            rehearsed: None,
        }
    }

    /// The part of the correction that is used and the stretches that are left out, of a machine that is
    /// rehearsed.
    pub(super) fn rehearsal(&self) -> Option<(f64, &'a Skips)> {
        self.rehearsed
    }

    /// The description of a drive in this variant, with what it starts from.
    pub(super) fn config(&self, config: &AxisConfig, learned: Option<AxisMemory>) -> AxisConfig {
        let mut config = match (self.choice, self.rehearsed) {
            (None, _) => config.without_gap(),
            (Some(_), None) => config.clone(),
            (Some(_), Some(_)) => {
                let told = self.misled.map(|misled| misled.of(config));
                let told = told.as_ref().unwrap_or(config);
                return as_learned(told, learned.map(|memory| memory.learned));
            }
        };
        config.compensation.learned = learned;
        config
    }

    /// What the drives of this variant believe that are to start from a memory.
    pub(super) fn remembered(&self, memory: &Memory) -> Memory {
        let mut memory = memory.clone();
        if let Some(misled) = self.misled {
            for axis in memory.axis.values_mut() {
                axis.learned = misled.remembered(axis.learned);
            }
        }
        memory
    }

    /// A drive of this variant, from its description.
    pub(super) fn runner(
        &self,
        config: &AxisConfig,
        at: f64,
    ) -> Result<Box<dyn AxisRunner>, AxisError> {
        // What is rehearsed is the axis as its drive believes it to be: nothing misleads it there.
        let misled = self.misled.filter(|_| self.rehearsed.is_none());
        match (self.choice, misled) {
            (None, _) => build_runner(config, MethodId::NONE, at),
            (Some(choice), None) => choice.runner(config, at),
            (Some(choice), Some(misled)) => choice.misled(config, misled, at),
        }
    }
}

/// An axis as its drive believes it to be: with the load and the gap that it has learned, else with
/// a load as heavy as the motor, without friction and gap; with the shaft that it is told; and as
/// plain as can be in all that a drive is not told.
fn as_learned(told: &AxisConfig, remembered: Option<Learned>) -> AxisConfig {
    let load = told.reflected_load();
    let learned = remembered.unwrap_or(Learned {
        load_inertia_kgm2: told.motor_side_inertia_kgm2(),
        ..Learned::default()
    });
    let mut compensation = told.compensation.clone();
    compensation.learned = remembered.map(|learned| AxisMemory {
        learned,
        learned_on: LearnedOn::of(told),
    });
    AxisConfig {
        compensation,
        load: Load::Reflected(Reflected {
            inertia_kgm2: learned.load_inertia_kgm2,
            viscous_nm_s_per_rad: learned.viscous_nm_s_per_rad,
            coulomb_nm: learned.coulomb_nm,
            constant_nm: learned.constant_nm,
            gap_rad: 2.0 * learned.half_gap_rad,
            ..load
        }),
        contact: Default::default(),
        start_in_gap: Default::default(),
        friction: Default::default(),
        flanks: Default::default(),
        ripple: Default::default(),
        gravity: None,
        scale: Default::default(),
        drift: Default::default(),
        ..told.clone()
    }
}
