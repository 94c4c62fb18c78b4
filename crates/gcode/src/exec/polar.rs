//! Polar coordinates: @ is the distance from the origin of the XY plane, ^ the angle in degrees
//! from X.

use super::Exec;
use crate::ops::{Plane, Position};
use crate::problem::Problem;
use lostmotion_base::math;
use lostmotion_base::units::{deg, rad};

impl Exec<'_> {
    /// Puts @ and ^ into a position. What is missing is taken from where the tool is; incremental
    /// ones are added to that.
    pub(crate) fn polar(&self, end: &mut Position) -> Result<(), Problem> {
        let (radius, angle) = (self.word(b'@'), self.word(b'^'));
        if radius.is_none() && angle.is_none() {
            return Ok(());
        }
        if let Some(letter) = ['X', 'Y']
            .into_iter()
            .find(|letter| self.words.has(*letter as u8))
        {
            return Err(Problem::Polar {
                message: "and X or Y",
                letter,
            });
        }
        // A plane that is selected on the line itself is in force for it; XY is meant all the same
        // (as recorded).
        if self.state.plane != Plane::Xy && !self.words.has_g(180) && !self.words.has_g(190) {
            return Err(Problem::Polar {
                message: "outside the XY plane (G17)",
                letter: '@',
            });
        }
        if self.words.has_g(530) {
            return Err(Problem::Polar {
                message: "with G53",
                letter: '@',
            });
        }
        let [x, y, ..] = self.state.current;
        let here = [math::hypot(x, y), deg(math::atan2(y, x))];
        let [radius, angle] = if self.state.absolute {
            [radius.unwrap_or(here[0]), angle.unwrap_or(here[1])]
        } else if here[0] == 0.0 {
            return Err(Problem::Polar {
                message: "in incremental distances (G91) at the origin, where there is no angle,",
                letter: '^',
            });
        } else {
            [
                here[0] + radius.unwrap_or(0.0),
                here[1] + angle.unwrap_or(0.0),
            ]
        };
        let (sin, cos) = math::sin_cos(rad(angle));
        (end[0], end[1]) = (radius * cos, radius * sin);
        Ok(())
    }
}
