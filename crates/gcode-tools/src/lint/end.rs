//! What a program leaves behind.

use super::Check;
use super::moves::{Leg, has_g};
use super::rules::{Lint, LintFindings, LintRule, rule};
use lostmotion_base::span::BlockRef;
use lostmotion_gcode::ops::CanonicalOp;
use lostmotion_gcode::program::Event;

/// The lints of this file.
pub(super) const LINTS: Lint = Lint {
    rules: &[
        &COMPENSATION_LEFT_ON,
        &SPINDLE_LEFT_ON,
        &COOLANT_LEFT_ON,
        &OFFSET_LEFT_ON,
    ],
    check: || Box::new(End::default()),
};

static COMPENSATION_LEFT_ON: LintRule = rule(
    "compensation-left-on",
    "The program ends under cutter compensation.",
    "End it with G40 on a straight move off the work.",
);

static SPINDLE_LEFT_ON: LintRule = rule(
    "spindle-left-on",
    "The program ends without M2 or M30 while the spindle turns.",
    "Add M5, or end with M2 or M30.",
);

static COOLANT_LEFT_ON: LintRule = rule(
    "coolant-left-on",
    "The program ends without M2 or M30 while the coolant is on.",
    "Add M9, or end with M2 or M30.",
);

static OFFSET_LEFT_ON: LintRule = rule(
    "offset-left-on",
    "The program ends with an offset of G92 or G52 in force.",
    "It shifts the next program. Put G92.1 before the end.",
);

/// What is in force after the last block.
#[derive(Debug, Default)]
pub(super) struct End {
    /// Where cutter compensation was switched on, if it still is.
    compensation: Option<BlockRef>,
    spindle: Option<BlockRef>,
    coolant: Option<BlockRef>,
    offset: Option<BlockRef>,
    regular: bool,
}

/// Remembers the block that switched something on until it is off.
fn keep(slot: &mut Option<BlockRef>, on: bool, place: BlockRef) {
    if on {
        slot.get_or_insert(place);
    } else {
        *slot = None;
    }
}

impl Check for End {
    fn block(&mut self, event: &Event<'_>, _: &[Leg<'_>], _: &mut LintFindings) {
        let state = event.after;
        // An offset left by an earlier program (G92.3) is not this one's: it counts once set here.
        let offset_set = has_g(event, 920) || has_g(event, 520) || self.offset.is_some();
        keep(
            &mut self.offset,
            offset_set && state.offsets.g92 != [0.0; 9],
            event.place,
        );
        // M2 and M30 stop spindle and coolant themselves; only what they leave in force is looked
        // at.
        if event
            .ops
            .iter()
            .any(|sourced| sourced.op == CanonicalOp::ProgramEnd)
        {
            self.regular = true;
            if has_g(event, 400) {
                self.compensation = None;
            }
            return;
        }
        keep(&mut self.compensation, event.compensates, event.place);
        keep(
            &mut self.spindle,
            state.spindle.clockwise.is_some(),
            event.place,
        );
        keep(&mut self.coolant, state.flood || state.mist, event.place);
    }

    fn end(&mut self, last: BlockRef, found: &mut LintFindings) {
        let from = |place: BlockRef| format!("of line {}", place.span.line);
        if let Some(place) = self.compensation {
            let message = format!(
                "the program ends under the cutter compensation {}",
                from(place)
            );
            found.add(
                &COMPENSATION_LEFT_ON,
                last,
                message,
                &[],
                "put G40 on a straight move off the work",
            );
        }
        if let Some(place) = self.offset {
            let message = format!("the program ends with the offset {} in force", from(place));
            found.add(
                &OFFSET_LEFT_ON,
                last,
                message,
                &[],
                "put G92.1 before the end",
            );
        }
        // What follows holds only for programs that end without M2 and M30.
        if self.regular {
            return;
        }
        if let Some(place) = self.spindle {
            let message = format!(
                "the program ends without M2 or M30, and the spindle {} turns on",
                from(place)
            );
            found.add(&SPINDLE_LEFT_ON, last, message, &[], "add M5 and M2");
        }
        if let Some(place) = self.coolant {
            let message = format!(
                "the program ends without M2 or M30, and the coolant {} stays on",
                from(place)
            );
            found.add(&COOLANT_LEFT_ON, last, message, &[], "add M9 and M2");
        }
    }
}
