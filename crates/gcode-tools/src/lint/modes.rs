//! Modes that are relied on and were never set, and units that change after the program has moved.

use super::Check;
use super::moves::{Leg, in_cycle, in_machine, is_feed, sets};
use super::rules::{Lint, LintFindings, LintRule, rule};
use lostmotion_gcode::codes::Group;
use lostmotion_gcode::ops::{CanonicalOp, Units};
use lostmotion_gcode::program::Event;

/// Modes that were never set.
pub(super) const UNSET: Lint = Lint {
    rules: &[
        &UNSET_UNITS,
        &UNSET_DISTANCE,
        &UNSET_PLANE,
        &UNSET_FEED_MODE,
        &UNSET_WORK_OFFSET,
    ],
    check: || Box::new(Modes::default()),
};

static UNSET_UNITS: LintRule = rule(
    "unset-units",
    "The program moves before it has said G20 or G21.",
    "It runs in whatever units the control was left in. Put G21 or G20 into the first lines.",
);

static UNSET_DISTANCE: LintRule = rule(
    "unset-distance",
    "The program moves before it has said G90 or G91.",
    "After a program that was stopped in G91 it cuts something else. Put G90 into the first lines.",
);

static UNSET_PLANE: LintRule = rule(
    "unset-plane",
    "An arc or cycle before G17, G18 or G19.",
    "In another plane the arc is refused, or is another one. Put G17 into the first lines.",
);

static UNSET_FEED_MODE: LintRule = rule(
    "unset-feed-mode",
    "A feed move before G93, G94 or G95.",
    "In a control left in G95 every feed is per revolution. Put G94 into the first lines.",
);

static UNSET_WORK_OFFSET: LintRule = rule(
    "unset-work-offset",
    "The program moves before it has selected a work coordinate system.",
    "It runs in the one that was used last. Put G54 into the first lines.",
);

const GROUPS: [Group; 5] = [
    Group::Units,
    Group::Distance,
    Group::Plane,
    Group::FeedMode,
    Group::CoordinateSystem,
];

/// Which of the modes have been set, or reported.
#[derive(Debug, Default)]
pub(super) struct Modes {
    settled: [bool; GROUPS.len()],
}

impl Modes {
    fn need(
        &mut self,
        group: usize,
        rule: &'static LintRule,
        event: &Event<'_>,
        found: &mut LintFindings,
    ) {
        if let Some(settled) = self.settled.get_mut(group).filter(|settled| !**settled) {
            *settled = true;
            let what = GROUPS.get(group).map_or("mode", |group| group.name());
            found.add(
                rule,
                event.place,
                format!("this block moves, and nothing has set the {what} before it"),
                &[],
                rule.advice,
            );
        }
    }
}

impl Check for Modes {
    fn block(&mut self, event: &Event<'_>, legs: &[Leg<'_>], found: &mut LintFindings) {
        // A code on the same line counts: it is in force before the motion.
        for (group, settled) in GROUPS.into_iter().zip(&mut self.settled) {
            *settled |= sets(event, group);
        }
        if legs.is_empty() {
            return;
        }
        self.need(0, &UNSET_UNITS, event, found);
        self.need(1, &UNSET_DISTANCE, event, found);
        // The plane matters to arcs and cycles only, the feed mode to moves at feed.
        if in_cycle(event)
            || legs
                .iter()
                .any(|leg| matches!(leg.op, CanonicalOp::ArcFeed(_)))
        {
            self.need(2, &UNSET_PLANE, event, found);
        }
        if legs.iter().any(|leg| is_feed(leg.op)) {
            self.need(3, &UNSET_FEED_MODE, event, found);
        }
        // G53, G28 and G30 do not use the work coordinate system.
        if !in_machine(event) {
            self.need(4, &UNSET_WORK_OFFSET, event, found);
        }
    }
}

/// Units that change after a move.
pub(super) const UNITS: Lint = Lint {
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
