//! Units that change after the program has moved.

use super::moves::Leg;
use super::{Check, LintFindings, rules};
use lostmotion_gcode::ops::Units;
use lostmotion_gcode::program::Event;

/// Whether the program has moved.
#[derive(Debug, Default)]
pub(super) struct UnitChanges {
    moved: bool,
}

impl Check for UnitChanges {
    fn block(&mut self, event: &Event<'_>, legs: &[Leg<'_>], found: &mut LintFindings) {
        if self.moved && event.before.units != event.after.units {
            let name = |units| {
                if units == Units::Inch {
                    "inches (G20)"
                } else {
                    "millimetres (G21)"
                }
            };
            let message = format!(
                "from {} to {} after the program has moved",
                name(event.before.units),
                name(event.after.units)
            );
            found.add(
                &rules::UNITS_CHANGED,
                event.place,
                message,
                &[],
                "the feed, cycle words and parameters keep their numbers",
            );
        }
        self.moved |= !legs.is_empty();
    }
}
