//! Where the reference spline takes velocity and acceleration from.

use serde::{Deserialize, Serialize};

/// How 1 ms setpoints become 250 us references.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ReferenceSource {
    /// Velocity and acceleration come along with each position: delay 1 ms.
    #[default]
    SentAlong,
    /// Positions only: velocity and acceleration are five-point differences, delay 3 ms.
    Differences,
}
