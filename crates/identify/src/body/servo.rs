//! Gains of a position and velocity loop from command, position and what the servo makes of them.

use super::squares::{Squares, jackknife};
use super::{Averages, BodyLog, Figure, Motion, Rates};
use serde::Serialize;

/// Share of the drive signal that a servo law has to leave unexplained at most to be believed.
const LAW_SHARE: f64 = 0.15;
/// By how much the integral part has to lower the residual to be believed. A choice.
const INTEGRAL_GAIN: f64 = 0.7;

/// Columns of the law.
const ERROR: usize = 0;
const VELOCITY: usize = 1;
const ACCELERATION: usize = 2;
const INTEGRAL: usize = 3;
const PLACE: usize = 4;
const REFERENCE: usize = 5;
const REFERENCE_RATE: usize = 6;
const OFFSET: usize = 7;
const COEFFICIENTS: usize = 8;

/// What was found of a servo: `drive = velocity_gain (position_gain e + feedforward v_ref - v)` and,
/// with an integral time `T`, the integral of the bracket over `T`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ServoGains {
    /// Time by which the position lags behind the command at a steady speed, s; `None` without a
    /// command.
    pub lag_s: Figure,
    /// The law, where drive signal and command obey one.
    pub law: Option<ServoLaw>,
    /// What cannot be told, and why.
    pub untold: Vec<String>,
}

/// A servo's law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ServoLaw {
    /// Gain of the position loop, 1/s.
    pub position_gain_per_s: Figure,
    /// Drive signal for a speed error, per (1/s).
    pub velocity_gain: Figure,
    /// Age of the measured velocity, s.
    pub delay_s: f64,
    /// Integral time of the velocity loop, s; `None` without an integral part.
    pub integral_time_s: Option<f64>,
    /// Part of the command's speed that is fed forward.
    pub feedforward: f64,
    /// Drive signal at rest on the command.
    pub offset: f64,
    /// Residual over drive signal, root mean squares.
    pub residual_share: f64,
}

/// Fits the servo.
///
/// Noise of the encoder does no harm here: the servo sees the same noise, and answers to it.
///
/// # Errors
/// What is missing: no command in the log, no motion.
pub fn fit_servo(log: &BodyLog, motion: &Motion) -> Result<ServoGains, String> {
    if log.command.is_empty() {
        return Err("the log has no command: lag and gains are not told".to_owned());
    }
    let half = (motion.half / 2).max(2);
    let error: Vec<f64> = log
        .command
        .iter()
        .zip(&log.motor)
        .map(|(command, motor)| command - motor)
        .collect();
    let mut sum = 0.0;
    let integral: Vec<f64> = error
        .iter()
        .map(|error| {
            sum += error * log.period_s;
            sum
        })
        .collect();
    let (errors, integrals) = (Averages::new(&error, half), Averages::new(&integral, half));
    let places = Averages::new(&log.motor, half);
    let (rates, commanded) = (
        Rates::new(&log.motor, half, log.period_s),
        Rates::new(&log.command, half, log.period_s),
    );
    let range = half..log.len().saturating_sub(half);
    let stride = (half / 4).max(1);
    // The lag: error against the command's speed, with its acceleration beside.
    let mut lag = Squares::<3>::new(log.len());
    for at in range.clone().step_by(stride) {
        if !log.touches_lost(at - half..=at + half) {
            let row = [commanded.velocity(at), commanded.acceleration(at), 1.0];
            lag.add(at, row, errors.mean(at));
        }
    }
    let Some(lag) = lag.solve(&[true; 3]) else {
        return Err("the command does not move: lag and gains are not told".to_owned());
    };
    let mut gains = ServoGains {
        lag_s: lag.figures[0],
        law: None,
        untold: Vec::new(),
    };
    if log.drive.is_empty() {
        gains
            .untold
            .push("gains of the loops: log the current or torque, too".to_owned());
        return Ok(gains);
    }
    let drive = Averages::new(&log.drive, half);
    let mut squares = Squares::<COEFFICIENTS>::new(log.len());
    let base = log.motor.first().copied().unwrap_or(0.0);
    for at in range.step_by(stride) {
        if log.touches_lost(at - half..=at + half) {
            continue;
        }
        let mut row = [0.0; COEFFICIENTS];
        row[ERROR] = errors.mean(at);
        row[VELOCITY] = rates.velocity(at);
        row[ACCELERATION] = rates.acceleration(at);
        row[INTEGRAL] = integrals.mean(at);
        row[PLACE] = places.mean(at) - base;
        row[REFERENCE] = commanded.velocity(at);
        row[REFERENCE_RATE] = commanded.acceleration(at);
        row[OFFSET] = 1.0;
        squares.add(at, row, drive.mean(at));
    }
    // Without and with an integral part; a velocity that is fed forward comes with either.
    let laws = [
        [true, true, true, false, false, false, false, true],
        [true; COEFFICIENTS],
    ];
    let [plain, whole] = laws.map(|used| squares.solve(&used));
    let has_integral = match (&plain, &whole) {
        (Some(plain), Some(whole)) => {
            whole.rms < INTEGRAL_GAIN * plain.rms
                && whole.figures[INTEGRAL].is_told()
                && whole.x[INTEGRAL] > 0.0
        }
        _ => false,
    };
    let Some(found) = (if has_integral { whole } else { plain }) else {
        gains.untold.push("gains of the loops: error and speed go together; change speed and direction more often".to_owned());
        return Ok(gains);
    };
    let share = found.rms / found.target_rms;
    let parts = |x: &[f64; COEFFICIENTS]| -> [f64; 4] {
        let gain = -x[VELOCITY];
        let forward = x[REFERENCE] / gain;
        // position gain + forward / T = q and position gain / T = p
        let (q, p) = (x[ERROR] / gain, x[INTEGRAL] / gain);
        let per_time = if p == 0.0 {
            0.0
        } else {
            let root = (q * q - 4.0 * forward * p).max(0.0).sqrt();
            2.0 * p / (q + root)
        };
        [gain, q - forward * per_time, per_time, forward]
    };
    let [gain, position, per_time, forward] = parts(&found.x);
    if !(share < LAW_SHARE && gain > 0.0 && position > 0.0 && per_time >= 0.0) {
        gains.untold.push(format!(
            "gains of the loops: a position and velocity loop leaves {:.0} % of the drive signal unexplained; the current may be filtered, limited, or of another law",
            100.0 * share
        ));
        return Ok(gains);
    }
    gains.law = Some(ServoLaw {
        position_gain_per_s: jackknife(position, found.without.iter().map(|x| parts(x)[1])),
        velocity_gain: jackknife(gain, found.without.iter().map(|x| parts(x)[0])),
        delay_s: (found.x[ACCELERATION] / gain).max(0.0),
        integral_time_s: (per_time > 0.0).then(|| 1.0 / per_time),
        feedforward: forward,
        offset: found.x[OFFSET],
        residual_share: share,
    });
    Ok(gains)
}
