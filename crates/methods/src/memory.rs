//! The memory of an axis: what a method has learned of it, bound to the axis it was learned on.
//!
//! What was learned holds for a motor, a transmission, a shaft and an encoder. Loops may be tuned
//! anew, limits and programs may change; with another motor or screw the figures are those of
//! another axis, and [`AxisMemory::check`] names the first key that differs.

use crate::AxisConfig;
use lostmotion_base::units::number;
use lostmotion_drive::Learned;
use lostmotion_drive::config::Transmission;
use lostmotion_drive::config::check::{AxisConfigError, between};
use serde::{Deserialize, Serialize};

/// Relative difference up to which two values of a description are the same: a file may give a
/// gear in fewer digits. A choice.
const SAME_SHARE: f64 = 1e-6;

/// Coulomb friction from which on it holds a load, part of the rated torque. Tuned on drawn cells:
/// loads with 0.6 % and more were helped there.
pub(crate) const HOLDING_SHARE: f64 = 0.005;
/// Standard deviations of the friction by which a memory has to be above it. A choice: loads that bounce
/// deviate by more than is estimated, and a minute of commissioning tells the friction of one that
/// friction holds to a tenth.
pub(crate) const CERTAIN_DEVIATIONS: f64 = 3.0;

/// Standard deviation of the friction up to which a memory tells it, part of it. Tuned: with
/// a tenth 773109-26, without friction, is believed to have some.
const TELLING_SHARE: f64 = 0.05;

/// Whether a memory tells the friction of a load at all: one that does not after a minute of motion did
/// not understand the load, which bounces, and what it says of inertia and gap is as doubtful.
fn tells_friction(learned: &Learned, rated_nm: f64) -> bool {
    learned.coulomb_deviation_nm
        <= (HOLDING_SHARE * rated_nm).max(TELLING_SHARE * learned.coulomb_nm)
}

/// Whether a drive starts from a memory. One of a load that may float corrects nothing, and where it says so
/// wrongly, its load hides what motion shows (518093-9: a gap read 85 % too small beside axes that use all of
/// theirs): that axis starts anew, unless its gap is too small to matter and nobody has to wait for it.
pub(crate) fn is_started_from(learned: &Learned, rated_nm: f64, negligible_rad: f64) -> bool {
    let most = learned.half_gap_rad + 2.0 * learned.half_gap_deviation_rad;
    let is_nil = learned.gap_readings > 0 && most <= negligible_rad;
    tells_friction(learned, rated_nm) && (!learned.floats || is_nil)
}

/// Largest half gap that is looked for, rad at the motor: 1 mm on a screw of 20 mm.
pub(crate) const LARGEST_HALF_GAP_RAD: f64 = 0.3;

/// Half gap below which there is nothing to compensate, mm of a linear axis: 1.3 um in all.
const NEGLIGIBLE_HALF_GAP_MM: f64 = 6.5e-4;
/// The same of a rotary axis, rad at the motor.
const NEGLIGIBLE_HALF_GAP_RAD: f64 = 2e-4;

/// Half gap below which there is nothing to compensate, rad at the motor.
pub(crate) fn negligible_half_gap_rad(transmission: &Transmission) -> f64 {
    match transmission {
        Transmission::Rotary { .. } => NEGLIGIBLE_HALF_GAP_RAD,
        _ => NEGLIGIBLE_HALF_GAP_MM * transmission.motor_rad_per_unit(),
    }
}

/// What must not change of an axis for what was learned on it to hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearnedOn {
    /// Inertia of the motor's rotor, kg m2.
    pub rotor_inertia_kgm2: f64,
    /// Inertia of screw or pinion on the motor's side of the gap, kg m2.
    pub screw_inertia_kgm2: f64,
    /// Torque of the motor for one ampere, N m/A.
    pub torque_constant_nm_per_a: f64,
    /// Torque that the motor can give for ever, N m.
    pub rated_torque_nm: f64,
    /// Viscous friction at the motor, N m s/rad.
    pub motor_viscous_nm_s_per_rad: f64,
    /// Coulomb friction at the motor, N m.
    pub motor_coulomb_nm: f64,
    /// Way for one turn of the screw, mm; `None` for an axis that turns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lead_mm: Option<f64>,
    /// Turns of the motor for one turn of screw or table.
    pub gear: f64,
    /// Stiffness of the shaft at the motor, N m/rad.
    pub stiffness_nm_per_rad: f64,
    /// Counts of a turn of the motor's encoder; `None` for an ideal one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub encoder_counts_per_rev: Option<u32>,
}

impl LearnedOn {
    /// Of an axis.
    pub fn of(axis: &AxisConfig) -> LearnedOn {
        let load = axis.reflected_load();
        let (lead_mm, gear) = match axis.transmission {
            Transmission::Linear(linear) => (Some(linear.lead_mm), linear.gear),
            Transmission::Rotary(rotary) => (None, rotary.gear),
        };
        LearnedOn {
            rotor_inertia_kgm2: axis.motor.inertia_kgm2,
            screw_inertia_kgm2: load.motor_side_inertia_kgm2,
            torque_constant_nm_per_a: axis.motor.torque_constant_nm_per_a,
            rated_torque_nm: axis.motor.rated_torque_nm,
            motor_viscous_nm_s_per_rad: axis.motor.viscous_nm_s_per_rad,
            motor_coulomb_nm: axis.motor.coulomb_nm,
            lead_mm,
            gear,
            stiffness_nm_per_rad: load.stiffness_nm_per_rad,
            encoder_counts_per_rev: axis.drive.encoder_counts_per_rev,
        }
    }

