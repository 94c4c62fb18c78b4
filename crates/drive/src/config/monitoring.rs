//! Limits that a control watches while an axis moves: past one of them the machine stops.

use super::check::{AxisConfigError, between, not_negative, positive};
use serde::{Deserialize, Serialize};

/// The largest limit of a position that is read, in the axis' unit: beyond any travel.
const LARGEST_UNITS: f64 = 1e6;
/// The largest continuous current that is read, A: beyond any drive's.
const LARGEST_CURRENT_A: f64 = 1e6;

/// What is watched while the axis moves. In a file: a table `monitoring`. A limit that is left out
/// follows from the axis itself, and 0 switches it off.
///
/// The following error, commanded minus measured position of the motor, may be
/// `max(standstill_error, following_error v/v_max)` at the commanded speed `v`, as in LinuxCNC
/// (`FERROR`, `MIN_FERROR`). The current is watched by a motor that warms up with its square from 0
/// at the start, `heat' = ((i/continuous_current)^2 - heat)/overload_time`; it is overloaded above
/// 1.
///
/// A drive that is at its limits for long follows its command no more: a loop that swings, or an
/// axis that is blocked.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Monitoring {
    /// Largest following error at the axis' largest speed, in the axis' unit; 0 switches it off. At
    /// lower speeds it is less in proportion, but not below `standstill_error_units`. If left out,
    /// from gains and limits of the axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub following_error_units: Option<f64>,
    /// Largest following error at rest, in the axis' unit; above 0. If left out,
    /// `following_error_units` where that is told, else from gains and limits of the axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standstill_error_units: Option<f64>,
    /// How far the motor may be beyond the travel, in the axis' unit; 0 switches it off. If left
    /// out, from gains and limits of the axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub overtravel_units: Option<f64>,
    /// Current that the motor bears without end, A (amplitude of i_q); 0 switches the overload off.
    /// If left out, the current of its rated torque.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub continuous_current_a: Option<f64>,
    /// Time constant of the motor's warming up, s; above 0. Twice the continuous current is borne
    /// for 0.29 times as long.
    #[serde(default = "overload_time_s")]
    pub overload_time_s: f64,
    /// Longest time that the drive may be at its current or voltage limit without a break, s; 0
    /// switches it off.
    #[serde(default = "at_limit_s")]
    pub at_limit_s: f64,
}

/// A motor of 2.7 times its rated torque bears it for 2.9 s with this; drives allow their peak
/// current for 1 to 5 s.
fn overload_time_s() -> f64 {
    20.0
}

/// A choice: no acceleration of the embedded machines takes as long.
fn at_limit_s() -> f64 {
    1.0
}

impl Default for Monitoring {
    fn default() -> Monitoring {
        Monitoring {
            following_error_units: None,
            standstill_error_units: None,
            overtravel_units: None,
            continuous_current_a: None,
            overload_time_s: overload_time_s(),
            at_limit_s: at_limit_s(),
        }
    }
}

impl Monitoring {
    /// Nothing is watched.
    pub const OFF: Monitoring = Monitoring {
        following_error_units: Some(0.0),
        standstill_error_units: None,
        overtravel_units: Some(0.0),
        continuous_current_a: Some(0.0),
        overload_time_s: 20.0,
        at_limit_s: 0.0,
    };

    /// Whether everything follows from the axis.
    pub fn is_usual(&self) -> bool {
        *self == Monitoring::default()
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn check(&self) -> Result<(), AxisConfigError> {
        for (key, told, largest) in [
            (
                "following_error_units",
                self.following_error_units,
                LARGEST_UNITS,
            ),
            ("overtravel_units", self.overtravel_units, LARGEST_UNITS),
            (
                "continuous_current_a",
                self.continuous_current_a,
                LARGEST_CURRENT_A,
            ),
        ] {
            told.map_or(Ok(()), |value| between(key, value, 0.0, largest))?;
        }
        if let Some(standstill) = self.standstill_error_units {
            positive("standstill_error_units", standstill)?;
        }
        positive("overload_time_s", self.overload_time_s)?;
        not_negative("at_limit_s", self.at_limit_s)
    }
}
