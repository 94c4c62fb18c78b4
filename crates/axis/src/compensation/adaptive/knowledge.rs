//! What is known of a number of which readings come one after the other: a scalar Kalman filter with a gate.
//!
//! The number may drift: between readings its variance grows. A reading far beside what is known is left out; two in a row that agree with each other
//! start over from them.

use serde::{Deserialize, Serialize};

/// Drift from reading to reading, part of the value.
const DRIFT: f64 = 0.004;
/// Standard deviation that no reading undercuts, part of the value.
const LEAST: f64 = 0.01;
/// Readings farther than so many standard deviations are left out.
const GATE: f64 = 3.0;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Knowledge {
    pub(super) value: f64,
    pub(super) variance: f64,
    pub(super) readings: u32,
    stray: Option<(f64, f64)>,
}

impl Knowledge {
    pub(super) fn take(&mut self, value: f64, variance: f64) {
        let variance = variance + LEAST * LEAST * value * value;
        if self.readings == 0 {
            *self = Knowledge { value, variance, readings: 1, stray: None };
            return;
        }
        self.variance += DRIFT * DRIFT * self.value * self.value;
        let off = value - self.value;
        if off * off > GATE * GATE * (self.variance + variance) {
            match self.stray {
                Some((before, its)) if (value - before) * (value - before) < GATE * GATE * (its + variance) => {
                    *self = Knowledge { value: 0.5 * (value + before), variance: 0.5 * (variance + its), readings: 2, stray: None };
                }
                _ => self.stray = Some((value, variance)),
            }
            return;
        }
        self.stray = None;
        let gain = self.variance / (self.variance + variance);
        self.value += gain * off;
        self.variance *= 1.0 - gain;
        self.readings = self.readings.saturating_add(1);
    }

    /// Standard deviation over value.
    pub(super) fn doubt(&self) -> f64 {
        if self.readings == 0 || self.value <= 0.0 { f64::INFINITY } else { self.variance.sqrt() / self.value }
    }
}
