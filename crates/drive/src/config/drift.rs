//! Parameters that change while the machine runs: wear, warm-up, a changing load.

use super::check::{AxisConfigError, between};
use lostmotion_base::math;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// How a factor goes from 1 to where it goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// In a straight line, and stays there.
    #[default]
    Ramp,
    /// There and back in a raised cosine, again and again.
    Cycle,
}

/// One parameter's change: it is multiplied by a factor that is 1 at the start.
///
/// In a file: `gap = { factor = 1.5, over_s = 60.0 }`, or
/// `{ factor = 1.5, over_s = 60.0, shape = "cycle" }`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Change {
    /// The factor at the ramp's end, or in the middle of the cycle; 0.01 to 100.
    pub factor: f64,
    /// Length of the ramp, or period of the cycle, s; 0.001 to 1e7.
    pub over_s: f64,
    /// `ramp` (default) or `cycle`.
    #[serde(default)]
    pub shape: Shape,
}

impl Change {
    /// The factor at a time since the start, s.
    pub fn at(&self, time_s: f64) -> f64 {
        // ramp: straight to the factor, then constant; cycle: there and back on a cosine
        let part = time_s / self.over_s;
        let share = match self.shape {
            Shape::Ramp => part.clamp(0.0, 1.0),
            Shape::Cycle => 0.5 - 0.5 * math::cos(TAU * (part - part.floor())),
        };
        1.0 + (self.factor - 1.0) * share
    }

    fn check(&self) -> Result<(), AxisConfigError> {
        between("factor", self.factor, 0.01, 100.0)?;
        between("over_s", self.over_s, 1e-3, 1e7)
    }
}

/// Which parameters of the plant change while the axis runs, and how. The drive and the compensator
/// are not told.
///
/// Time counts from the start of the axis. Gap and Coulomb friction follow at every setpoint (1
/// ms); what the exact steps are made of (inertia, viscous friction, stiffness) follows every
/// [`crate::runner::DRIFT_MS`] (100 ms). Speeds do not jump when the inertia changes: mass comes
/// and goes with the speed that the load has.
///
/// In a file: a table `drift`; a parameter that is left out stays as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drift {
    /// Total gap.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<Change>,
    /// Coulomb friction at the load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load_coulomb: Option<Change>,
    /// Viscous friction at the load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load_viscous: Option<Change>,
    /// Inertia (or mass) of the load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load_inertia: Option<Change>,
    /// Coulomb friction at the motor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor_coulomb: Option<Change>,
    /// Viscous friction at the motor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor_viscous: Option<Change>,
    /// Stiffness of the shaft.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<Change>,
}

impl Drift {
    /// Nothing changes.
    pub const NONE: Drift = Drift {
        gap: None,
        load_coulomb: None,
        load_viscous: None,
        load_inertia: None,
        motor_coulomb: None,
        motor_viscous: None,
        stiffness: None,
    };

    /// Whether nothing changes.
    pub fn is_none(&self) -> bool {
        *self == Drift::NONE
    }

    /// Whether something changes that the precomputed steps are made of.
    pub(crate) fn changes_steps(&self) -> bool {
        [
            self.load_viscous,
            self.load_inertia,
            self.motor_viscous,
            self.stiffness,
        ]
        .iter()
        .any(Option::is_some)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn check(&self) -> Result<(), AxisConfigError> {
        let changes = [
            ("gap", self.gap),
            ("load_coulomb", self.load_coulomb),
            ("load_viscous", self.load_viscous),
            ("load_inertia", self.load_inertia),
            ("motor_coulomb", self.motor_coulomb),
            ("motor_viscous", self.motor_viscous),
            ("stiffness", self.stiffness),
        ];
        changes.into_iter().try_for_each(|(key, change)| {
            change.map_or(Ok(()), |change| change.check().map_err(|e| e.within(key)))
        })
    }
}
