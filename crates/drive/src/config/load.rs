//! What the motor moves, and the shaft with its gap between them.

use super::check::{AxisConfigError, between, finite, not_negative, positive};
use super::table::Table;
use super::transmission::Transmission;
use serde::{Deserialize, Serialize};

/// A slide on a ball screw, in the units of its data sheets. Needs a linear transmission.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Slide {
    /// Moving mass, kg.
    pub mass_kg: f64,
    /// Inertia of the screw and its coupling, kg m2. It turns with the motor: the gap and most of
    /// the give are in nut and bearings.
    #[serde(default)]
    pub screw_inertia_kgm2: f64,
    /// Viscous friction of the guides, N s/m.
    #[serde(default)]
    pub viscous_n_s_per_m: f64,
    /// Coulomb friction of the guides, N.
    #[serde(default)]
    pub coulomb_n: f64,
    /// Constant force against the positive direction, N (gravity on a vertical axis, net of its
    /// counterweight).
    #[serde(default)]
    pub constant_n: f64,
    /// Axial stiffness of screw, nut and bearings together, N/um.
    pub stiffness_n_per_um: f64,
    /// Axial damping, N s/mm.
    pub damping_n_s_per_mm: f64,
    /// Total gap between the flanks, um.
    pub gap_um: f64,
    /// Step of the linear scale, um; 0 for an ideal one.
    #[serde(default)]
    pub scale_um: f64,
}

/// A load already reflected to the motor's shaft: every angle is a motor angle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reflected {
    /// Inertia J_L, kg m2.
    pub inertia_kgm2: f64,
    /// Inertia on the motor's side of the gap besides the rotor (screw, coupling, pinion), kg m2.
    #[serde(default)]
    pub motor_side_inertia_kgm2: f64,
    /// Viscous friction b_L, N m s/rad.
    #[serde(default)]
    pub viscous_nm_s_per_rad: f64,
    /// Coulomb friction T_f, N m.
    #[serde(default)]
    pub coulomb_nm: f64,
    /// Constant torque against the positive direction, N m.
    #[serde(default)]
    pub constant_nm: f64,
    /// Stiffness of the shaft k_s, N m/rad.
    pub stiffness_nm_per_rad: f64,
    /// Damping of the shaft d, N m s/rad.
    pub damping_nm_s_per_rad: f64,
    /// Total gap 2b, rad.
    pub gap_rad: f64,
    /// Step of the load's encoder, rad; 0 for an ideal one.
    #[serde(default)]
    pub scale_rad: f64,
}

/// The load, in the units of whoever describes it.
///
/// In a file: a table `load.slide`, `load.table` or `load.reflected`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Load {
    /// A slide on a ball screw.
    Slide(Slide),
    /// A rotary table behind a gear.
    Table(Table),
    /// Everything at the motor's shaft.
    Reflected(Reflected),
}

impl Load {
    /// Checks every value, and that the transmission is of the right kind.
    ///
    /// # Errors
    /// The first value out of range, or a slide on a rotary transmission, or a table on a linear
    /// one.
    pub fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        match (self, transmission) {
            (Load::Slide(_), Transmission::Rotary(_)) => {
                return Err(mismatch("slide", "a slide needs a linear transmission"));
            }
            (Load::Table(_), Transmission::Linear(_)) => {
                return Err(mismatch("table", "a table needs a rotary transmission"));
            }
            _ => {}
        }
        match self {
            Load::Slide(slide) => slide.check().map_err(|e| e.within("slide")),
            Load::Table(table) => table.check().map_err(|e| e.within("table")),
            Load::Reflected(reflected) => reflected.check().map_err(|e| e.within("reflected")),
        }
    }

    /// The load as the motor's shaft sees it.
    pub fn reflected(&self, transmission: &Transmission) -> Reflected {
        let ratio = transmission.load_per_motor_rad();
        match *self {
            Load::Slide(slide) => slide.reflected(ratio, transmission),
            Load::Table(table) => table.reflected(ratio),
            Load::Reflected(reflected) => reflected,
        }
    }

    /// The same load with another total gap, given in rad at the motor's shaft.
    #[must_use]
    pub fn with_gap_motor_rad(mut self, gap_rad: f64, transmission: &Transmission) -> Load {
        let ratio = transmission.load_per_motor_rad();
        match &mut self {
            Load::Slide(slide) => slide.gap_um = gap_rad * ratio * 1e6,
            Load::Table(table) => table.gap_mdeg = gap_rad * ratio.to_degrees() * 1e3,
            Load::Reflected(reflected) => reflected.gap_rad = gap_rad,
        }
        self
    }
}

fn mismatch(key: &str, reason: &str) -> AxisConfigError {
    AxisConfigError::Mismatch {
        key: key.to_owned(),
        reason: reason.to_owned(),
        hint: "change the kind of load or of transmission, or describe the load as load.reflected"
            .to_owned(),
    }
}

impl Slide {
    fn check(&self) -> Result<(), AxisConfigError> {
        positive("mass_kg", self.mass_kg)?;
        not_negative("screw_inertia_kgm2", self.screw_inertia_kgm2)?;
        not_negative("viscous_n_s_per_m", self.viscous_n_s_per_m)?;
        not_negative("coulomb_n", self.coulomb_n)?;
        finite("constant_n", self.constant_n)?;
        positive("stiffness_n_per_um", self.stiffness_n_per_um)?;
        not_negative("damping_n_s_per_mm", self.damping_n_s_per_mm)?;
        between("gap_um", self.gap_um, 0.0, 1e5)?;
        not_negative("scale_um", self.scale_um)
    }

    fn reflected(&self, m_per_rad: f64, transmission: &Transmission) -> Reflected {
        let gear = match transmission {
            Transmission::Linear(linear) => linear.gear,
            Transmission::Rotary(rotary) => rotary.gear,
        };
        let squared = m_per_rad * m_per_rad;
        Reflected {
            inertia_kgm2: self.mass_kg * squared,
            motor_side_inertia_kgm2: self.screw_inertia_kgm2 / (gear * gear),
            viscous_nm_s_per_rad: self.viscous_n_s_per_m * squared,
            coulomb_nm: self.coulomb_n * m_per_rad,
            constant_nm: self.constant_n * m_per_rad,
            stiffness_nm_per_rad: self.stiffness_n_per_um * 1e6 * squared,
            damping_nm_s_per_rad: self.damping_n_s_per_mm * 1e3 * squared,
            gap_rad: self.gap_um * 1e-6 / m_per_rad,
            scale_rad: self.scale_um * 1e-6 / m_per_rad,
        }
    }
}

impl Reflected {
    /// Half gap b, rad at the motor's shaft.
    pub fn half_gap_rad(&self) -> f64 {
        0.5 * self.gap_rad
    }

    fn check(&self) -> Result<(), AxisConfigError> {
        positive("inertia_kgm2", self.inertia_kgm2)?;
        not_negative("motor_side_inertia_kgm2", self.motor_side_inertia_kgm2)?;
        not_negative("viscous_nm_s_per_rad", self.viscous_nm_s_per_rad)?;
        not_negative("coulomb_nm", self.coulomb_nm)?;
        finite("constant_nm", self.constant_nm)?;
        positive("stiffness_nm_per_rad", self.stiffness_nm_per_rad)?;
        not_negative("damping_nm_s_per_rad", self.damping_nm_s_per_rad)?;
        between("gap_rad", self.gap_rad, 0.0, 100.0)?;
        not_negative("scale_rad", self.scale_rad)
    }
}
