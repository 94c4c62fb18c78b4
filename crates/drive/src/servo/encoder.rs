//! Position measured in whole counts.

use std::f64::consts::TAU;

/// An encoder: rounds to its nearest count, halves away from zero, so that it reads the same in
/// both directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoder {
    step_rad: f64,
}

impl Encoder {
    /// Reads the position itself.
    pub const IDEAL: Encoder = Encoder { step_rad: 0.0 };

    /// An encoder of so many counts for one turn of the motor.
    pub fn with_counts(counts_per_rev: u32) -> Encoder {
        Encoder {
            step_rad: TAU / f64::from(counts_per_rev),
        }
    }

    /// Its step, rad; 0 if it reads the position itself.
    pub(crate) fn step_rad(&self) -> f64 {
        self.step_rad
    }

    /// What it shows at a position, rad.
    #[inline]
    pub fn read(&self, position: f64) -> f64 {
        if self.step_rad > 0.0 {
            (position / self.step_rad).round() * self.step_rad
        } else {
            position
        }
    }
}
