//! Feed rates that look like those of other units.

use super::Check;
use super::moves::Leg;
use super::rules::{Lint, LintFindings, LintRule, rule};
use lostmotion_gcode::ops::{CanonicalOp, Units};
use lostmotion_gcode::program::Event;
use lostmotion_gcode::state::FeedMode;

/// The lints of this file.
pub(super) const LINTS: Lint = Lint {
    rules: &[&FEED_UNITS],
    check: || Box::new(Feed::default()),
};

static FEED_UNITS: LintRule = rule(
    "feed-units",
    "A feed rate that looks like one in other units.",
    "Check G20 and G21, G94 and G95, and the post processor.",
);

/// Slower is no feed in mm/min, but a usual one in in/min or mm/rev.
const LEAST_MM_MIN: f64 = 3.0;
/// Faster than any cut, mm/min.
const MOST_MM_MIN: f64 = 100_000.0;
/// Faster than routers cut, in/min; a usual figure in mm/min.
const MOST_INCH_MIN: f64 = 1000.0;
/// More than any tool takes off in a revolution, mm.
const MOST_MM_REV: f64 = 5.0;

/// Each doubt is told once.
#[derive(Debug, Default)]
pub(super) struct Feed {
    told: Vec<(FeedMode, Units)>,
}

impl Check for Feed {
    fn block(&mut self, event: &Event<'_>, _: &[Leg<'_>], found: &mut LintFindings) {
        let state = event.after;
        for sourced in event.ops {
            let CanonicalOp::SetFeedRate {
                rate,
                inverse_time: None,
            } = sourced.op
            else {
                continue;
            };
            if rate <= 0.0 {
                continue;
            }
            let unit = state.units.name();
            // The bounds of each combination, with the unit that the figure would suit.
            let (doubtful, per, meant) = match (state.feed_mode, state.units) {
                (FeedMode::PerMinute, Units::Mm) if rate < LEAST_MM_MIN => {
                    (true, "min", "in/min or mm/rev")
                }
                (FeedMode::PerMinute, Units::Mm) => (rate > MOST_MM_MIN, "min", "um/s"),
                (FeedMode::PerMinute, Units::Inch) => (rate > MOST_INCH_MIN, "min", "mm/min"),
                (FeedMode::PerRevolution, units) => {
                    (rate * units.mm() > MOST_MM_REV, "rev", "a feed per minute")
                }
                (FeedMode::InverseTime, _) => continue,
            };
            // One finding for each combination: the same post processor writes all feeds.
            let mode = (state.feed_mode, state.units);
            if doubtful && !self.told.contains(&mode) {
                self.told.push(mode);
                let message = format!("F{rate} is {rate} {unit}/{per} here; it looks like {meant}");
                found.add(
                    &FEED_UNITS,
                    event.place,
                    message,
                    &[("feed", rate)],
                    "check the units and the feed mode",
                );
            }
        }
    }
}
