//! Causes of a contour error, and its decomposition.

use lostmotion_base::vec::{Vec3, add, along, cross, dot, norm, scale, sub};
use lostmotion_base::{AxisId, Tick};
use serde::{Deserialize, Serialize};

use crate::{ContourSample, ReversalState};

/// The cause of a contour error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

/// 1 + cosine of the angle between two directions of travel below which the path goes straight
/// back. A choice: within 0.08 degrees of it, where the axis of the turn is known no better.
const STRAIGHT_BACK_COSINE: f64 = 1e-6;

/// Decomposition of a signed contour error, mm.
///
/// Errors are vectors across the path, each from its own foot point: of the command, of the machine
/// without a gap, and of the machine. To be subtracted they are carried along the path to one foot
/// point, as its direction turns (a corner turns by its angle), so that an error which stays on its
/// side of the path stays the same vector. The first three shares are the parts of the three
/// differences along the error itself: they add up to it. A part across it makes the error neither
/// larger nor smaller, but can be all that a gap does; `backlash_size_mm` has it, too.
///
/// A vector across the path changes by at most the way that the tool goes, if it is carried along
/// so. What a gap does to the error is therefore at most how far it moves the tool.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Shares {
    /// Contour error of the command itself.
    pub command_mm: f64,
    /// Added to it by the machine without a gap.
    pub servo_mm: f64,
    /// Added to that by the gap.
    pub backlash_mm: f64,
    /// Length of the vector that the gap adds; at least the magnitude of `backlash_mm`.
    pub backlash_size_mm: f64,
}

impl Shares {
    /// From the contour errors of the command, of the machine without a gap, and of the machine, at
    /// the same tick.
    pub fn of(
        command: &ContourSample,
        without_gap: &ContourSample,
        actual: &ContourSample,
    ) -> Shares {
        let to_actual =
            |sample: &ContourSample| carried(sample.off_mm, sample.travel, actual.travel);
        let mut gap = sub(actual.off_mm, to_actual(without_gap));
        // Where a foot point jumps between places that are not neighbours on the path, as across a
        // slot, vectors say nothing about each other: no gap does more than it moves the tool.
        let (size, moved) = (norm(gap), norm(sub(actual.tip_mm, without_gap.tip_mm)));
        if size > moved {
            gap = scale(gap, moved / size);
        }
        let command = to_actual(command);
        let servo = sub(sub(actual.off_mm, gap), command);
        // Unit vector of the error, with its sign; on the path there is none, and no part.
        let direction = if actual.distance_mm > 0.0 {
            scale(actual.off_mm, 1.0 / actual.error_mm)
        } else {
            [0.0; 3]
        };
        Shares {
            command_mm: dot(command, direction),
            servo_mm: dot(servo, direction),
            backlash_mm: dot(gap, direction),
            backlash_size_mm: size.min(moved),
        }
    }

    /// The error itself, mm.
    pub fn total_mm(&self) -> f64 {
        self.command_mm + self.servo_mm + self.backlash_mm
    }
}

/// A vector across the path, carried from where its direction is `from` to where it is `to`: turned
/// by the least rotation between the two.
fn carried(vector: Vec3, from: Vec3, to: Vec3) -> Vec3 {
    // Within a straight stretch, as at most ticks: nothing turns.
    if from == to {
        return vector;
    }
    let (axis, cosine) = (cross(from, to), dot(from, to));
    // Straight back, or on a move that does not move the tip: the place is the same, and so is the
    // vector.
    if 1.0 + cosine < STRAIGHT_BACK_COSINE || from == [0.0; 3] || to == [0.0; 3] {
        return vector;
    }
    // Rodrigues' formula, with sin = |axis| and (1 - cos) / sin^2 = 1 / (1 + cos).
    let across = add(scale(vector, cosine), cross(axis, vector));
    along(across, axis, dot(axis, vector) / (1.0 + cosine))
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
