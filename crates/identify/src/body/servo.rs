//! Gains of a position and velocity loop from command, position and what the servo makes of them.

use super::squares::{Squares, SquaresFit, jackknife};
use super::{Averages, BodyLog, Figure, Motion, Rates, SLOWEST_TURN_S};
use serde::Serialize;

/// Share of the drive signal that a servo law has to leave unexplained at most to be believed.
const LAW_SHARE: f64 = 0.15;
/// By how much further terms have to lower the residual to be believed. A choice.
const MORE_TERMS_GAIN: f64 = 0.7;

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

/// Columns of the laws: of error and speed alone, with speed and acceleration fed forward, and with an integral
/// part, too.
const LAWS: [[bool; COEFFICIENTS]; 3] = [
    [true, true, true, false, false, false, false, true, false],
    [true, true, true, false, false, true, true, true, false],
    [true; COEFFICIENTS],
];
/// The column that a law has beside those before it, which has to be told.
const OF_LAWS: [usize; 3] = [ERROR, REFERENCE, INTEGRAL];

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
/// command by a loop of its own is not merely late, and 0.022 was seen.
const GAIN_WITHIN: f64 = 0.03;

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
    check_command(log)?;
    let windows = ServoWindows::new(log, motion);
    let lag_s = windows
        .lag(motion.top_speed)
        .ok_or_else(|| why_no_lag(log))?;
    let mut gains = ServoGains {
        lag_s,
        law: None,
        untold: Vec::new(),
    };
    match fit_law(&windows) {
        Ok(law) => gains.law = Some(law),
        Err(why) => gains.untold.push(why),
    }
    Ok(gains)
}

/// Refuses a log without a command, or with one that the motor does not follow.
fn check_command(log: &BodyLog) -> Result<(), String> {
    if log.command.is_empty() {
        return Err("the log has no command: lag and gains are not told".to_owned());
    }
    let slope = follows(&log.command, &log.motor, log.period_s);
    if (slope - 1.0).abs() > FOLLOWS_WITHIN {
        return Err(format!(
            "the motor moves {slope:.4} times as far as its command: a sign, a unit, or the command of another axis"
        ));
    }
    Ok(())
}

/// Why no lag can be told.
fn why_no_lag(log: &BodyLog) -> String {
    let moves = log.command.windows(2).any(|pair| pair[0] != pair[1]);
    let why = if moves {
        "the command speeds up and slows down too little"
    } else {
        "the command does not move"
    };
    format!("{why}: lag and gains are not told")
}

/// What lag and law are fitted to: averages of the log over windows of one length.
struct ServoWindows<'a> {
    log: &'a BodyLog,
    /// Half a window, and what lies between two of them, samples.
    half: usize,
    stride: usize,
    /// Command less motor, m or rad.
    errors: Averages,
    /// Its integral, s times that.
    integrals: Averages,
    /// By how much later than the log tells the integral is read, s.
    quarter_turn_s: f64,
    places: Averages,
    /// Speed and acceleration of the motor.
    rates: Rates<'a>,
    /// The same of the command.
    commanded: Rates<'a>,
}

