//! Whether the times of a log can be those of an axis, whatever axis it is of.

use super::{BodyLog, Motion};
use crate::error::{Cause, FitError};

/// Time between samples, s, up to which, and acceleration, m/s2 or rad/s2, from which on times in s are
/// taken for ms. Choices: no drive samples so fast, and a thousand g break any axis.
const MIN_PERIOD_S: f64 = 1e-5;
const MOST_ACCELERATION: f64 = 1e4;
/// Largest acceleration, m/s2 or rad/s2, up to which rows that are far apart are times in ms taken for s. A
/// choice: ten times what that makes of 1 m/s2; steps of 0.1 mm with a row a second have ten times as much.
const LEAST_ACCELERATION: f64 = 1e-5;
/// Longest time between samples of a log of a drive, s. A choice: a stroke's acceleration lasts some
/// ten times as long.
pub(crate) const MAX_PERIOD_S: f64 = 2e-2;

/// Parts of a log between which it may bend. A choice: noise of a micrometre is then far below the bound.
const PARTS: usize = 200;

/// Whether the times of a log can be those of an axis at all: a wrong unit makes accelerations wrong by a
/// million.
///
/// # Errors
/// [`FitError::Implausible`], with what was found and the unit that it looks like.
pub fn times_go_with(log: &BodyLog, motion: &Motion) -> Result<(), FitError> {
    let period_s = log.period_s;
    let mut top = motion.top_acceleration;
    let cause = if period_s < MIN_PERIOD_S && bend(log) > MOST_ACCELERATION {
        // Such a log is too short for strokes.
        top = bend(log);
        Cause::Seconds
    } else if period_s > MAX_PERIOD_S && motion.top_speed > 0.0 && top < LEAST_ACCELERATION {
        Cause::Milliseconds
    } else {
        return Ok(());
    };
    Err(FitError::Implausible {
        what: format!(
            "the rows are {period_s:.3e} s apart, and it speeds up by at most {top:.3e} per s2 (m or rad)"
        ),
        cause,
    })
}

/// Largest acceleration between parts of the log, per s^2.
fn bend(log: &BodyLog) -> f64 {
    let step = (log.motor.len() / PARTS).max(1);
    let places: Vec<f64> = log.motor.iter().step_by(step).copied().collect();
    let time_s = step as f64 * log.period_s;
    let bends = places
        .windows(3)
        .map(|of| (of[2] - 2.0 * of[1] + of[0]).abs());
    bends.fold(0.0, f64::max) / (time_s * time_s)
}
