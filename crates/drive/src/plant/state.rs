//! What the plant carries from step to step.

use super::dynamics::Vector;
use super::mode::{Contact, Mass, Mode, Side};
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
    /// Deflection of the bristles at motor and load, rad; 0 without bristles.
    #[serde(default)]
    pub bristles: [f64; 2],
}

impl PlantState {
    /// Standing still with the motor at a position; `gap_fraction` from -1 (negative flank) to 1
    /// says where in the gap.
    ///
    /// A constant load torque that the load's friction cannot hold is carried by the flank it
    /// presses on, with the shaft wound up and the current that holds it.
    pub fn at_rest(params: &PlantParams, motor_position: f64, gap_fraction: f64) -> PlantState {
        let mut state = PlantState {
            current_q: 0.0,
            current_d: 0.0,
            gap_angle: 0.0,
            motor_velocity: 0.0,
            load_velocity: 0.0,
            load_position: motor_position,
            mode: Mode {
                contact: Contact::Rigid,
                motor: params.resting(Mass::Motor),
                load: params.resting(Mass::Load),
            },
            events: 0,
            bristles: [0.0; 2],
        };
        // gravity and wear depend on where the load is, which is off the motor by what they do
        let rounds = if params.is_curved() { 40 } else { 1 };
        for _ in 0..rounds {
            state.settle(params, motor_position, gap_fraction);
        }
        state
    }

    /// Puts a load that stands about where it stands onto the flank that carries it.
    fn settle(&mut self, params: &PlantParams, motor_position: f64, gap_fraction: f64) {
        // a torque beyond the friction hangs on the shaft, and winds it up
        let gravity = params.curved.gravity.at(self.load_position);
        let torque = params.load_constant_nm + gravity;
        let hangs = torque.abs() > params.breakaway(Mass::Load);
        let held = if hangs { torque } else { 0.0 };
        let wind_up = held / params.stiffness_nm_per_rad;
        let side = Side::of(if hangs { torque } else { gap_fraction });
        let has_gap = params.half_gap_rad > 0.0;
        self.mode.contact = match (has_gap, hangs || gap_fraction.abs() >= 1.0) {
            (false, _) => Contact::Rigid,
            (true, false) => Contact::Gap,
            (true, true) => Contact::Spring(side),
        };
        // on that flank, or where in the gap the caller says
        let part = if hangs { side.sign() } else { gap_fraction };
        self.gap_angle = params.flank_at(part, self.load_position) + wind_up;
        self.load_position = motor_position - self.gap_angle;
        // the current that holds the load and the cogging
        let cogging = params.curved.cogging.at(motor_position);
        let constant =
            params.torque_constant_nm_per_a * (1.0 + params.curved.ripple.at(motor_position));
        self.current_q = (held + cogging) / constant;
        // bristles carry a torque that hangs on friction alone
        if let (false, Some(bristles)) = (hangs, params.load_friction.bristles)
            && params.load_coulomb_nm > 0.0
        {
            self.bristles[1] = -torque * bristles.presliding_rad / params.load_coulomb_nm;
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
        let penetration = self.gap_angle - params.flank(self.mode.contact.sign());
        [
            self.current_q,
            penetration,
            self.motor_velocity,
            self.load_velocity,
        ]
    }

    #[inline]
    pub(super) fn store(&mut self, params: &PlantParams, x: &Vector, travel: f64) {
        self.current_q = x[0];
        self.gap_angle = x[1] + params.flank(self.mode.contact.sign());
        self.motor_velocity = x[2];
        self.load_velocity = x[3];
        self.load_position += travel;
    }
}
