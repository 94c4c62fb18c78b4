//! What the motor moves, and the shaft with its gap between them.

use super::check::{AxisConfigError, between, finite, not_negative, positive};
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
        // a slide's data are per metre, a table's per radian; only `reflected` suits both
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
        // power is the same on both sides: forces scale with the ratio, impedances with its square
        let squared = m_per_rad * m_per_rad;
        Reflected {
            inertia_kgm2: self.mass_kg * squared,
            // the screw turns by 1/gear of the motor
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

// A rotary table as a load.

/// Seconds of arc in a degree.
pub(super) const ARCSEC_PER_DEG: f64 = 3600.0;

/// A rotary table behind a gear, in units at the table. Needs a rotary transmission.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "TableFile")]
pub struct Table {
    /// Inertia of the table and what lies on it, kg m2.
    pub inertia_kgm2: f64,
    /// Inertia of the gear's driving side (worm, pinion, coupling) at the motor's shaft, kg m2.
    pub gear_inertia_kgm2: f64,
    /// Viscous friction, N m s/rad.
    pub viscous_nm_s_per_rad: f64,
    /// Coulomb friction, N m.
    pub coulomb_nm: f64,
    /// Constant torque against the positive direction, N m.
    pub constant_nm: f64,
    /// Torsional stiffness of the gear, N m/rad.
    pub stiffness_nm_per_rad: f64,
    /// Torsional damping, N m s/rad.
    pub damping_nm_s_per_rad: f64,
    /// Total gap between the flanks at the table, mdeg. A file may say `gap_arcsec` or `gap_deg`
    /// instead.
    pub gap_mdeg: f64,
    /// Step of the table's encoder, mdeg; 0 for an ideal one.
    pub scale_mdeg: f64,
}

/// A table as a file has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TableFile {
    inertia_kgm2: f64,
    #[serde(default)]
    gear_inertia_kgm2: f64,
    #[serde(default)]
    viscous_nm_s_per_rad: f64,
    #[serde(default)]
    coulomb_nm: f64,
    #[serde(default)]
    constant_nm: f64,
    stiffness_nm_per_rad: f64,
    damping_nm_s_per_rad: f64,
    gap_mdeg: Option<f64>,
    gap_arcsec: Option<f64>,
    gap_deg: Option<f64>,
    #[serde(default)]
    scale_mdeg: f64,
}

impl TryFrom<TableFile> for Table {
    type Error = String;

    fn try_from(file: TableFile) -> Result<Table, String> {
        // one unit only: two values could contradict each other
        let gap_mdeg = match (file.gap_mdeg, file.gap_arcsec, file.gap_deg) {
            (Some(mdeg), None, None) => mdeg,
            (None, Some(arcsec), None) => arcsec * (1e3 / ARCSEC_PER_DEG),
            (None, None, Some(deg)) => deg * 1e3,
            (None, None, None) => {
                return Err("the gap of the table is missing; add one of `gap_mdeg`, `gap_arcsec` and `gap_deg`".to_owned());
            }
            _ => return Err("the gap is told more than once; keep one of `gap_mdeg`, `gap_arcsec` and `gap_deg`".to_owned()),
        };
        Ok(Table {
            inertia_kgm2: file.inertia_kgm2,
            gear_inertia_kgm2: file.gear_inertia_kgm2,
            viscous_nm_s_per_rad: file.viscous_nm_s_per_rad,
            coulomb_nm: file.coulomb_nm,
            constant_nm: file.constant_nm,
            stiffness_nm_per_rad: file.stiffness_nm_per_rad,
            damping_nm_s_per_rad: file.damping_nm_s_per_rad,
            gap_mdeg,
            scale_mdeg: file.scale_mdeg,
        })
    }
}

impl Table {
    pub(super) fn check(&self) -> Result<(), AxisConfigError> {
        positive("inertia_kgm2", self.inertia_kgm2)?;
        not_negative("gear_inertia_kgm2", self.gear_inertia_kgm2)?;
        not_negative("viscous_nm_s_per_rad", self.viscous_nm_s_per_rad)?;
        not_negative("coulomb_nm", self.coulomb_nm)?;
        finite("constant_nm", self.constant_nm)?;
        positive("stiffness_nm_per_rad", self.stiffness_nm_per_rad)?;
        not_negative("damping_nm_s_per_rad", self.damping_nm_s_per_rad)?;
        between("gap_mdeg", self.gap_mdeg, 0.0, 1e5)?;
        not_negative("scale_mdeg", self.scale_mdeg)
    }

    pub(super) fn reflected(&self, table_per_motor: f64) -> Reflected {
        // power is the same on both sides: torques scale with the ratio, impedances with its square
        let squared = table_per_motor * table_per_motor;
        let motor_rad_per_mdeg = 1e-3_f64.to_radians() / table_per_motor;
        Reflected {
            inertia_kgm2: self.inertia_kgm2 * squared,
            motor_side_inertia_kgm2: self.gear_inertia_kgm2,
            viscous_nm_s_per_rad: self.viscous_nm_s_per_rad * squared,
            coulomb_nm: self.coulomb_nm * table_per_motor,
            constant_nm: self.constant_nm * table_per_motor,
            stiffness_nm_per_rad: self.stiffness_nm_per_rad * squared,
            damping_nm_s_per_rad: self.damping_nm_s_per_rad * squared,
            gap_rad: self.gap_mdeg * motor_rad_per_mdeg,
            scale_rad: self.scale_mdeg * motor_rad_per_mdeg,
        }
    }
}

// Gravity on a load that turns: a robot's joint, an unbalanced table.

/// Torque `torque_nm sin(angle - hangs_at)` against the positive direction. In a file: a table
/// `gravity`; needs a rotary transmission.
///
/// Gravity on a slide is the constant force of `load.slide`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gravity {
    /// Mass times g times the distance of its centre from the axis, N m at the load; 0 to 1e6.
    pub torque_nm: f64,
    /// Angle of the joint at which the load hangs straight down, degrees; -360 to 360.
    #[serde(default)]
    pub hangs_at_deg: f64,
}

impl Gravity {
    /// Checks every value, and that the axis is a rotary one.
    ///
    /// # Errors
    /// The first value out of range, or a linear transmission.
    pub fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        if let Transmission::Linear(_) = transmission {
            return Err(AxisConfigError::Mismatch {
                key: "gravity".to_owned(),
                reason: "gravity that turns needs a rotary transmission".to_owned(),
                hint: "on a slide gravity is the constant_n of load.slide".to_owned(),
            });
        }
        let check = || {
            between("torque_nm", self.torque_nm, 0.0, 1e6)
                .and_then(|()| between("hangs_at_deg", self.hangs_at_deg, -360.0, 360.0))
        };
        check().map_err(|e| e.within("gravity"))
    }
}
