//! Gains of a position and velocity loop from command, position and what the servo makes of them.

use super::squares::{Squares, SquaresFit, jackknife};
use super::{Averages, BodyLog, Figure, Motion, Rates, SLOWEST_TURN_S};
use serde::Serialize;

/// Share of the drive signal that a servo law has to leave unexplained at most to be believed.
const LAW_SHARE: f64 = 0.15;
/// By how much the integral part has to lower the residual to be believed. A choice.
const INTEGRAL_GAIN: f64 = 0.7;

/// Difference of the travel of command and motor, in parts of it, that passes. A choice: as of motor
/// and load, far above any following error of whole strokes and below any wrong unit.
const FOLLOWS_WITHIN: f64 = 0.2;

/// Part of the top speed from which on a row tells the lag at a steady speed, and part of it by which the motor's
/// may differ there. Choices: the error is settled to as much.
const FAST_SHARE: f64 = 0.1;
const STEADY_WITHIN: f64 = 0.02;
/// By how much the lag may be off that steady rows tell, in parts of it: integral parts settle slowly. A choice: in
/// logs of drives with known settings 0.032 was seen.
const STEADY_OFF: f64 = 0.03;
/// By how much the lag may be off that motion tells which is never steady, in parts of it. A choice: in logs of
/// drives with known settings 0.07 was seen.
const UNSTEADY_WITHIN: f64 = 0.1;

/// Lags of a position loop that are tried, s. Choices: gains from 1/s, far below those of machine tools, on.
const SHORTEST_LAG_S: f64 = 2e-3;
const LONGEST_LAG_S: f64 = 1.0;
const LAG_GROWTH: f64 = 1.5;

/// Columns of the law.
const ERROR: usize = 0;
const VELOCITY: usize = 1;
const ACCELERATION: usize = 2;
const INTEGRAL: usize = 3;
const PLACE: usize = 4;
const REFERENCE: usize = 5;
const REFERENCE_RATE: usize = 6;
const OFFSET: usize = 7;
const TIME: usize = 8;
const COEFFICIENTS: usize = 9;

/// Standard errors by which what tells two laws apart has to be nearer to one of them. A choice: the
/// quantile of a 95 % interval.
const APART: f64 = 2.0;

/// By how much the part of the speed that is fed forward may be off. A choice: in drives that sample
/// their loops it came out up to a hundredth too large.
const FORWARD_WITHIN: f64 = 0.05;
/// By how much terms of the law may be off at most, in parts of them; by less where the law leaves less
/// of the drive signal unexplained. A choice, as before: 0.033 was seen, and 0.04 of the integral.
const MODEL_WITHIN: f64 = 0.05;

