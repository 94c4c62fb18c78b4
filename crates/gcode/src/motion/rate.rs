//! How fast moves are: feed rates with the units, the spindle and the axes that move.

use super::{Feed, MotionFold};
use crate::problem::Problem;
use crate::state::is_angle;
use lostmotion_base::Coords;
use lostmotion_base::units::rad;

impl MotionFold {
    /// What a rate is multiplied by: the spindle's speed if it is per revolution.
    fn per_minute(&self, code: &'static str) -> Result<f64, Problem> {
        match self.per_revolution {
            false => Ok(1.0),
            true if self.surface_speed => self.revolutions_are_known().map(|()| 0.0),
            true if self.spindle_on && self.spindle_speed > 0.0 => Ok(self.spindle_speed),
            true => Err(Problem::NoRevolutions { code }),
        }
    }

    /// At constant surface speed the spindle's speed changes along the move.
    pub(super) fn revolutions_are_known(&self) -> Result<(), Problem> {
        let what = "a feed per revolution at constant surface speed (G95 or G33 with G96)";
        if self.surface_speed {
            Err(Problem::NoMotionFor { what })
        } else {
            Ok(())
        }
    }

    pub(super) fn feed(&self, end: &Coords, code: &'static str) -> Result<Feed, Problem> {
        if let Some(pitch_mm) = self.pitch_mm {
            self.revolutions_are_known()?;
            return match self.spindle_on && self.spindle_speed > 0.0 && pitch_mm != 0.0 {
                true => Ok(Feed::MmPerMin(pitch_mm.abs() * self.spindle_speed)),
                false => Err(Problem::NoRevolutions { code: "G33" }),
            };
        }
        let per_minute = self.per_minute(code)?;
        let moves = |index: usize| end.0[index] != self.at.0[index];
        let linear = (0..9).any(|index| !is_angle(index) && moves(index));
        let turns = (3..6).any(moves);
        Ok(if linear || !turns {
            Feed::MmPerMin(self.rate_mm * per_minute)
        } else {
            Feed::RadPerMin(rad(self.rate_deg * per_minute))
        })
    }

    pub(super) fn arc_feed(&self) -> Result<Feed, Problem> {
        Ok(Feed::MmPerMin(self.rate_mm * self.per_minute("G2 or G3")?))
    }
}
