//! Dwells that never seem to end.

use super::Check;
use super::moves::Leg;
use super::rules::{Lint, LintFindings, LintRule, rule};
use lostmotion_gcode::ops::CanonicalOp;
use lostmotion_gcode::program::Event;

/// The lints of this file.
pub(super) const LINTS: Lint = Lint {
    rules: &[&DWELL_ENDLESS, &DWELL_MILLISECONDS],
    check: || Box::new(Dwell),
};

static DWELL_ENDLESS: LintRule = rule(
    "dwell-endless",
    "A dwell of an hour or more.",
    "P is in seconds. On some controls it is in milliseconds; a post processor for those writes P1000 for a second.",
);

static DWELL_MILLISECONDS: LintRule = rule(
    "dwell-milliseconds",
    "A dwell of 100 s or more in whole seconds: the number looks like milliseconds.",
    "P is in seconds: half a second is P0.5.",
);

/// Shortest dwell that counts as a mistake, s. An hour: longer than a
/// program waits on purpose.
const ENDLESS_S: f64 = 3600.0;
/// Shortest dwell in whole seconds that looks like milliseconds, s. Origin unknown,
/// kept.
const MILLISECONDS_S: f64 = 100.0;

pub(super) struct Dwell;

impl Check for Dwell {
    fn block(&mut self, event: &Event<'_>, _: &[Leg<'_>], found: &mut LintFindings) {
        for sourced in event.ops {
            let CanonicalOp::Dwell(seconds) = sourced.op else {
                continue;
            };
            let values = [("seconds", seconds)];
            let message = format!("a dwell of {seconds} s ({:.1} min)", seconds / 60.0);
            let hint = format!("P is in seconds; {seconds} ms are P{}", seconds / 1000.0);
            // The longer one first: a dwell of an hour would be both.
            if seconds >= ENDLESS_S {
                found.add(&DWELL_ENDLESS, event.place, message, &values, &hint);
            } else if seconds >= MILLISECONDS_S && seconds.fract() == 0.0 {
                found.add(&DWELL_MILLISECONDS, event.place, message, &values, &hint);
            }
        }
    }
}
