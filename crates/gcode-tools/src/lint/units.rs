//! Units that change after the program has moved.

use super::Check;
use super::moves::Leg;
use super::rules::{Lint, LintFindings, LintRule, rule};
use lostmotion_gcode::ops::Units;
use lostmotion_gcode::program::Event;

/// The lints of this file.
pub(super) const LINTS: Lint = Lint {
    rules: &[&UNITS_CHANGED],
    check: || Box::new(UnitChanges::default()),
};

static UNITS_CHANGED: LintRule = rule(
    "units-changed",
    "G20 or G21 changes the units after the program has moved.",
    "F, cycle words and parameters keep their numbers and mean something else. Change units only at the start.",
);

/// Whether the program has moved.
#[derive(Debug, Default)]
pub(super) struct UnitChanges {
    moved: bool,
}

impl Check for UnitChanges {
    fn block(&mut self, event: &Event<'_>, legs: &[Leg<'_>], found: &mut LintFindings) {
        // A change before the first move is the program's own choice of units.
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
                &UNITS_CHANGED,
                event.place,
                message,
                &[],
                "the feed, cycle words and parameters keep their numbers",
            );
        }
        self.moved |= !legs.is_empty();
    }
}