impl<'a> ServoWindows<'a> {
    fn new(log: &'a BodyLog, motion: &Motion) -> ServoWindows<'a> {
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
        ServoWindows {
            log,
            half,
            stride: (half / 4).max(1),
            errors: Averages::new(&error, half),
            integrals: Averages::new(&integral, half),
            quarter_turn_s,
            places: Averages::new(&log.motor, half),
            rates: Rates::new(&log.motor, half, log.period_s),
            commanded: Rates::new(&log.command, half, log.period_s),
        }
    }

    /// Middles of the whole windows with so many samples behind them.
    fn middles(&self, ahead: usize) -> impl Iterator<Item = usize> {
        let half = self.half;
        (half..self.log.len().saturating_sub(half + ahead))
            .step_by(self.stride)
            .filter(move |&at| !self.log.touches_lost(at - half..=at + half + ahead))
    }

    /// The lag, s: error against speed where both are steady, with what the motor is slower by beside. Without
    /// such rows against the speeds of motor and command, whose parts add up at a steady speed: of a position
    /// loop alone the error goes with the motor's, in strokes that are shorter than the lag, too. `None` where
    /// neither tells it.
    fn lag(&self, top_speed: f64) -> Option<Figure> {
        let places = self.log.len();
        let (mut steady, mut moving) = (Squares::<3>::new(places), Squares::<4>::new(places));
        for at in self.middles(0) {
            let error = self.errors.mean(at);
            let (asked, speed) = (self.commanded.velocity(at), self.rates.velocity(at));
            moving.add(at, [speed, asked, self.rates.acceleration(at), 1.0], error);
            let slower = asked - speed;
            if asked.abs() > FAST_SHARE * top_speed && slower.abs() < STEADY_WITHIN * asked.abs() {
                steady.add(at, [asked, slower, 1.0], error);
            }
        }
        match steady.solve(&[true; 3]) {
            Some(found) => {
                let lag = found.figures[0];
                Some(lag.widened(STEADY_OFF * lag.value.abs()))
            }
            None => moving.solve(&[true; 4]).map(|found| {
                let both = |x: &[f64; 4]| x[0] + x[1];
                let lag = jackknife(both(&found.x), found.without.iter().map(both));
                lag.widened(UNSTEADY_WITHIN * lag.value.abs())
            }),
        }
    }

    /// The rows of the law, with a drive signal that is so many seconds late.
    fn law_rows(&self, drive: &Averages, late_s: f64) -> Squares<COEFFICIENTS> {
        let log = self.log;
        let base = log.motor.first().copied().unwrap_or(0.0);
        let late = late_s / log.period_s;
        let (behind, ahead) = (late.floor() as usize, late.ceil() as usize);
        let share = late - late.floor();
        let mut squares = Squares::<COEFFICIENTS>::new(log.len());
        for at in self.middles(ahead) {
            let mut row = [0.0; COEFFICIENTS];
            row[ERROR] = self.errors.mean(at);
            row[VELOCITY] = self.rates.velocity(at);
            row[ACCELERATION] = self.rates.acceleration(at);
            row[INTEGRAL] = self.integrals.mean(at);
            row[PLACE] = self.places.mean(at) - base;
            row[REFERENCE] = self.commanded.velocity(at);
            row[REFERENCE_RATE] = self.commanded.acceleration(at);
            row[OFFSET] = 1.0;
            // Half a count by which an encoder reads short grows in the integral of a long log.
            row[TIME] = at as f64 * log.period_s;
            let target = (1.0 - share) * drive.mean(at + behind) + share * drive.mean(at + ahead);
            squares.add(at, row, target);
        }
        squares
    }
}

/// Fits the law of the drive signal.
///
/// # Errors
/// Why the log does not tell it.
fn fit_law(windows: &ServoWindows<'_>) -> Result<ServoLaw, String> {
    if windows.log.drive.is_empty() {
        return Err("gains of the loops: log the current or torque, too".to_owned());
    }
    let fit = LawFit::new(windows).ok_or(
        "gains of the loops: error and speed go together; change speed and direction more often",
    )?;
    let share = fit.residual_share();
    let pair = fit.pair();
    let [gain, position, per_time, forward] = fit.loops(pair.other);
    if !(share < LAW_SHARE && gain > 0.0 && position > 0.0 && per_time >= 0.0) {
        return Err(format!(
            "gains of the loops: a position and velocity loop leaves {:.0} % of the drive signal unexplained; the current may be filtered, limited, or of another law",
            100.0 * share
        ));
    }
    let delay_s = (fit.found.x[ACCELERATION] / gain).max(0.0);
    let mut figures = fit.figures(pair.other, delay_s);
    let (bounds, is_one) = fit.bounds(pair.other, delay_s);
    for (figure, interval) in figures.iter_mut().zip(bounds).skip(1) {
        *figure = figure.joined(Figure {
            interval,
            ..*figure
        });
    }
    let [velocity_gain, position_gain, per_time] = figures;
    let velocity_gain = velocity_gain.widened(GAIN_WITHIN * velocity_gain.value);
    if !(position_gain.is_told() && velocity_gain.is_told()) {
        return Err("gains of the loops: error and speed go together in most of the log; change speed and direction more often".to_owned());
    }
    let [_, alike_gain, alike_rate, _] = fit.loops(!pair.other);
    Ok(ServoLaw {
        position_gain_per_s: position_gain,
        velocity_gain,
        delay_s,
        // The sum up to an error is half a sample of it more than the integral.
        integral_time_s: (per_time.value > 0.0).then(|| reciprocal(per_time).widened(delay_s)),
        alike: (pair.is_alike && !is_one).then(|| [alike_gain, 1.0 / alike_rate]),
        feedforward: forward,
        offset: fit.found.x[OFFSET],
        residual_share: share,
    })
}

/// Coefficients of the law that explains the drive signal.
struct LawFit<'a> {
    windows: &'a ServoWindows<'a>,
    drive: Averages,
    found: SquaresFit<COEFFICIENTS>,
    /// Which of [`LAWS`] it is.
    law: usize,
}

/// Which of the two pairs of position gain and integral time is the servo's: see [`loops`].
struct LawPair {
    /// The one with the larger `1/T`.
    other: bool,
    /// The log does not tell.
    is_alike: bool,
}

