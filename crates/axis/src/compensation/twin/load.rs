//! The load as a compensator knows it.

use crate::config::AxisConfig;
use serde::{Deserialize, Serialize};

/// The load behind the shaft, motor side.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct LoadModel {
    pub(crate) inertia: f64,
    pub(crate) viscous: f64,
    pub(crate) coulomb: f64,
    pub(crate) constant: f64,
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
}

impl LoadModel {
    /// Torque that it needs to move so, N m; the constant torque alone, within the friction, moves
    /// nothing.
    pub(crate) fn need(&self, speed: f64, acceleration: f64, standing: f64) -> f64 {
        let sliding = if speed.abs() > standing {
            self.coulomb * speed.signum()
        } else {
            0.0
        };
        self.inertia * acceleration + self.viscous * speed + sliding + self.constant
    }

    /// The load as the description has it.
    pub(crate) fn told(config: &AxisConfig) -> LoadModel {
        let load = config.reflected_load();
        LoadModel {
            inertia: load.inertia_kgm2,
            viscous: load.viscous_nm_s_per_rad,
            coulomb: load.coulomb_nm,
            constant: load.constant_nm,
            stiffness: load.stiffness_nm_per_rad,
            damping: load.damping_nm_s_per_rad,
        }
    }
}
