//! The load's scale or encoder.

use super::curved::{Wave, Waves};
use crate::config::AxisConfig;
use std::f64::consts::TAU;

/// A scale with its step, the place of its index pulse and its errors, at the motor's shaft.
///
/// It reads `index + step round((x + e(x) - index)/step)`, e the error: whole counts from the index
/// pulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadScale {
    step_rad: f64,
    index_rad: f64,
    slope: f64,
    errors: Waves,
}

impl LoadScale {
    /// That of an axis.
    pub fn new<C>(config: &AxisConfig<C>) -> LoadScale {
        let (scale, factor) = (&config.scale, config.transmission.motor_rad_per_unit());
        let errors = scale.errors.iter().map(|error| Wave {
            amplitude: error.amplitude_units * factor,
            per_rad: TAU / (error.period_units * factor),
            phase_rad: error.phase_deg * (TAU / 360.0),
        });
        LoadScale {
            step_rad: config.reflected_load().scale_rad,
            index_rad: scale.index_units * factor,
            slope: scale.slope_ppm * 1e-6,
            errors: Waves::new(errors),
        }
    }

    /// What it shows with the load at a position, rad.
    #[inline]
    pub fn read(&self, position: f64) -> f64 {
        let from_index = position - self.index_rad;
        let seen = from_index + self.slope * from_index + self.errors.at(position);
        if self.step_rad > 0.0 {
            (seen / self.step_rad).round() * self.step_rad + self.index_rad
        } else {
            seen + self.index_rad
        }
    }
}
