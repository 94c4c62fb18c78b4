//! Cutting with a spindle that stands still.

use super::moves::{Leg, in_machine, is_lathe};
use super::{Check, LintFindings, is_feed, rules};
use lostmotion_base::span::BlockRef;
use lostmotion_gcode::ops::CanonicalOp;
use lostmotion_gcode::program::Event;

/// What is known about the spindle so far.
#[derive(Debug, Default)]
pub(super) struct Spindles {
    /// The program has started a spindle.
    started: bool,
    /// Cuts made with a standing spindle before that, the first of a run of them.
    cuts: Vec<BlockRef>,
    /// The last feed below Z0 was with a standing spindle.
    off: bool,
    speed: bool,
}

/// Most runs of such cuts that are remembered.
const MOST: usize = 20;

impl Spindles {
    fn cut(&mut self, place: BlockRef) {
        if !self.off && self.cuts.len() < MOST {
            self.cuts.push(place);
        }
        self.off = true;
    }
}

impl Check for Spindles {
    fn block(&mut self, event: &Event<'_>, legs: &[Leg<'_>], found: &mut LintFindings) {
        self.speed |= event.after.spindle.speed > 0.0;
        if event
            .ops
            .iter()
            .any(|sourced| matches!(sourced.op, CanonicalOp::StartSpindle { .. }))
        {
            if !self.speed {
                let hint = "put S on this line or before it";
                found.add(
                    &rules::SPINDLE_NO_SPEED,
                    event.place,
                    "the spindle is started before any S".to_owned(),
                    &[],
                    hint,
                );
            }
            (self.started, self.speed, self.off) = (true, true, false);
        }
        let turns =
            event.after.spindle.clockwise.is_some() || event.before.spindle.clockwise.is_some();
        if turns {
            self.off = false;
        } else if !in_machine(event)
            && !is_lathe(event.after)
            && legs.iter().any(|leg| is_feed(leg.op) && leg.end[2] < 0.0)
        {
            self.cut(event.place);
        }
    }

    fn end(&mut self, _: BlockRef, found: &mut LintFindings) {
        if self.started {
            for place in &self.cuts {
                let message = "a feed below Z0 while the spindle stands still".to_owned();
                found.add(
                    &rules::SPINDLE_OFF,
                    *place,
                    message,
                    &[],
                    "start it with M3 S; M6 and M5 have stopped it, or it comes later",
                );
            }
        } else if let Some(first) = self.cuts.first() {
            let message =
                "the first feed below Z0 of a program that never starts the spindle".to_owned();
            found.add(
                &rules::SPINDLE_NEVER_STARTED,
                *first,
                message,
                &[],
                "add M3 S",
            );
        }
    }
}
