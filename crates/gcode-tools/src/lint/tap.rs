//! Tapping whose feed and speed make no pitch that taps have.

use super::Check;
use super::moves::{Leg, is_lathe};
use super::rules::{Lint, LintFindings, LintRule, rule};
use lostmotion_gcode::ops::Units;
use lostmotion_gcode::program::Event;
use lostmotion_gcode::state::FeedMode;

/// The lints of this file.
pub(super) const LINTS: Lint = Lint {
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
