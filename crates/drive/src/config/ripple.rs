//! A motor whose torque is not even.

use super::check::{AxisConfigError, between};
use serde::{Deserialize, Serialize};

/// Harmonics of one kind that an axis may have.
pub const MAX_HARMONICS: usize = 4;

/// One harmonic over the motor's turn: `amplitude sin(per_turn theta_M + phase)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Harmonic {
    /// Amplitude: N m for cogging (up to 100), parts of the torque constant for ripple (up to 0.2).
    pub amplitude: f64,
    /// Periods for one mechanical turn of the motor, 1 to 1000. Cogging has multiples of the least
    /// common multiple of slots and poles, ripple mostly 6 and 12 for each pole pair.
    pub per_turn: u32,
    /// Phase, degrees.
    #[serde(default)]
    pub phase_deg: f64,
}

/// Torque that depends on the motor's angle. In a file: a table `ripple`; left out, there is none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ripple {
    /// Torque without current, N m (magnets against slots); at most four harmonics.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cogging: Vec<Harmonic>,
    /// Relative change of the torque constant, and with it of the back-EMF; at most four harmonics.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub torque: Vec<Harmonic>,
}

impl Ripple {
    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        self.cogging.is_empty() && self.torque.is_empty()
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn check(&self) -> Result<(), AxisConfigError> {
        for (key, list, highest) in [
            ("cogging", &self.cogging, 100.0),
            ("torque", &self.torque, 0.2),
        ] {
            between(
                &format!("{key}: number of harmonics"),
                list.len() as f64,
                0.0,
                MAX_HARMONICS as f64,
            )?;
            for (index, harmonic) in list.iter().enumerate() {
                harmonic
                    .check(highest)
                    .map_err(|e| e.within(&format!("{key}[{index}]")))?;
            }
        }
        Ok(())
    }
}

impl Harmonic {
    fn check(&self, highest: f64) -> Result<(), AxisConfigError> {
        between("amplitude", self.amplitude, 0.0, highest)?;
        between("per_turn", f64::from(self.per_turn), 1.0, 1000.0)?;
        between("phase_deg", self.phase_deg, -360.0, 360.0)
    }
}
