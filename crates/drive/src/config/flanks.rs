//! Where the flanks of the gap are.

use super::check::{AxisConfigError, between, finite, positive};
use serde::{Deserialize, Serialize};

/// A gap that is wider (or narrower) around one place of the travel than elsewhere.
///
/// The gap at load position x is `gap (1 + (factor - 1) exp(-((x - at_units)/width_units)^2))`, the
/// load's `gap_*` being the one far from there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wear {
    /// The gap at the worst place over the gap elsewhere; 0.1 to 100.
    pub factor: f64,
    /// The worst place, in the axis' unit.
    pub at_units: f64,
    /// Distance at which e^-1 of the wear is left, in the axis' unit; above 0, and so wide that the
    /// flanks are nowhere steeper than 1:10.
    pub width_units: f64,
}

/// Flanks that are not even or not about the middle. In a file: a table `flanks`; left out,
/// positions count from the middle of an even gap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Flanks {
    /// Where the middle of the gap is, in parts of half the gap: motor less load there. 0:
    /// positions count from the middle; -1: the load is where the command says as long as the motor
    /// pushes it in the positive direction, and lags the whole gap behind when it pulls it back; 1:
    /// the other way round. -1 to 1.
    #[serde(default)]
    pub middle: f64,
    /// Wear.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wear: Option<Wear>,
}

impl Flanks {
    /// Whether the gap is even and positions count from its middle.
    pub fn is_plain(&self) -> bool {
        *self
            == Flanks {
                middle: 0.0,
                wear: None,
            }
    }

    /// Checks every value; `gap` is the total gap in the axis' unit.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn check(&self, gap: f64) -> Result<(), AxisConfigError> {
        between("middle", self.middle, -1.0, 1.0)?;
        let Some(wear) = self.wear else { return Ok(()) };
        let check = || {
            between("factor", wear.factor, 0.1, 100.0)?;
            finite("at_units", wear.at_units)?;
            positive("width_units", wear.width_units)?;
            // a flank is 0.5 gap (1 + |middle|), and exp(-u^2) nowhere steeper than sqrt(2/e) =
            // 0.858
            let slope = 0.5 * gap * (1.0 + self.middle.abs()) * (wear.factor - 1.0).abs() * 0.858
                / wear.width_units;
            between("width_units: slope of the flanks", slope, 0.0, 0.1)
        };
        check().map_err(|e| e.within("wear"))
    }
}
