//! What the plant carries from step to step.

use super::dynamics::Vector;
use super::mode::{Contact, Friction, Mode, Side};
use super::params::PlantParams;
use crate::signal::Engagement;
use serde::{Deserialize, Serialize};

/// State of the plant, at the motor's shaft.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlantState {
    /// Torque-forming current i_q, A.
    pub current_q: f64,
    /// Field-forming current i_d, A.
    pub current_d: f64,
    /// Gap angle theta_M - theta_L, rad.
    pub gap_angle: f64,
    /// Motor speed, rad/s.
    pub motor_velocity: f64,
    /// Load speed, rad/s.
    pub load_velocity: f64,
    /// Load position, rad.
    pub load_position: f64,
    /// Contact and friction.
    pub mode: Mode,
    /// Number of events (contacts made or broken, stops, breakaways) so far.
    pub events: u64,
}

impl PlantState {
    /// Standing still with the motor at a position; `gap_fraction` from -1 (negative flank) to 1 says where in the gap.
    ///
    /// A constant load torque that the load's friction cannot hold is carried by the flank it presses on, with the shaft
    /// wound up and the current that holds it.
    pub fn at_rest(params: &PlantParams, motor_position: f64, gap_fraction: f64) -> PlantState {
        let b = params.half_gap_rad;
        let torque = params.load_constant_nm;
        let hangs = torque.abs() > params.load_coulomb_nm;
        let held = if hangs { torque } else { 0.0 };
        let wind_up = held / params.stiffness_nm_per_rad;
        let side = Side::of(if hangs { torque } else { gap_fraction });
        let touches = b > 0.0 && (hangs || gap_fraction.abs() >= 1.0);
        let gap_angle = if hangs { side.sign() * b + wind_up } else { gap_fraction * b };
        let contact = match (b > 0.0, touches) {
            (false, _) => Contact::Rigid,
            (true, false) => Contact::Gap,
            (true, true) => Contact::Spring(side),
        };
        let friction = |limit: f64| if limit > 0.0 { Friction::Stuck } else { Friction::None };
        PlantState {
            current_q: held / params.torque_constant_nm_per_a,
            current_d: 0.0,
            gap_angle,
            motor_velocity: 0.0,
            load_velocity: 0.0,
            load_position: motor_position - gap_angle,
            mode: Mode { contact, motor: friction(params.motor_coulomb_nm), load: friction(params.load_coulomb_nm) },
            events: 0,
        }
    }

    /// Motor position, rad.
    #[inline]
    pub fn motor_position(&self) -> f64 {
        self.load_position + self.gap_angle
    }

    /// Which flank is in contact.
    pub fn engagement(&self) -> Engagement {
        self.mode.contact.engagement(self.gap_angle)
    }

    #[inline]
    pub(super) fn vector(&self, params: &PlantParams) -> Vector {
        let penetration = self.gap_angle - self.mode.contact.sign() * params.half_gap_rad;
        [self.current_q, penetration, self.motor_velocity, self.load_velocity]
    }

    #[inline]
    pub(super) fn store(&mut self, params: &PlantParams, x: &Vector, travel: f64) {
        self.current_q = x[0];
        self.gap_angle = x[1] + self.mode.contact.sign() * params.half_gap_rad;
        self.motor_velocity = x[2];
        self.load_velocity = x[3];
        self.load_position += travel;
    }
}
