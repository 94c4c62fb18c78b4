//! Gravity on a load that turns: a robot's joint, an unbalanced table.

use super::check::{AxisConfigError, between};
use super::transmission::Transmission;
use serde::{Deserialize, Serialize};

/// Torque `torque_nm sin(angle - hangs_at)` against the positive direction. In a file: a table
/// `gravity`; needs a rotary transmission.
///
/// Gravity on a slide is the constant force of `load.slide`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gravity {
    /// Mass times g times the distance of its centre from the axis, N m at the load; 0 to 1e6.
    pub torque_nm: f64,
    /// Angle of the joint at which the load hangs straight down, degrees; -360 to 360.
    #[serde(default)]
    pub hangs_at_deg: f64,
}

impl Gravity {
    /// Checks every value, and that the axis is a rotary one.
    ///
    /// # Errors
    /// The first value out of range, or a linear transmission.
    pub fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        if let Transmission::Linear(_) = transmission {
            return Err(AxisConfigError::Mismatch {
                key: "gravity".to_owned(),
                reason: "gravity that turns needs a rotary transmission".to_owned(),
                hint: "on a slide gravity is the constant_n of load.slide".to_owned(),
            });
        }
        let check = || {
            between("torque_nm", self.torque_nm, 0.0, 1e6)
                .and_then(|()| between("hangs_at_deg", self.hangs_at_deg, -360.0, 360.0))
        };
        check().map_err(|e| e.within("gravity"))
    }
}
