//! The gap: where its flanks are, how they push on each other, and how a method is told of it.

use super::check::{AxisConfigError, between, finite, not_negative, positive};
use super::load::ARCSEC_PER_DEG;
use super::transmission::{AxisUnit, Transmission};
use serde::{Deserialize, Serialize};

/// A gap that is wider (or narrower) around one place of the travel than elsewhere.
///
/// The gap at load position x is `gap (1 + (factor - 1) exp(-((x - at_units)/width_units)^2))`, the
/// load's `gap_*` being the one far from there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wear {
    /// The gap at the worst place over the gap elsewhere; 0.1 to 100.
    pub factor: f64,
    /// The worst place, in the axis' unit.
    pub at_units: f64,
    /// Distance at which e^-1 of the wear is left, in the axis' unit; above 0, and so wide that the
    /// flanks are nowhere steeper than 1:10.
    pub width_units: f64,
}

/// Flanks that are not even or not about the middle. In a file: a table `flanks`; left out,
/// positions count from the middle of an even gap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Flanks {
    /// Where the middle of the gap is, in parts of half the gap: motor less load there. 0:
    /// positions count from the middle; -1: the load is where the command says as long as the motor
    /// pushes it in the positive direction, and lags the whole gap behind when it pulls it back; 1:
    /// the other way round. -1 to 1.
    #[serde(default)]
    pub middle: f64,
    /// Wear.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wear: Option<Wear>,
}

impl Flanks {
    /// Whether the gap is even and positions count from its middle.
    pub fn is_plain(&self) -> bool {
        *self
            == Flanks {
                middle: 0.0,
                wear: None,
            }
    }

    /// Checks every value; `gap` is the total gap in the axis' unit.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn check(&self, gap: f64) -> Result<(), AxisConfigError> {
        between("middle", self.middle, -1.0, 1.0)?;
        let Some(wear) = self.wear else { return Ok(()) };
        let check = || {
            between("factor", wear.factor, 0.1, 100.0)?;
            finite("at_units", wear.at_units)?;
            positive("width_units", wear.width_units)?;
            // a flank is 0.5 gap (1 + |middle|), and exp(-u^2) nowhere steeper than sqrt(2/e) =
            // 0.858
            let slope = 0.5 * gap * (1.0 + self.middle.abs()) * (wear.factor - 1.0).abs() * 0.858
                / wear.width_units;
            between("width_units: slope of the flanks", slope, 0.0, 0.1)
        };
        check().map_err(|e| e.within("wear"))
    }
}

// How the flanks push on each other.

/// Law of the contact torque at penetration p of a flank with closing speed v (stiffness k, damping
/// d).
///
/// Published models differ, and bounce differently. With a gap of zero both flanks touch at once
/// and the shaft is the plain spring and damper, whichever law is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ContactLaw {
    /// `k p + d v` as long as p > 0: pulls while the flanks separate fast.
    #[default]
    Linear,
    /// `max(0, k p + d v)`: never pulls.
    Clamped,
    /// `k p + clamp(d v, -k p, k p)`: never pulls, and no jump of torque when the flanks meet (the
    /// bounded damping of the Modelica Standard Library's elasto-backlash).
    Bounded,
}

/// Where in its gap the axis stands at the start, as the motor's lead over the load: -1 on the
/// negative flank, 0 in the middle, 1 on the positive flank.
///
/// The motor stands at the start position; the load is off it by this part of half the gap.
/// Positions therefore count from the middle of the gap. If the constant load torque is more than
/// the friction can hold, the axis starts on the flank that carries it, wound up, with the servo
/// already holding it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct StartInGap(pub f64);

// A total gap as a method is told it.

/// A total gap in one of several units: `{ um = 10.0 }`, `{ mdeg = 3.0 }`,
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
        // only `motor_rad` suits both kinds of axis
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

    /// The same gap times a factor.
    #[must_use]
    pub fn times(self, factor: f64) -> Gap {
        match self {
            Gap::Um(value) => Gap::Um(value * factor),
            Gap::Mdeg(value) => Gap::Mdeg(value * factor),
            Gap::Arcsec(value) => Gap::Arcsec(value * factor),
            Gap::Deg(value) => Gap::Deg(value * factor),
            Gap::MotorRad(value) => Gap::MotorRad(value * factor),
        }
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
