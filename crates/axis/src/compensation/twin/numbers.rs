//! What the twin's equations compute with: products and quotients that stay over a servo period.

use super::LoadModel;
use crate::config::AxisConfig;

/// What the motor's equations compute with, over a period `h` of the current loop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotorNumbers {
    /// `h/L` and `1/(1 + R h/L)`.
    pub(crate) current_share: f64,
    pub(crate) current_keep: f64,
    pub(crate) back_emf: f64,
    pub(crate) torque_constant: f64,
    pub(crate) viscous: f64,
    pub(crate) coulomb: f64,
    /// `1/J_M`, `h/J_M`, what friction takes of the speed in a period, and the torque for it:
    /// `J_M/h`.
    pub(crate) inverse_motor: f64,
    pub(crate) motor_step: f64,
    pub(crate) motor_most: f64,
    pub(crate) friction_scale: f64,
}

/// What the load's equations compute with, as long as the load stays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rates {
    pub(crate) load_constant: f64,
    pub(crate) load_viscous: f64,
    pub(crate) load_coulomb: f64,
    pub(crate) inverse_load: f64,
    pub(crate) load_step: f64,
    pub(crate) load_most: f64,
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
    pub(crate) give: f64,
}

impl MotorNumbers {
    pub(super) fn new(config: &AxisConfig, inertia: f64, h: f64) -> MotorNumbers {
        let motor = &config.motor;
        let share = h / motor.phase_inductance_h();
        MotorNumbers {
            current_share: share,
            current_keep: 1.0 / (1.0 + share * motor.phase_resistance_ohm()),
            back_emf: motor.back_emf_v_s_per_rad(),
            torque_constant: motor.torque_constant_nm_per_a,
            viscous: motor.viscous_nm_s_per_rad,
            coulomb: motor.coulomb_nm,
            inverse_motor: 1.0 / inertia,
            motor_step: h / inertia,
            motor_most: h / inertia * motor.coulomb_nm,
            friction_scale: inertia / h,
        }
    }
}

impl Rates {
    #[inline]
    pub(super) fn new(load: &LoadModel, h: f64) -> Rates {
        let inverse = 1.0 / load.inertia;
        Rates {
            load_constant: load.constant,
            load_viscous: load.viscous,
            load_coulomb: load.coulomb,
            inverse_load: inverse,
            load_step: h * inverse,
            load_most: h * inverse * load.coulomb,
            stiffness: load.stiffness,
            damping: load.damping,
            give: h * h * load.stiffness + h * load.damping,
        }
    }
}