/// By how much the velocity gain may be off beside that, in parts of it. A choice: a current that follows its
/// command by a loop of its own is not merely late, and 0.012 was seen.
const GAIN_WITHIN: f64 = 0.02;

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
    /// Drive signal for a speed error, per (1/s). The log does not tell whether the measured speed is
    /// old or the drive signal late, as a current is behind its loop: the interval holds the gain of
    /// either.
    pub velocity_gain: Figure,
    /// Age of the measured velocity, s, if the drive signal is not late.
    pub delay_s: f64,
    /// Integral time of the velocity loop, s; `None` without an integral part.
    pub integral_time_s: Option<Figure>,
    /// Position gain, 1/s, and integral time, s, of the law that explains the log alike: with the
    /// whole speed fed forward the two trade places. Of both, the one whose position loop is the
    /// slower comes first, as loops are set.
    pub alike: Option<[f64; 2]>,
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
    let slope = follows(&log.command, &log.motor, log.period_s);
    if (slope - 1.0).abs() > FOLLOWS_WITHIN {
        return Err(format!(
            "the motor moves {slope:.4} times as far as its command: a sign, a unit, or the command of another axis"
        ));
    }
    let half = (motion.half / 2).max(2);
    let error: Vec<f64> = log
        .command
        .iter()
        .zip(&log.motor)
        .map(|(command, motor)| command - motor)
        .collect();
    // The servo sums the error up once a turn: a log that is as fast shows its sums, a slower one their
    // integral, which is half a turn behind. The log does not tell which: a quarter, with both ends in
    // the interval.
    let quarter_turn_s = 0.25 * log.period_s.min(SLOWEST_TURN_S);
    let integral = integral(&error, log.period_s, quarter_turn_s);
    let (errors, integrals) = (Averages::new(&error, half), Averages::new(&integral, half));
    let places = Averages::new(&log.motor, half);
    let (rates, commanded) = (
        Rates::new(&log.motor, half, log.period_s),
        Rates::new(&log.command, half, log.period_s),
    );
    let range = half..log.len().saturating_sub(half);
    let stride = (half / 4).max(1);
    // The lag: error against speed where both are steady, with what the motor is slower by beside. Without
    // such rows against the speeds of motor and command, whose parts add up at a steady speed: of a position
    // loop alone the error goes with the motor's, in strokes that are shorter than the lag, too.
    let (mut steady, mut moving) = (Squares::<3>::new(log.len()), Squares::<4>::new(log.len()));
    for at in range.step_by(stride) {
        if log.touches_lost(at - half..=at + half) {
            continue;
        }
        let (error, asked, speed) = (errors.mean(at), commanded.velocity(at), rates.velocity(at));
        moving.add(at, [speed, asked, rates.acceleration(at), 1.0], error);
        let slower = asked - speed;
        if asked.abs() > FAST_SHARE * motion.top_speed && slower.abs() < STEADY_WITHIN * asked.abs()
        {
            steady.add(at, [asked, slower, 1.0], error);
        }
    }
    let lag = match steady.solve(&[true; 3]) {
        Some(found) => {
            let lag = found.figures[0];
            Some(lag.widened(STEADY_OFF * lag.value.abs()))
        }
        None => moving.solve(&[true; 4]).map(|found| {
            let both = |x: &[f64; 4]| x[0] + x[1];
            let lag = jackknife(both(&found.x), found.without.iter().map(both));
            lag.widened(UNSTEADY_WITHIN * lag.value.abs())
        }),
    };
    let Some(lag) = lag else {
        let moves = log.command.windows(2).any(|pair| pair[0] != pair[1]);
        let why = if moves {
            "the command speeds up and slows down too little"
        } else {
            "the command does not move"
        };
        return Err(format!("{why}: lag and gains are not told"));
    };
    let mut gains = ServoGains {
        lag_s: lag,
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
    let base = log.motor.first().copied().unwrap_or(0.0);
    // The rows of the law, with a drive signal that is so many seconds late.
    let rows = |late_s: f64| {
        let late = late_s / log.period_s;
        let (behind, ahead) = (late.floor() as usize, late.ceil() as usize);
        let share = late - late.floor();
        let mut squares = Squares::<COEFFICIENTS>::new(log.len());
        for at in (half..log.len().saturating_sub(half + ahead)).step_by(stride) {
            if log.touches_lost(at - half..=at + half + ahead) {
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
            // Half a count by which an encoder reads short grows in the integral of a long log.
            row[TIME] = at as f64 * log.period_s;
            let target = (1.0 - share) * drive.mean(at + behind) + share * drive.mean(at + ahead);
            squares.add(at, row, target);
        }
        squares
    };
    let squares = rows(0.0);
    // Without and with an integral part; a velocity that is fed forward comes with either.
    let laws = [
        [true, true, true, false, false, false, false, true, false],
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
    let [slow, fast] = [false, true].map(|other| loops(&found.x, other));
    // Where less or more than the whole speed is fed forward, the place itself tells the two apart.
    let of_place = |[gain, _, per_time, forward]: [f64; 4]| gain * (forward - 1.0) * per_time;
    let of_unit = |[gain, _, per_time, _]: [f64; 4]| gain * per_time;
    let place = found.figures[PLACE];
    let [near, far] = [slow, fast].map(|law| (of_place(law) - place.value).abs());
    // So much of the place's term is what a feed-forward that is a little off makes of it.
    let unsure = FORWARD_WITHIN * (of_unit(slow) - of_unit(fast)).abs();
    let is_alike = has_integral
        && fast.iter().all(|value| value.is_finite())
        && (near - far).abs() < APART * place.error + unsure;
    let other = if is_alike {
        slow[1] > fast[1]
    } else {
        far < near
    };
    let other = other && has_integral && fast[2].is_finite();
    let [gain, position, per_time, forward] = if other { fast } else { slow };
    if !(share < LAW_SHARE && gain > 0.0 && position > 0.0 && per_time >= 0.0) {
        gains.untold.push(format!(
            "gains of the loops: a position and velocity loop leaves {:.0} % of the drive signal unexplained; the current may be filtered, limited, or of another law",
            100.0 * share
        ));
        return Ok(gains);
    }
    let delay_s = (found.x[ACCELERATION] / gain).max(0.0);
    let figure = |value: f64, fit: &SquaresFit<COEFFICIENTS>, at: usize| {
        jackknife(value, fit.without.iter().map(|x| loops(x, other)[at]))
    };
    let values = [gain, position, per_time];
    let mut figures: [Figure; 3] = std::array::from_fn(|at| figure(values[at], &found, at));
    // The other end: all of the delay is the drive signal's.
    let late = rows(delay_s).solve(&laws[usize::from(has_integral)]);
    if let Some(late) = late.filter(|_| delay_s > 0.0) {
        let of_late = loops(&late.x, other);
        for (at, figure_of) in figures.iter_mut().enumerate() {
            *figure_of = figure_of.joined(figure(of_late[at], &late, at));
        }
    }
    // What the law does not explain may stand in any of its terms, and the sums of the error are those of
    // some turn. Where the two pairs are nearly one, both are within that.
    let off = share.min(MODEL_WITHIN);
    let of_turn = (found.x[INTEGRAL] * quarter_turn_s / found.x[ERROR]).abs();
    let [ends, others] =
        [other, !other].map(|other| spread(&found.x, [off + of_turn, 2.0 * off], other));
    let is_one = has_integral && others[1][0] <= ends[1][1] && ends[1][0] <= others[1][1];
    for (at, figure) in figures.iter_mut().enumerate().skip(1) {
        let [low, high] = ends[at];
        let interval = if is_one {
            [low.min(others[at][0]), high.max(others[at][1])]
        } else {
            [low, high]
        };
        *figure = figure.joined(Figure {
            interval,
            ..*figure
        });
    }
    let [velocity_gain, position_gain, per_time] = figures;
    let velocity_gain = velocity_gain.widened(GAIN_WITHIN * velocity_gain.value);
    let [_, alike_gain, alike_rate, _] = if other { slow } else { fast };
    if !(position_gain.is_told() && velocity_gain.is_told()) {
        gains.untold.push("gains of the loops: error and speed go together in most of the log; change speed and direction more often".to_owned());
        return Ok(gains);
    }
    gains.law = Some(ServoLaw {
        position_gain_per_s: position_gain,
        velocity_gain,
        delay_s,
        integral_time_s: (per_time.value > 0.0).then(|| reciprocal(per_time)),
        alike: (is_alike && !is_one).then(|| [alike_gain, 1.0 / alike_rate]),
        feedforward: forward,
        offset: found.x[OFFSET],
        residual_share: share,
    });
    Ok(gains)
}

/// How far a motor moves for its command, by least squares, at the lag of a position loop with which the two
/// go together best.
fn follows(command: &[f64], motor: &[f64], period_s: f64) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let m = mean(motor);
    let of_lag = |lag_s: f64| {
        let share = period_s / (period_s + lag_s);
        let mut behind = command.first().copied().unwrap_or_default();
        let followed: Vec<f64> = command
            .iter()
            .map(|command| {
                behind += share * (command - behind);
                behind
            })
            .collect();
        let c = mean(&followed);
        let (mut product, mut square) = (0.0, 0.0);
        for (command, motor) in followed.iter().zip(motor) {
            product += (command - c) * (motor - m);
            square += (command - c) * (command - c);
        }
        // What is left is least where this is most.
        (product * product / square, product / square)
    };
    let tried = std::iter::successors(Some(SHORTEST_LAG_S), |lag| Some(LAG_GROWTH * lag));
    let tried = tried.take_while(|lag| *lag < LONGEST_LAG_S);
    let (mut most, mut slope) = of_lag(0.0);
    for lag in tried {
        let (explained, of_it) = of_lag(lag);
        if explained > most {
            (most, slope) = (explained, of_it);
        }
    }
    slope
}

/// What coefficients mean: velocity gain, position gain, 1/T, feed-forward. Position gain `k` and
/// `u = 1/T` come as `q = k + forward u` and `p = k u`, which two pairs obey: the one with the
/// smaller `u` or the other.
fn loops(x: &[f64; COEFFICIENTS], other: bool) -> [f64; 4] {
    loops_off(x, other, [0.0; 2])
}

/// What coefficients mean, at least and at most, where the terms of error and integral are off by parts.
fn spread(
    x: &[f64; COEFFICIENTS],
    [of_error, of_integral]: [f64; 2],
    other: bool,
) -> [[f64; 2]; 4] {
    let corners = [
        [-of_error, -of_integral],
        [-of_error, of_integral],
        [of_error, -of_integral],
        [of_error, of_integral],
    ];
    let meant = corners.map(|off| loops_off(x, other, off));
    std::array::from_fn(|at| {
        meant
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], of| {
                [least.min(of[at]), most.max(of[at])]
            })
    })
}

