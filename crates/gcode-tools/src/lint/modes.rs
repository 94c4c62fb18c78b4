//! Modes that are relied on and were never set.

use super::moves::{Leg, in_cycle, in_machine, sets};
use super::rules::{self, LintRule};
use super::{Check, LintFindings, is_feed};
use lostmotion_gcode::codes::Group;
use lostmotion_gcode::ops::CanonicalOp;
use lostmotion_gcode::program::Event;

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
        for (group, settled) in GROUPS.into_iter().zip(&mut self.settled) {
            *settled |= sets(event, group);
        }
        if legs.is_empty() {
            return;
        }
        self.need(0, &rules::UNSET_UNITS, event, found);
        self.need(1, &rules::UNSET_DISTANCE, event, found);
        if in_cycle(event)
            || legs
                .iter()
                .any(|leg| matches!(leg.op, CanonicalOp::ArcFeed(_)))
        {
            self.need(2, &rules::UNSET_PLANE, event, found);
        }
        if legs.iter().any(|leg| is_feed(leg.op)) {
            self.need(3, &rules::UNSET_FEED_MODE, event, found);
        }
        if !in_machine(event) {
            self.need(4, &rules::UNSET_WORK_OFFSET, event, found);
        }
    }
}
