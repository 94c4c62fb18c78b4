//! Between the axis' own unit and the motor shaft.

use super::check::{AxisConfigError, positive};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Unit of an axis' positions at its boundary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AxisUnit {
    /// Millimetre at the slide.
    Mm,
    /// Degree at the table.
    Deg,
    /// Radian at the table.
    #[default]
    Rad,
}

impl AxisUnit {
    /// How people write it.
    pub const fn symbol(self) -> &'static str {
        match self {
            AxisUnit::Mm => "mm",
            AxisUnit::Deg => "deg",
            AxisUnit::Rad => "rad",
        }
    }
}

/// A ball screw between motor and slide. Positions are in mm at the slide.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Linear {
    /// Travel of the slide for one turn of the screw, mm.
    pub lead_mm: f64,
    /// Turns of the motor for one turn of the screw.
    #[serde(default = "one")]
    pub gear: f64,
}

/// A gear between motor and rotary table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rotary {
    /// Turns of the motor for one turn of the table.
    #[serde(default = "one")]
    pub gear: f64,
    /// Unit of the axis' positions: `rad` (default) or `deg`.
    #[serde(default)]
    pub unit: AxisUnit,
}

fn one() -> f64 {
    1.0
}

/// What lies between the motor's shaft and what the axis moves.
///
/// In a file: a table `transmission.linear` or `transmission.rotary`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Transmission {
    /// Ball screw and slide, mm.
    Linear(Linear),
    /// Gear and table, rad or deg.
    Rotary(Rotary),
}

impl Transmission {
    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of range, or a rotary axis in mm.
    pub fn check(&self) -> Result<(), AxisConfigError> {
        match self {
            Transmission::Linear(linear) => positive("lead_mm", linear.lead_mm)
                .and_then(|()| positive("gear", linear.gear))
                .map_err(|e| e.within("linear")),
            Transmission::Rotary(Rotary {
                unit: AxisUnit::Mm, ..
            }) => Err(AxisConfigError::Mismatch {
                key: "rotary.unit".to_owned(),
                reason: "a rotary axis cannot be in mm".to_owned(),
                hint: "use rad or deg".to_owned(),
            }),
            Transmission::Rotary(rotary) => {
                positive("gear", rotary.gear).map_err(|e| e.within("rotary"))
            }
        }
    }

    /// Unit of the axis' positions.
    pub const fn unit(&self) -> AxisUnit {
        match self {
            Transmission::Linear(_) => AxisUnit::Mm,
            Transmission::Rotary(rotary) => rotary.unit,
        }
    }

    /// Motor angle in rad for one axis unit.
    pub fn motor_rad_per_unit(&self) -> f64 {
        match self {
            Transmission::Linear(linear) => TAU * linear.gear / linear.lead_mm,
            Transmission::Rotary(Rotary {
                gear,
                unit: AxisUnit::Deg,
            }) => gear * (TAU / 360.0),
            Transmission::Rotary(rotary) => rotary.gear,
        }
    }

    /// Radius of the drive in m per motor rad (linear), or table rad per motor rad (rotary): the
    /// factor that reflects forces and torques at the load to the motor.
    pub fn load_per_motor_rad(&self) -> f64 {
        match self {
            Transmission::Linear(linear) => linear.lead_mm * 1e-3 / (TAU * linear.gear),
            Transmission::Rotary(rotary) => 1.0 / rotary.gear,
        }
    }
}
