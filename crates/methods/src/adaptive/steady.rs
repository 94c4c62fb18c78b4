//! The motor's data, and the steady filter of its innovations.

use lostmotion_base::Clock;
use serde::{Deserialize, Serialize};

/// What is known of the motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Known {
    pub(super) torque_constant: f64,
    pub(super) inertia: f64,
    pub(super) viscous: f64,
    /// Standard deviation of a measured position, rad.
    pub(super) noise: f64,
    /// Standard deviation of the torque that nothing models, over a servo tick, N m.
    pub(super) unmodelled: f64,
}

/// Gains and variance of the steady filter for samples of a length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Filter {
    pub(super) ticks: u32,
    pub(super) span: f64,
    pub(super) alpha: f64,
    pub(super) beta: f64,
    pub(super) variance: f64,
}

impl Known {
    /// The filter for samples of so many ticks (tracking index of Kalata, 1984).
    pub(super) fn filter(&self, stride: u32) -> Filter {
        let span = f64::from(stride) * Clock::SERVO.period_s();
        let index =
            self.unmodelled / self.inertia * span * span / (f64::from(stride).sqrt() * self.noise);
        let r = 0.25 * (4.0 + index - (8.0 * index + index * index).sqrt());
        let alpha = 1.0 - r * r;
        let beta = 2.0 * (2.0 - alpha) - 4.0 * (1.0 - alpha).sqrt();
        Filter {
            ticks: stride,
            span,
            alpha,
            beta,
            variance: self.noise * self.noise / (1.0 - alpha),
        }
    }
}
