//! A total gap as a method is told it.

use super::check::{AxisConfigError, not_negative};
use super::table::ARCSEC_PER_DEG;
use super::transmission::{AxisUnit, Transmission};
use serde::{Deserialize, Serialize};

/// A total gap in the unit that suits whoever tells it: `{ um = 10.0 }`, `{ mdeg = 3.0 }`,
/// `{ arcsec = 11.0 }`, `{ deg = 0.003 }` or `{ motor_rad = 0.2 }`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Gap {
    /// Micrometre at the slide.
    Um(f64),
    /// Millidegree at the table.
    Mdeg(f64),
    /// Second of arc at the table.
    Arcsec(f64),
    /// Degree at the table.
    Deg(f64),
    /// Radian at the motor's shaft.
    MotorRad(f64),
}

impl Gap {
    /// Checks the value and that the unit suits the axis.
    ///
    /// # Errors
    /// A negative or non-finite gap, micrometres on a rotary axis, an angle on a linear one.
    pub fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        let linear = transmission.unit() == AxisUnit::Mm;
        let (key, value, fits) = match *self {
            Gap::Um(value) => ("um", value, linear),
            Gap::Mdeg(value) => ("mdeg", value, !linear),
            Gap::Arcsec(value) => ("arcsec", value, !linear),
            Gap::Deg(value) => ("deg", value, !linear),
            Gap::MotorRad(value) => ("motor_rad", value, true),
        };
        if !fits {
            return Err(AxisConfigError::Mismatch {
                key: key.to_owned(),
                reason: format!("the axis is in {}", transmission.unit().symbol()),
                hint: "give the gap as um on a linear axis, arcsec, mdeg or deg on a rotary one, or motor_rad".to_owned(),
            });
        }
        not_negative(key, value)
    }

    /// The gap in rad at the motor's shaft.
    pub fn motor_rad(&self, transmission: &Transmission) -> f64 {
        let ratio = transmission.load_per_motor_rad();
        match *self {
            Gap::Um(um) => um * 1e-6 / ratio,
            Gap::Mdeg(mdeg) => (mdeg * 1e-3).to_radians() / ratio,
            Gap::Arcsec(arcsec) => (arcsec / ARCSEC_PER_DEG).to_radians() / ratio,
            Gap::Deg(deg) => deg.to_radians() / ratio,
            Gap::MotorRad(rad) => rad,
        }
    }
}