    /// Every quantity: its key, what people call it, its value; `None` where there is no such part.
    fn all(&self) -> [(&'static str, &'static str, Option<f64>); 10] {
        [
            (
                "rotor_inertia_kgm2",
                "a rotor inertia of",
                Some(self.rotor_inertia_kgm2),
            ),
            (
                "screw_inertia_kgm2",
                "an inertia of screw or pinion of",
                Some(self.screw_inertia_kgm2),
            ),
            (
                "torque_constant_nm_per_a",
                "a torque constant of",
                Some(self.torque_constant_nm_per_a),
            ),
            (
                "rated_torque_nm",
                "a rated torque of",
                Some(self.rated_torque_nm),
            ),
            (
                "motor_viscous_nm_s_per_rad",
                "a viscous friction of the motor of",
                Some(self.motor_viscous_nm_s_per_rad),
            ),
            (
                "motor_coulomb_nm",
                "a Coulomb friction of the motor of",
                Some(self.motor_coulomb_nm),
            ),
            ("lead_mm", "a lead of", self.lead_mm),
            ("gear", "a gear of", Some(self.gear)),
            (
                "stiffness_nm_per_rad",
                "a stiffness of",
                Some(self.stiffness_nm_per_rad),
            ),
            (
                "encoder_counts_per_rev",
                "encoder counts per turn of",
                self.encoder_counts_per_rev.map(f64::from),
            ),
        ]
    }
}

/// Part of a gap that is surely there while it is learned. A choice: first readings may be too large by a
/// twentieth (20261124-15: 3 %, behind which a peak that is 4 % higher hides).
const LEAST_GAP_SHARE: f64 = 0.95;

/// What was learned of an axis, and which axis that was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisMemory {
    /// Load and gap.
    pub learned: Learned,
    /// The axis.
    pub learned_on: LearnedOn,
}

impl AxisMemory {
    /// Whether a drive starts from it: its friction is told. One that a minute of motion does not tell
    /// is of a load that bounces, and what is said of inertia and gap is as doubtful.
    pub fn is_believed(&self, axis: &AxisConfig) -> bool {
        tells_friction(&self.learned, axis.motor.rated_torque_nm)
    }

    /// Whether an axis has a gap that is worth compensating, or may have: that is not certainly too small.
    pub fn has_gap(&self, axis: &AxisConfig) -> bool {
        let Learned {
            half_gap_rad,
            half_gap_deviation_rad,
            ..
        } = self.learned;
        half_gap_rad + 2.0 * half_gap_deviation_rad > negligible_half_gap_rad(&axis.transmission)
    }

    /// What was learned on an axis. It is used from the first moment on, without a proof: that friction
    /// holds the load against what pulls it has to be certain by more than while learning, else it counts as one that
    /// may float.
    pub fn new(learned: Learned, axis: &AxisConfig) -> AxisMemory {
        let least = learned.coulomb_nm
            - learned.constant_nm.abs()
            - CERTAIN_DEVIATIONS * learned.coulomb_deviation_nm;
        let learned = Learned {
            floats: learned.floats || least <= HOLDING_SHARE * axis.motor.rated_torque_nm,
            ..learned
        };
        AxisMemory {
            learned,
            learned_on: LearnedOn::of(axis),
        }
    }

    /// What is known of an axis while it learns, taken as certain, for a rehearsal of what its drive would do
    /// with it: with the least gap that it may have, which hides least of what the contour would be without
    /// it.
    pub fn so_far(learned: Learned, axis: &AxisConfig) -> AxisMemory {
        AxisMemory {
            learned: Learned {
                half_gap_rad: LEAST_GAP_SHARE * learned.half_gap_rad,
                half_gap_deviation_rad: 0.0,
                load_inertia_deviation_kgm2: 0.0,
                viscous_deviation_nm_s_per_rad: 0.0,
                coulomb_deviation_nm: 0.0,
                constant_deviation_nm: 0.0,
                correlations: [0.0; 6],
                ..learned
            },
            learned_on: LearnedOn::of(axis),
        }
    }

    /// The total gap in the unit of an axis (mm, deg, rad); 0 while it is unknown.
    pub fn gap_in_unit(&self, axis: &AxisConfig) -> f64 {
        2.0 * self.learned.half_gap_rad / axis.transmission.motor_rad_per_unit()
    }

    /// Whether it can be used on an axis: values that make sense, learned on such an axis.
    ///
    /// # Errors
    /// The first value out of range, or else the first that differs from the axis', with its key.
    pub fn check(&self, axis: &AxisConfig) -> Result<(), AxisConfigError> {
        self.learned
            .check()
            .map_err(|error| error.within("learned"))?;
        between(
            "learned.half_gap_rad",
            self.learned.half_gap_rad,
            0.0,
            LARGEST_HALF_GAP_RAD,
        )?;
        let here = LearnedOn::of(axis);
        for ((key, what, there), (_, _, here)) in self.learned_on.all().into_iter().zip(here.all())
        {
            if same(there, here) {
                continue;
            }
            let shown = |value: Option<f64>| value.map_or_else(|| "none".to_owned(), number);
            return Err(AxisConfigError::Mismatch {
                key: format!("learned_on.{key}"),
                reason: format!(
                    "it was learned on an axis with {what} {}, this one has {}",
                    shown(there),
                    shown(here)
                ),
                hint: "take the memory of this axis, or let it learn anew (`axis commission`)"
                    .to_owned(),
            });
        }
        Ok(())
    }
}

/// Whether two values are the same for a description.
fn same(there: Option<f64>, here: Option<f64>) -> bool {
    match (there, here) {
        (Some(there), Some(here)) => {
            (there - here).abs() <= SAME_SHARE * there.abs().max(here.abs())
        }
        (None, None) => true,
        _ => false,
    }
}
