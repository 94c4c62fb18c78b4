//! Operations that move nothing and hold for those that follow.

use super::{MotionFold, coords};
use crate::ops::{CanonicalOp, PathControl, Units};
use crate::state::convert;

impl MotionFold {
    /// Takes an operation that sets something.
    pub(super) fn set(&mut self, op: &CanonicalOp) {
        match op {
            CanonicalOp::UseLengthUnits(units) => self.units = *units,
            CanonicalOp::SetG5xOffset { offset, .. } => {
                self.offsets.g5x = convert(offset, self.units, Units::Mm)
            }
            CanonicalOp::SetG92Offset(offset) => {
                self.offsets.g92 = convert(offset, self.units, Units::Mm)
            }
            CanonicalOp::SetTilt(tilt) => {
                self.offsets.tilt = tilt
                    .as_deref()
                    .map(|tilt| tilt.convert(self.units, Units::Mm))
            }
            CanonicalOp::SetXyRotation(degrees) => self.offsets.rotation_deg = *degrees,
            CanonicalOp::UseToolLengthOffset(offset) => {
                let tool = coords(&convert(offset, self.units, Units::Mm));
                // The spindle stays where it is.
                self.at = self.at + self.tool - tool;
                self.tool = tool;
            }
            CanonicalOp::SetFeedRate { rate, inverse_time } => {
                (self.rate_mm, self.rate_deg, self.inverse_time) =
                    (*rate * self.units.mm(), *rate, *inverse_time);
            }
            CanonicalOp::StartSpeedFeedSync(pitch) => {
                self.pitch_mm = Some(*pitch * self.units.mm())
            }
            CanonicalOp::StopSpeedFeedSync => self.pitch_mm = None,
            CanonicalOp::FeedOverride(on) => self.feed_override = *on,
            CanonicalOp::SetFeedMode { per_revolution } => self.per_revolution = *per_revolution,
            CanonicalOp::SetSpindleSpeed { spindle: 0, speed } => self.spindle_speed = *speed,
            CanonicalOp::SetSpindleMode {
                spindle: 0,
                highest,
            } => self.surface_speed = *highest > 0.0,
            CanonicalOp::StartSpindle { spindle: 0, .. } => self.spindle_on = true,
            CanonicalOp::StopSpindle { spindle: 0 } => self.spindle_on = false,
            CanonicalOp::SetMotionControlMode(PathControl::Continuous { tolerance }) => {
                self.control = PathControl::Continuous {
                    tolerance: *tolerance * self.units.mm(),
                };
            }
            CanonicalOp::SetMotionControlMode(control) => self.control = *control,
            CanonicalOp::SetNaiveCamTolerance(tolerance) => {
                self.merge = *tolerance * self.units.mm()
            }
            _ => {}
        }
    }
}
