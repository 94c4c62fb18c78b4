//! A rotary table as a load.

use super::check::{AxisConfigError, between, finite, not_negative, positive};
use super::load::Reflected;
use serde::{Deserialize, Serialize};

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