/// One over a positive figure; without an end where the figure may be zero.
fn reciprocal(figure: Figure) -> Figure {
    let [low, high] = figure.interval;
    Figure {
        value: 1.0 / figure.value,
        error: figure.error / (figure.value * figure.value),
        interval: [
            1.0 / high,
            if low > 0.0 { 1.0 / low } else { f64::INFINITY },
        ],
    }
}

/// The integral of an error, a part of a turn later.
fn integral(error: &[f64], period_s: f64, later_s: f64) -> Vec<f64> {
    let (mut sum, mut before) = (0.0, 0.0);
    error
        .iter()
        .map(|&error| {
            sum += 0.5 * (before + error) * period_s;
            before = error;
            sum + later_s * error
        })
        .collect()
}

/// The same of terms of error and integral that are off by parts of them.
fn loops_off(x: &[f64; COEFFICIENTS], other: bool, [of_error, of_integral]: [f64; 2]) -> [f64; 4] {
    let gain = -x[VELOCITY];
    let forward = x[REFERENCE] / gain;
    let (q, p) = (
        x[ERROR] / gain * (1.0 + of_error),
        x[INTEGRAL] / gain * (1.0 + of_integral),
    );
    let root = q + (q * q - 4.0 * forward * p).max(0.0).sqrt();
    let per_time = if other {
        root / (2.0 * forward)
    } else if p == 0.0 {
        0.0
    } else {
        2.0 * p / root
    };
    [gain, q - forward * per_time, per_time, forward]
}
