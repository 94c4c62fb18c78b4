//! Dwells that never seem to end.

use super::moves::Leg;
use super::{Check, LintFindings, rules};
use lostmotion_gcode::ops::CanonicalOp;
use lostmotion_gcode::program::Event;

/// From here on nobody waits on purpose, s.
const ENDLESS_S: f64 = 3600.0;
/// From here on a whole number looks like milliseconds, s.
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
            if seconds >= ENDLESS_S {
                found.add(&rules::DWELL_ENDLESS, event.place, message, &values, &hint);
            } else if seconds >= MILLISECONDS_S && seconds.fract() == 0.0 {
                found.add(
                    &rules::DWELL_MILLISECONDS,
                    event.place,
                    message,
                    &values,
                    &hint,
                );
            }
        }
    }
}
