//! What Coulomb friction does at low speed.

use super::check::{AxisConfigError, between, positive};
use super::transmission::Transmission;
use serde::{Deserialize, Serialize};

/// More friction at rest than in motion, falling in a straight line up to a speed.
///
/// `F(v) = F_c + (F_s - F_c) max(0, 1 - |v|/v_s)` while it slides; at rest it holds up to `F_s`. In
/// a file: `friction.load.stribeck = { static_factor = 1.5, speed_units_s = 2.0 }`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stribeck {
    /// Breakaway over Coulomb friction, F_s/F_c; 1 to 10.
    pub static_factor: f64,
    /// Speed v_s from which Coulomb friction alone is left: axis units per s at the load, rad/s at
    /// the motor; above 0.
    pub speed_units_s: f64,
}

/// Bristles that bend before they slip: the model of Canudas de Wit, Olsson, Astrom, Lischinsky, *A
/// New Model for Control of Systems with Friction* (IEEE Trans. Automatic Control 40(3), 1995).
///
/// ```text
/// dz/dt = v - s0 |v| z / g(v),  F = s0 z + s1 dz/dt,  g(v) = F_c + (F_s - F_c) exp(-(v/v_s)^2),  s0 = F_c / presliding
/// ```
/// Viscous friction comes on top. There is no true stick: what stands under a torque creeps by
/// bending bristles alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lugre {
    /// Breakaway over Coulomb friction, F_s/F_c; 1 to 10.
    pub static_factor: f64,
    /// Stribeck speed v_s: axis units per s at the load, rad/s at the motor; above 0.
    pub speed_units_s: f64,
    /// Deflection at which the bristles carry the Coulomb friction, F_c/s0: axis units at the load,
    /// rad at the motor; above 0.
    pub presliding_units: f64,
    /// Damping of the bristles over their stiffness, s1/s0, s; 0 to 1.
    #[serde(default)]
    pub damping_s: f64,
}

/// Law of a Coulomb friction, whose size stands with the load or the motor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FrictionLaw {
    /// The same at every speed, and at rest up to it: true stick.
    #[default]
    Coulomb,
    /// More at rest, true stick.
    Stribeck(Stribeck),
    /// Bristles.
    Lugre(Lugre),
}

/// Laws of both Coulomb frictions. In a file: a table `friction`; left out, both are plain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Frictions {
    /// At the motor.
    #[serde(default)]
    pub motor: FrictionLaw,
    /// At the load.
    #[serde(default)]
    pub load: FrictionLaw,
}

impl Frictions {
    /// Whether both are plain.
    pub fn is_plain(&self) -> bool {
        *self
            == Frictions {
                motor: FrictionLaw::Coulomb,
                load: FrictionLaw::Coulomb,
            }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn check(&self) -> Result<(), AxisConfigError> {
        self.motor.check().map_err(|e| e.within("motor"))?;
        self.load.check().map_err(|e| e.within("load"))
    }

    /// The law at the load with its speeds and ways at the motor's shaft.
    pub(crate) fn load_at_motor(&self, transmission: &Transmission) -> FrictionLaw {
        // speeds and ways scale with the transmission; the static factor has no dimension
        let factor = transmission.motor_rad_per_unit();
        match self.load {
            FrictionLaw::Coulomb => FrictionLaw::Coulomb,
            FrictionLaw::Stribeck(law) => FrictionLaw::Stribeck(Stribeck {
                speed_units_s: law.speed_units_s * factor,
                ..law
            }),
            FrictionLaw::Lugre(law) => FrictionLaw::Lugre(Lugre {
                speed_units_s: law.speed_units_s * factor,
                presliding_units: law.presliding_units * factor,
                ..law
            }),
        }
    }
}

impl FrictionLaw {
    fn check(&self) -> Result<(), AxisConfigError> {
        match self {
            FrictionLaw::Coulomb => Ok(()),
            FrictionLaw::Stribeck(law) => {
                let check = || {
                    between("static_factor", law.static_factor, 1.0, 10.0)
                        .and_then(|()| positive("speed_units_s", law.speed_units_s))
                };
                check().map_err(|e| e.within("stribeck"))
            }
            FrictionLaw::Lugre(law) => law.check().map_err(|e| e.within("lugre")),
        }
    }
}

impl Lugre {
    fn check(&self) -> Result<(), AxisConfigError> {
        between("static_factor", self.static_factor, 1.0, 10.0)?;
        positive("speed_units_s", self.speed_units_s)?;
        positive("presliding_units", self.presliding_units)?;
        between("damping_s", self.damping_s, 0.0, 1.0)
    }
}
