//! Equations of motion of one mode.
//!
//! With penetration `p = theta_b - s b` (s the flank's sign, 0 in the gap), u the voltage, sigma
//! the signs of sliding:
//! ```text
//! L di/dt    = u - R i - K_e w_M
//! dp/dt      = w_M - w_L
//! J_M dw_M/dt = K_t i - b_v w_M - T_c - sigma_M F_M        (0 if the motor is stuck)
//! J_L dw_L/dt = T_c - b_L w_L - sigma_L F_L - T_ext        (0 if the load is stuck)
//! T_c        = 0 | k p + d (w_M - w_L) | 2 k p
//! ```
//! While a mass creeps (Stribeck), its F is the breakaway friction and its b less by
//! `(F_s - F_c)/v_s`.

use super::mode::{Coupling, Mass, Mode};
use super::params::PlantParams;

/// Current, penetration, motor speed, load speed.
pub(super) type Vector = [f64; 4];
pub(super) const CURRENT: usize = 0;
pub(super) const PENETRATION: usize = 1;
pub(super) const MOTOR: usize = 2;
pub(super) const LOAD: usize = 3;

/// What drives the plant over a step: everything that is held.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Held {
    /// Voltage in q with the cross-coupling taken off, V.
    pub(super) voltage: f64,
    /// Torque against the load, N m.
    pub(super) load_torque: f64,
}

impl PlantParams {
    /// Stiffness and damping of a coupling.
    #[inline]
    pub(super) fn shaft(&self, coupling: Coupling) -> (f64, f64) {
        match coupling {
            Coupling::Free => (0.0, 0.0),
            Coupling::Spring => (self.stiffness_nm_per_rad, self.damping_nm_s_per_rad),
            Coupling::Doubled => (2.0 * self.stiffness_nm_per_rad, 0.0),
        }
    }

    /// Contact torque of a mode, N m.
    #[inline]
    pub(super) fn contact_torque(&self, mode: Mode, x: &Vector) -> f64 {
        let (k, d) = self.shaft(mode.contact.coupling());
        k * x[PENETRATION] + d * (x[MOTOR] - x[LOAD])
    }

    /// The homogeneous part of the derivative.
    pub(super) fn linear(&self, mode: Mode, x: &Vector) -> Vector {
        let torque = self.contact_torque(mode, x);
        let motor = self.torque_constant_nm_per_a * x[CURRENT]
            - self.viscous(Mass::Motor, mode.motor) * x[MOTOR]
            - torque;
        let load = torque - self.viscous(Mass::Load, mode.load) * x[LOAD];
        [
            (-self.resistance_ohm * x[CURRENT] - self.back_emf_v_s_per_rad * x[MOTOR])
                / self.inductance_h,
            x[MOTOR] - x[LOAD],
            if mode.motor.stuck() {
                0.0
            } else {
                motor / self.motor_inertia_kgm2
            },
            if mode.load.stuck() {
                0.0
            } else {
                load / self.load_inertia_kgm2
            },
        ]
    }

    /// The held part of the derivative.
    pub(super) fn forcing(&self, mode: Mode, held: &Held) -> Vector {
        let motor = self.sliding_torque(Mass::Motor, mode.motor);
        let load = self.sliding_torque(Mass::Load, mode.load) + held.load_torque;
        [
            held.voltage / self.inductance_h,
            0.0,
            if mode.motor.stuck() {
                0.0
            } else {
                -motor / self.motor_inertia_kgm2
            },
            if mode.load.stuck() {
                0.0
            } else {
                -load / self.load_inertia_kgm2
            },
        ]
    }

    /// Torque on the motor that its Coulomb friction has to balance, N m.
    #[inline]
    pub(super) fn motor_need(&self, mode: Mode, x: &Vector) -> f64 {
        self.torque_constant_nm_per_a * x[CURRENT] - self.contact_torque(mode, x)
    }

    /// Torque on the load that its Coulomb friction has to balance, N m.
    #[inline]
    pub(super) fn load_need(&self, mode: Mode, x: &Vector, held: &Held) -> f64 {
        self.contact_torque(mode, x) - held.load_torque
    }
}
