//! The torque behind the motor, seen from the motor: a momentum observer.
//!
//! ```text
//! z' = K_t i - b_v w - F_M sign(w) - T        T = omega (z - J_M w)
//! ```
//! First-order low pass of the true shaft torque with corner omega; no derivative of a measured
//! speed comes in.

use lostmotion_base::Clock;
use serde::{Deserialize, Serialize};

/// Corner, rad/s: 30 Hz, above it the encoder's steps are louder than the load.
const CORNER_RAD_S: f64 = 190.0;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Disturbance {
    momentum: f64,
    /// Torque of the shaft on the load, N m.
    pub(super) torque: f64,
}

impl Disturbance {
    /// `drive`: motor torque less its friction, mean over the last tick (N m); `momentum`: `J_M w`
    /// (N m s).
    pub(super) fn step(&mut self, drive: f64, momentum: f64) {
        self.momentum += Clock::SERVO.period_s() * (drive - self.torque);
        self.torque = CORNER_RAD_S * (self.momentum - momentum);
    }
}
