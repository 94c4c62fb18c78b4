//! Cutting with a spindle that stands still.

use super::Check;
use super::moves::{Leg, in_machine, is_feed, is_lathe};
use super::rules::{Lint, LintFindings, LintRule, rule};
use lostmotion_base::span::BlockRef;
use lostmotion_gcode::ops::CanonicalOp;
use lostmotion_gcode::program::Event;

/// The lints of this file.
pub(super) const LINTS: Lint = Lint {
    rules: &[&SPINDLE_OFF, &SPINDLE_NEVER_STARTED, &SPINDLE_NO_SPEED],
    check: || Box::new(Spindles::default()),
};

static SPINDLE_OFF: LintRule = rule(
    "spindle-off",
    "A feed below Z0 while the spindle stands still, in a program that starts it elsewhere.",
    "M6, M5 and M2 stop the spindle: start it again with M3 S.",
);

static SPINDLE_NEVER_STARTED: LintRule = rule(
    "spindle-never-started",
    "The program cuts below Z0 and never starts the spindle.",
    "Add M3 S; if the spindle is switched by hand, switch this lint off.",
);

static SPINDLE_NO_SPEED: LintRule = rule(
    "spindle-no-speed",
    "The spindle is started before any S.",
    "It turns at whatever speed was set last. Put S on the line of M3 or before it.",
);

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
const MOST_RUNS: usize = 20;

impl Spindles {
    fn cut(&mut self, place: BlockRef) {
        // A run of cuts is told once, at its first.
        if !self.off && self.cuts.len() < MOST_RUNS {
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
            // S on the line of M3 is carried out before it and has set the speed.
            if !self.speed {
                let hint = "put S on this line or before it";
                found.add(
                    &SPINDLE_NO_SPEED,
                    event.place,
                    "the spindle is started before any S".to_owned(),
                    &[],
                    hint,
                );
            }
            (self.started, self.speed, self.off) = (true, true, false);
        }
        // A block that stops the spindle after its move, or starts it before, counts as turning.
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
        // A program that never starts a spindle is told once: the operator may switch it by hand.
        if self.started {
            for place in &self.cuts {
                let message = "a feed below Z0 while the spindle stands still".to_owned();
                found.add(
                    &SPINDLE_OFF,
                    *place,
                    message,
                    &[],
                    "start it with M3 S; M6 and M5 have stopped it, or it comes later",
                );
            }
        } else if let Some(first) = self.cuts.first() {
            let message =
                "the first feed below Z0 of a program that never starts the spindle".to_owned();
            found.add(&SPINDLE_NEVER_STARTED, *first, message, &[], "add M3 S");
        }
    }
}