impl<'a> LawFit<'a> {
    /// Fits each of the laws, and takes the one with most terms that explains much more than the first and tells its
    /// own term. `None` where the rows do not tell the coefficients.
    fn new(windows: &'a ServoWindows<'a>) -> Option<LawFit<'a>> {
        let drive = Averages::new(&windows.log.drive, windows.half);
        let squares = windows.law_rows(&drive, 0.0);
        let plain = squares.solve(&LAWS[0])?;
        let explains_more = |law: usize| {
            let (found, own) = (squares.solve(&LAWS[law])?, OF_LAWS[law]);
            let is_better = found.rms < MORE_TERMS_GAIN * plain.rms
                && found.figures[own].is_told()
                && found.x[own] > 0.0;
            is_better.then_some((law, found))
        };
        let (law, found) = (1..LAWS.len())
            .rev()
            .find_map(explains_more)
            .unwrap_or((0, plain));
        Some(LawFit {
            windows,
            drive,
            found,
            law,
        })
    }

    /// Whether the law has an integral part.
    fn has_integral(&self) -> bool {
        LAWS[self.law][INTEGRAL]
    }

    /// Residual over drive signal, root mean squares.
    fn residual_share(&self) -> f64 {
        self.found.rms / self.found.target_rms
    }

    /// What the coefficients mean: see [`loops`].
    fn loops(&self, other: bool) -> [f64; 4] {
        loops(&self.found.x, other)
    }

    /// Chooses the pair: where less or more than the whole speed is fed forward, the place itself tells the two
    /// apart.
    fn pair(&self) -> LawPair {
        let [slow, fast] = [false, true].map(|other| self.loops(other));
        let of_place = |[gain, _, per_time, forward]: [f64; 4]| gain * (forward - 1.0) * per_time;
        let of_unit = |[gain, _, per_time, _]: [f64; 4]| gain * per_time;
        let place = self.found.figures[PLACE];
        let [near, far] = [slow, fast].map(|law| (of_place(law) - place.value).abs());
        // So much of the place's term is what a feed-forward that is a little off makes of it.
        let unsure = FORWARD_WITHIN * (of_unit(slow) - of_unit(fast)).abs();
        let is_alike = self.has_integral()
            && fast.iter().all(|value| value.is_finite())
            && (near - far).abs() < APART * place.error + unsure;
        let other = if is_alike {
            slow[1] > fast[1]
        } else {
            far < near
        };
        LawPair {
            other: other && self.has_integral() && fast[2].is_finite(),
            is_alike,
        }
    }

    /// Velocity gain, position gain and `1/T` by the scatter between blocks. The intervals hold what the log
    /// tells with a measured velocity of this age, s, and with a drive signal that is as late.
    fn figures(&self, other: bool, delay_s: f64) -> [Figure; 3] {
        let of_fit = |fit: &SquaresFit<COEFFICIENTS>| {
            let values = loops(&fit.x, other);
            let figure =
                |at: usize| jackknife(values[at], fit.without.iter().map(|x| loops(x, other)[at]));
            std::array::from_fn(figure)
        };
        let figures: [Figure; 3] = of_fit(&self.found);
        let used = &LAWS[self.law];
        let late = self.windows.law_rows(&self.drive, delay_s).solve(used);
        match late.filter(|_| delay_s > 0.0) {
            Some(late) => {
                let of_late = of_fit(&late);
                std::array::from_fn(|at| figures[at].joined(of_late[at]))
            }
            None => figures,
        }
    }

    /// Velocity gain, position gain, `1/T` and feed-forward, each at least and at most, and whether the two pairs
    /// are nearly one: what the law does not explain may stand in any of its terms, and the sums of the error are
    /// those of some turn. A drive that samples its loops sums up half a sample more or less of the error, about as long
    /// as its measured velocity is old, `delay_s`. Where the two pairs are nearly one, both are within that.
    fn bounds(&self, other: bool, delay_s: f64) -> ([[f64; 2]; 4], bool) {
        let x = &self.found.x;
        let off = self.residual_share().min(MODEL_WITHIN);
        let of_turn = (x[INTEGRAL] * self.windows.quarter_turn_s / x[ERROR]).abs();
        let [ends, others] = [other, !other].map(|other| {
            let of_sample = delay_s * self.loops(other)[2];
            spread(x, [off + of_turn, 2.0 * off + of_sample], other)
        });
        let is_one =
            self.has_integral() && others[1][0] <= ends[1][1] && ends[1][0] <= others[1][1];
        if !is_one {
            return (ends, is_one);
        }
        let both = |at: usize| {
            let ([low, high], [lower, higher]) = (ends[at], others[at]);
            [low.min(lower), high.max(higher)]
        };
        (std::array::from_fn(both), is_one)
    }
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
