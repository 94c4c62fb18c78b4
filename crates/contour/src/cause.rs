//! Causes of a contour error, and its decomposition.

use lostmotion_base::{AxisId, Tick};
use serde::{Deserialize, Serialize};

use crate::{ContourSample, ReversalState};

/// The cause of a contour error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind", content = "axis")]
pub enum Cause {
    /// Lost motion, friction or wind-up after a reversal of an axis.
    Reversal(AxisId),
    /// Lost motion away from any reversal: the load drifts or changes sides in the gap.
    Gap,
    /// The command itself leaves the programmed path: a corner or joint blended within G64 P.
    Blend,
    /// Servo error near a corner or a step of curvature.
    Corner,
    /// Servo error elsewhere: following error that differs between axes, finite bandwidth,
    /// friction.
    #[default]
    ServoLag,
}

impl std::fmt::Display for Cause {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Cause::Reversal(axis) => write!(f, "reversal of {axis}"),
            Cause::Gap => f.write_str("gap"),
            Cause::Blend => f.write_str("blending"),
            Cause::Corner => f.write_str("corner"),
            Cause::ServoLag => f.write_str("servo lag"),
        }
    }
}

/// Decomposition of a signed contour error, mm. The sum is the error itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Shares {
    /// Contour error of the command itself.
    pub command_mm: f64,
    /// Added to it by the machine without a gap.
    pub servo_mm: f64,
    /// Added to that by the gap.
    pub backlash_mm: f64,
}

impl Shares {
    /// From the signed contour errors of the command, of the machine without a gap, and of the
    /// machine, at the same tick.
    pub fn of(command_mm: f64, without_gap_mm: f64, actual_mm: f64) -> Shares {
        // Differences of neighbours: the parts add up to the actual error.
        Shares {
            command_mm,
            servo_mm: without_gap_mm - command_mm,
            backlash_mm: actual_mm - without_gap_mm,
        }
    }

    /// The error itself, mm.
    pub fn total_mm(&self) -> f64 {
        self.command_mm + self.servo_mm + self.backlash_mm
    }
}

/// How a cause is found: the largest share by magnitude names it (on a tie backlash before servo
/// before command).
///
/// Backlash or servo: the axis that reversed last, if it did within the window, for friction and
/// wind-up change their sign there as the gap does. Else backlash: the gap alone; servo: a corner
/// if one is near the foot point, else lag. Command: blending.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CauseRule {
    /// How long after a reversal an error is attributed to it, ticks of the caller's clock.
    pub reversal_window_ticks: Tick,
}

impl CauseRule {
    /// The cause of a sample's error.
    pub fn cause(
        &self,
        shares: &Shares,
        sample: &ContourSample,
        reversals: &ReversalState,
    ) -> Cause {
        let (command, servo, backlash) = (
            shares.command_mm.abs(),
            shares.servo_mm.abs(),
            shares.backlash_mm.abs(),
        );
        // Only a command share above both others is blending: ties go to the machine.
        if command > servo && command > backlash {
            return Cause::Blend;
        }
        // Gap, friction and wind-up all act after a reversal: it is the cause whichever of the two
        // shares is larger.
        match reversals.latest(sample.tick, self.reversal_window_ticks) {
            Some(axis) => Cause::Reversal(axis),
            None if backlash >= servo => Cause::Gap,
            None if sample.near_corner => Cause::Corner,
            None => Cause::ServoLag,
        }
    }
}
