//! What the plant carries from step to step.

use super::dynamics::Vector;
use super::mode::{Contact, Mass, Mode, Side};
use super::params::PlantParams;
use crate::config::ContactLaw;
use crate::signal::Engagement;
use serde::{Deserialize, Serialize};

/// Rounds in which a load and what depends on its place are found together. Flanks are nowhere
/// steeper than 1:10, so each adds a digit; a choice for gravity.
const SETTLING_ROUNDS: u32 = 40;

/// What a plant begins with besides its place, at the motor's shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlantStart {
    /// Speed of the motor, rad/s.
    pub motor_velocity: f64,
    /// Speed of the load, rad/s.
    pub load_velocity: f64,
    /// Wind-up of the shaft past the flank on the side of its sign, rad; `None` as at rest.
    pub wind_up: Option<f64>,
    /// Whether no current flows.
    pub drive_off: bool,
}

/// State of the plant, at the motor's shaft.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlantState {
    /// Torque-forming current i_q, A.
    pub current_q: f64,
    /// Gap angle theta_M - theta_L, rad.
    pub gap_angle: f64,
    /// Motor speed, rad/s.
    pub motor_velocity: f64,
    /// Load speed, rad/s.
    pub load_velocity: f64,
    /// Load position, rad.
    pub load_position: f64,
    /// Field-forming current i_d, A. Apart from i_q: each has a step of its own, and two numbers
    /// that were written one by one are waited for where they are read as a pair.
    pub current_d: f64,
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
        let rounds = if params.is_curved() {
            SETTLING_ROUNDS
        } else {
            1
        };
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

    /// Moving and wound up from here on, the motor where it stands.
    #[must_use]
    pub fn set_going(mut self, params: &PlantParams, start: &PlantStart) -> PlantState {
        let motor_position = self.motor_position();
        (self.motor_velocity, self.load_velocity) = (start.motor_velocity, start.load_velocity);
        if let Some(wind_up) = start.wind_up {
            self.wind(params, motor_position, wind_up);
        }
        self.mode.contact = params.contact_at(&self);
        self.mode.motor = params.moving(Mass::Motor, self.motor_velocity);
        self.mode.load = params.moving(Mass::Load, self.load_velocity);
        if start.drive_off {
            (self.current_q, self.current_d) = (0.0, 0.0);
        }
        self
    }

    /// Winds the shaft up past the flank on the side of the sign; without a wind-up a load in its
    /// gap stays where it is, one on a flank just touches it.
    fn wind(&mut self, params: &PlantParams, motor_position: f64, wind_up: f64) {
        let side = match self.mode.contact {
            Contact::Gap if wind_up == 0.0 => return,
            _ if wind_up != 0.0 => Side::of(wind_up),
            contact => Side::of(contact.sign()),
        };
        let has_gap = params.half_gap_rad > 0.0;
        self.mode.contact = if has_gap {
            Contact::Spring(side)
        } else {
            Contact::Rigid
        };
        // wear depends on where the load is, which is off the motor by what it does
        for _ in 0..SETTLING_ROUNDS {
            self.gap_angle =
                params.flank_at(self.mode.contact.sign(), self.load_position) + wind_up;
            self.load_position = motor_position - self.gap_angle;
        }
    }

    /// Motor position, rad.
    #[inline]
    pub fn motor_position(&self) -> f64 {
        self.load_position + self.gap_angle
    }

    /// Which flank is in contact.
    #[inline]
    pub fn engagement(&self) -> Engagement {
        self.mode.contact.engagement(self.gap_angle)
    }

    #[inline]
    pub(super) fn vector(&self, offset: f64) -> Vector {
        let penetration = self.gap_angle - offset;
        [
            self.current_q,
            penetration,
            self.motor_velocity,
            self.load_velocity,
        ]
    }

    #[inline]
    pub(super) fn store(&mut self, offset: f64, x: &Vector, travel: f64) {
        self.current_q = x[0];
        self.gap_angle = x[1] + offset;
        self.motor_velocity = x[2];
        self.load_velocity = x[3];
        self.load_position += travel;
    }
}

impl PlantParams {
    /// How far a state is past the flank of its contact, rad, how fast that grows, rad/s, and by how
    /// much the load's lever is longer on an inclined flank: see `expansion`.
    fn penetration(&self, state: &PlantState) -> [f64; 3] {
        let (sign, place) = (state.mode.contact.sign(), state.load_position);
        let slope = self.curved.wear.map_or(0.0, |wear| wear.slope(place));
        let lever = 1.0 + (self.gap_middle + sign) * self.half_gap_rad * slope;
        let closing = state.motor_velocity - state.load_velocity * lever;
        [state.gap_angle - self.flank_at(sign, place), closing, lever]
    }

    /// Torques of the contact, N m: against the motor, and on the load.
    #[inline]
    pub(super) fn contact_torques(&self, state: &PlantState) -> [f64; 2] {
        let [depth, closing, lever] = self.penetration(state);
        let (k, d) = self.shaft(state.mode.contact.coupling());
        let torque = k * depth + d * closing;
        [torque, torque * lever]
    }

    /// The contact of a state whose speeds may have been told: on a flank, what the law makes of
    /// spring and damper there.
    pub(super) fn contact_at(&self, state: &PlantState) -> Contact {
        let side = match state.mode.contact {
            contact @ (Contact::Rigid | Contact::Gap) => return contact,
            Contact::Spring(side) | Contact::Doubled(side) | Contact::Lifted(side) => side,
        };
        let [depth, closing, _] = self.penetration(state);
        let spring = side.sign() * self.stiffness_nm_per_rad * depth;
        let damper = side.sign() * self.damping_nm_s_per_rad * closing;
        match self.contact {
            ContactLaw::Clamped | ContactLaw::Bounded if spring + damper < 0.0 => {
                Contact::Lifted(side)
            }
            ContactLaw::Bounded if damper > spring => Contact::Doubled(side),
            _ => Contact::Spring(side),
        }
    }
}
