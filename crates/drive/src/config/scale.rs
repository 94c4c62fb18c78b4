//! The load's own scale or encoder, for methods that have one.

use super::check::{AxisConfigError, between, finite, positive};
use serde::{Deserialize, Serialize};

/// A periodic error of a scale: `amplitude sin(2 pi x/period + phase)` is added to what it reads.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScaleError {
    /// Amplitude, in the axis' unit; 0 or above, and so small that the scale still counts forwards:
    /// 2 pi amplitude below half the period.
    pub amplitude_units: f64,
    /// Period, in the axis' unit; above 0. Short for interpolation errors of the signal period,
    /// long for the grating's.
    pub period_units: f64,
    /// Phase, degrees; -360 to 360.
    #[serde(default)]
    pub phase_deg: f64,
}

/// What a scale reads besides its step, which stands with the load (`scale_um`). In a file: a table
/// `scale`; left out, its counts lie about position 0 and it has no error.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scale {
    /// Position of the index pulse, in the axis' unit: whole counts are from there, so it says
    /// where between two counts position 0 lies.
    #[serde(default)]
    pub index_units: f64,
    /// Error that grows along the scale (a lead or temperature error), um for each m or urad for
    /// each rad; -1000 to 1000. None at the index.
    #[serde(default)]
    pub slope_ppm: f64,
    /// Periodic errors, at most four.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<ScaleError>,
}

impl Scale {
    /// Whether it has its counts about 0 and no error.
    pub fn is_plain(&self) -> bool {
        *self
            == Scale {
                index_units: 0.0,
                slope_ppm: 0.0,
                errors: Vec::new(),
            }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn check(&self) -> Result<(), AxisConfigError> {
        finite("index_units", self.index_units)?;
        between("slope_ppm", self.slope_ppm, -1000.0, 1000.0)?;
        // four are what the plant's list of waves has room for
        between(
            "errors: number of errors",
            self.errors.len() as f64,
            0.0,
            4.0,
        )?;
        let check = |error: &ScaleError| {
            positive("period_units", error.period_units)?;
            // the slope of the error, 2 pi amplitude/period, is at most 1/2: the reading never runs
            // backwards
            between(
                "amplitude_units",
                error.amplitude_units,
                0.0,
                0.25 * error.period_units / std::f64::consts::PI,
            )?;
            between("phase_deg", error.phase_deg, -360.0, 360.0)
        };
        self.errors
            .iter()
            .enumerate()
            .try_for_each(|(index, error)| {
                check(error).map_err(|e| e.within(&format!("errors[{index}]")))
            })
    }
}
