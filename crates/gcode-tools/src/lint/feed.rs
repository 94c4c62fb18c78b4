//! Numbers that look like those of other units: feed rates, dwells that never seem to end, tapping whose
//! feed and speed make no pitch that taps have.

use super::Check;
use super::moves::{Leg, is_lathe};
use super::rules::{Lint, LintFindings, LintRule, rule};
use lostmotion_gcode::ops::{CanonicalOp, Units};
use lostmotion_gcode::program::Event;
use lostmotion_gcode::state::FeedMode;

/// Feed rates in other units.
pub(super) const FEED: Lint = Lint {
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
            // Zero only takes the feed back.
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

/// Dwells in milliseconds, or without an end.
pub(super) const DWELL: Lint = Lint {
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
/// Shortest dwell in whole seconds that looks like milliseconds, s. A choice: lower reports dwells
/// that are meant in seconds, higher misses short ones in milliseconds.
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

/// Pitches that no tap has.
pub(super) const TAP: Lint = Lint {
    rules: &[&TAP_FEED],
    check: || Box::new(Taps),
};

static TAP_FEED: LintRule = rule(
    "tap-feed",
    "The feed and the speed of a tapping cycle make a pitch that no usual tap has.",
    "The tap breaks or strips the thread. F has to be the pitch times S. Compared with ISO 261 and the inch series, within 1 %.",
);

/// Pitches of ISO 261, mm.
const METRIC: [f64; 25] = [
    0.2, 0.225, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.6, 0.7, 0.75, 0.8, 1.0, 1.25, 1.5, 1.75, 2.0,
    2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 5.5, 6.0,
];
/// Threads per inch of UNC, UNF, UNEF, NPT and BSP.
const PER_INCH: [f64; 29] = [
    80.0, 72.0, 64.0, 56.0, 48.0, 44.0, 40.0, 36.0, 32.0, 28.0, 27.0, 24.0, 20.0, 19.0, 18.0, 16.0,
    14.0, 13.0, 12.0, 11.5, 11.0, 10.0, 9.0, 8.0, 7.0, 6.0, 5.0, 4.5, 4.0,
];
/// Largest relative deviation from a standard pitch: F and S are rounded.
const PITCH_TOLERANCE: f64 = 0.01;

/// G74 and G84 outside lathes.
#[derive(Debug)]
pub(super) struct Taps;

impl Check for Taps {
    fn block(&mut self, event: &Event<'_>, legs: &[Leg<'_>], found: &mut LintFindings) {
        let state = event.after;
        if legs.is_empty()
            || is_lathe(state)
            || state.cycle.spindle > 0
            || !state
                .motion
                .is_some_and(|code| matches!(code.tenths, 740 | 840))
        {
            return;
        }
        let speed = state.spindle.speed;
        // Feed per minute over revolutions per minute is the travel per revolution, the pitch.
        let pitch = match state.feed_mode {
            FeedMode::PerRevolution => state.feed,
            _ if speed > 0.0 => state.feed / speed,
            _ => return,
        };
        let pitch_mm = pitch * state.units.mm();
        let is_near = |usual: f64| (pitch_mm / usual - 1.0).abs() <= PITCH_TOLERANCE;
        // A metric pitch, or an inch one from its threads per inch.
        if METRIC.into_iter().any(is_near)
            || PER_INCH
                .into_iter()
                .any(|threads| is_near(Units::Inch.mm() / threads))
        {
            return;
        }
        let message = format!(
            "F{} at S{speed} makes a pitch of {pitch_mm:.4} mm, which no usual tap has",
            state.feed
        );
        let values = [
            ("pitch_mm", pitch_mm),
            ("feed", state.feed),
            ("speed", speed),
        ];
        found.add(
            &TAP_FEED,
            event.place,
            message,
            &values,
            "F is the pitch times S; in feed per revolution (G95) it is the pitch",
        );
    }
}
