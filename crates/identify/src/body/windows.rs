//! Windows of a log in which an axis moves one way, as rows of a linear problem.

use super::motion::Noise;
use super::squares::{Squares, SquaresFit};
use super::{Averages, BodyLog, Motion, Rates, SLOWEST_TURN_S};
use lostmotion_base::math;

/// Part of the motor's speed that the load's may be off by in a window that counts. A choice: within it both
/// move one way, and so does their friction.
const FOLLOWS_SHARE: f64 = 0.5;
/// Half windows for which the motor has to have moved one way to drive the load for certain, where the load
/// is not logged, and the part of the top acceleration that is no braking. Choices.
const DRIVEN_FOR: usize = 4;
const BRAKES_SHARE: f64 = 0.02;
/// Part of what one body leaves of the drive signal, over the size of the accelerations, by which the inertia
/// may be off where the load is not logged: what a gap does, it does while the axis speeds up or slows
/// down. A choice: without it 28 of 100 intervals held in logs of 4 ms, with it 88 to 97.
const UNMODELLED_PART: f64 = 0.3;
/// Noise of the speed within a window, in parts of the speed of the decay. A choice: the decay is
/// off by its square.
const LOCAL_NOISE: f64 = 0.05;
/// Times the speed of the decay at which nothing is left of it, and the part of it that the speed may
/// change by from one sample to the next for the log to show the decay. Choices.
const FALLEN: f64 = 3.0;
const QUICK: f64 = 0.1;

pub(super) const INERTIA: usize = 0;
pub(super) const VISCOUS: usize = 1;
pub(super) const COULOMB: usize = 2;
pub(super) const CONSTANT: usize = 3;
pub(super) const STRIBECK: usize = 4;
pub(super) const VISCOUS_SIGN: usize = 5;
pub(super) const LATE: usize = 6;
/// Breakaway times the error of the logarithm of the decay's speed.
pub(super) const STRIBECK_SPEED: usize = 7;
pub(super) const STRIBECK_SIGN: usize = 8;
/// What the load speeds up and moves by beside the motor: its own part of inertia and viscous friction.
pub(super) const SLIP_ACCELERATION: usize = 9;
pub(super) const SLIP_SPEED: usize = 10;
/// Number of coefficients.
pub(super) const COEFFICIENTS: usize = 11;

/// Which terms of friction are fitted beside the plain ones.
#[derive(Default)]
pub(super) struct Terms {
    /// A fall with speed, at this speed.
    pub(super) stribeck_speed: Option<f64>,
    /// The error of that speed.
    pub(super) refine_stribeck: bool,
    /// Another fall in either direction.
    pub(super) sided_stribeck: bool,
    /// Another viscous friction in either direction.
    pub(super) sided_viscous: bool,
    /// What is done otherwise, to see what it makes of the figures.
    pub(super) other: Other,
}

/// Choices of the fit on which a figure should not hang.
#[derive(Clone, Copy, Default, PartialEq)]
pub(super) enum Other {
    /// None is another one.
    #[default]
    None,
    /// Longer windows.
    Windows,
    /// Longer averages of the speed within them.
    Speeds,
    /// A servo that turns as slowly as it may.
    Turns,
    /// Windows in which the axis may stick at the ends, or pass the fall quickly.
    Rows,
    /// Only windows in which the motor drives the load, and has for some time: it may cross a gap behind
    /// a reversal, and a load with little friction leaves a motor that brakes.
    Driven,
    /// Motor and load as one body: how a load slips beside its motor hangs on when it is read.
    OneBody,
}

/// Averages of a log over windows of one length.
struct Windows<'a> {
    log: &'a BodyLog,
    motion: &'a Motion,
    terms: &'a Terms,
    half: usize,
    /// Samples over which speeds within a window are taken.
    near: usize,
    motor: Rates<'a>,
    /// The motor's within windows.
    close: Rates<'a>,
    /// Those of the load, where it is logged.
    load: Option<[Rates<'a>; 2]>,
    drive: Averages,
    /// Friction that falls with speed, and its slope, for a breakaway of one.
    falls: Option<[Averages; 2]>,
}

impl<'a> Windows<'a> {
    fn new(log: &'a BodyLog, motion: &'a Motion, terms: &'a Terms) -> Windows<'a> {
        let half = match terms.other {
            Other::Windows => motion.half * 3 / 2,
            _ => motion.half,
        };
        // The servo holds its signal for a turn, of a length that the log does not tell: up to the whole
        // time between its rows.
        let turn = (SLOWEST_TURN_S / log.period_s).min(1.0);
        let held = match terms.other {
            Other::Turns => turn * turn,
            _ => 0.5 * turn * turn,
        };
        let near = (half / 2).max(2);
        let of = |column: &'a [f64], half| Rates::new(column, half, log.period_s);
        Windows {
            half,
            near,
            motor: of(&log.motor, half),
            close: of(&log.motor, near),
            load: (!log.load.is_empty()).then(|| [half, near].map(|half| of(&log.load, half))),
            drive: Averages::between(&log.drive, half, 1.0 - held),
            falls: terms
                .stribeck_speed
                .map(|speed| falls(log, motion, terms, half, speed)),
            log,
            motion,
            terms,
        }
    }

    /// Samples that a window needs on either side.
    fn margin(&self) -> usize {
        self.half + self.near + 1
    }

    /// Whether the axis goes one way through a window as far as its terms need it.
    fn counts(&self, at: usize) -> bool {
        let Windows {
            half, near, terms, ..
        } = *self;
        let sign = self.motor.velocity(at).signum();
        let goes_on = |place: usize| self.close.velocity(place) * sign > self.motion.rest_speed;
        // The ends of the window weigh little, but a body that sticks there tells nothing of
        // friction that falls with speed.
        let whole = self.falls.is_some() != (terms.other == Other::Rows);
        let reach = if whole { half } else { half / 2 };
        let places = [at - reach, at - half / 2, at, at + half / 2, at + reach];
        if !places.into_iter().all(goes_on) || self.log.touches_lost(at - half..=at + half) {
            return false;
        }
        // While the motor crosses a gap the load's friction is not that of motion.
        let follows = |place: usize| {
            self.load.as_ref().is_none_or(|[_, load]| {
                let speed = self.close.velocity(place);
                (load.velocity(place) - speed).abs() < FOLLOWS_SHARE * speed.abs()
            })
        };
        let places = [at - half, at - half / 2, at, at + half / 2, at + half];
        if !places.into_iter().all(follows) {
            return false;
        }
        let (velocity, acceleration) = (self.motor.velocity(at), self.motor.acceleration(at));
        if terms.other == Other::Driven {
            let brakes = acceleration * sign < -BRAKES_SHARE * self.motion.top_acceleration;
            let goes = |place: usize| place < self.margin() || goes_on(place);
            let before = at.checked_sub(DRIVEN_FOR * half);
            let since = before.is_some_and(|before| (before..at).step_by(near).all(goes));
            if brakes || !since {
                return false;
            }
        }
        // An axis that passes the fall within a few samples does not show its form.
        let period_s = self.log.period_s;
        let passes = |speed: f64| {
            let slowest = velocity.abs() - acceleration.abs() * half as f64 * period_s;
            slowest < FALLEN * speed && acceleration.abs() * period_s > QUICK * speed
        };
        terms.other == Other::Rows || !terms.stribeck_speed.is_some_and(passes)
    }

    /// A window's row, and its drive signal.
    fn row(&self, at: usize) -> ([f64; COEFFICIENTS], f64) {
        let (velocity, acceleration) = (self.motor.velocity(at), self.motor.acceleration(at));
        let sign = velocity.signum();
        let [decay, slope] = match &self.falls {
            Some(falls) => [falls[0].mean(at), falls[1].mean(at)],
            None => [0.0; 2],
        };
        let (before, here) = (self.drive.mean(at - 1), self.drive.mean(at));
        let mut row = [0.0; COEFFICIENTS];
        row[INERTIA] = acceleration;
        row[VISCOUS] = velocity;
        row[COULOMB] = sign;
        row[CONSTANT] = 1.0;
        row[STRIBECK] = decay;
        row[VISCOUS_SIGN] = velocity.abs();
        row[STRIBECK_SPEED] = slope;
        row[STRIBECK_SIGN] = sign * decay;
        if let Some([load, _]) = &self.load {
            row[SLIP_ACCELERATION] = load.acceleration(at) - acceleration;
            row[SLIP_SPEED] = load.velocity(at) - velocity;
        }
        // A drive signal that comes late or early has its own rate as an error, which looks like
        // friction.
        row[LATE] = (before - here) / self.log.period_s;
        // A servo holds its signal from one sample to the next: half of either window's.
        (row, 0.5 * (before + here))
    }

    /// Which coefficients are fitted.
    fn used(&self) -> [bool; COEFFICIENTS] {
        let mut used = [true; COEFFICIENTS];
        used[STRIBECK] = self.terms.stribeck_speed.is_some();
        used[STRIBECK_SPEED] = self.terms.refine_stribeck;
        used[STRIBECK_SIGN] = self.terms.sided_stribeck;
        used[VISCOUS_SIGN] = self.terms.sided_viscous;
        let slips = self.load.is_some() && self.terms.other != Other::OneBody;
        used[SLIP_ACCELERATION] = slips;
        used[SLIP_SPEED] = slips;
        used
    }
}

/// Friction that falls with speed, and its slope over the logarithm of the speed of the fall. It is no
/// straight line: within a window it is averaged, not taken at the average speed.
fn falls(log: &BodyLog, motion: &Motion, terms: &Terms, half: usize, speed: f64) -> [Averages; 2] {
    let local = local_half(motion, log.period_s, speed);
    let local = match terms.other {
        Other::Speeds => 3 * local,
        _ => local,
    };
    let local = Rates::new(&log.motor, local, log.period_s);
    let margin = local.half;
    let of = |at: usize| {
        if at < margin || at + margin >= log.len() {
            return (0.0, 0.0);
        }
        let velocity = local.velocity(at);
        let square = (velocity / speed) * (velocity / speed);
        let decay = velocity.signum() * math::exp(-square);
        (decay, 2.0 * square * decay)
    };
    let (decay, slope): (Vec<f64>, Vec<f64>) = (0..log.len()).map(of).unzip();
    [decay, slope].map(|column| Averages::new(&column, half))
}

/// Samples in half of the shortest window whose speed has noise that does not count beside a speed.
fn local_half(motion: &Motion, period_s: f64, speed: f64) -> usize {
    let noise = |half: usize| {
        let half = half as f64;
        motion.noise * (2.0 / half).sqrt() / (half * period_s)
    };
    let longest = motion.half.max(2);
    (1..longest)
        .find(|&half| noise(half) < LOCAL_NOISE * speed)
        .unwrap_or(longest)
}

/// Fits the windows in which the axis moves one way; `None` where they do not tell it.
pub(super) fn fit(
    log: &BodyLog,
    motion: &Motion,
    terms: &Terms,
) -> Option<SquaresFit<COEFFICIENTS>> {
    let windows = Windows::new(log, motion, terms);
    let (half, margin) = (windows.half, windows.margin());
    let mut noise = [&log.load, &log.drive].map(|column| Noise::of(column));
    let mut squares = Squares::new(log.len());
    // Neighbouring windows share most of their samples: half of them say as much.
    let stride = (half / 4).max(1);
    for at in (margin..log.len().saturating_sub(margin)).step_by(stride) {
        if windows.counts(at) {
            noise
                .iter_mut()
                .for_each(|noise| noise.add(at - half, at + half));
            let (row, drive) = windows.row(at);
            squares.add(at, row, drive);
        }
    }
    let used = windows.used();
    // Noise of three samples with weights 1, -2, 1, and of the means of either half. That of the motor does
    // not count: the windows are as long as it wants.
    let span = half as f64 * log.period_s;
    let [of_load, of_drive] = noise.map(|noise| noise.mean());
    let of_slip = [
        (
            SLIP_ACCELERATION,
            6.0 * of_load / (span * span * span * span),
        ),
        (SLIP_SPEED, 2.0 * of_load / (half as f64 * span * span)),
    ];
    // Counts are no white noise: what taking them out changes belongs to the intervals. Columns that are
    // hardly more than noise are left with it.
    let noisy = squares.clone().solve(&used);
    squares.without_noise(&of_slip);
    let Some(mut found) = squares.solve(&used) else {
        return noisy;
    };
    found.widen_to(&[noisy?.x]);
    if windows.load.is_none() {
        // Of white noise so much is left in the average of a window.
        let white = of_drive * 2.0 / (3.0 * half as f64);
        let left = (found.rms * found.rms - white).max(0.0).sqrt();
        let [size, ..] = squares.sizes();
        found.figures[INERTIA] = found.figures[INERTIA].widened(UNMODELLED_PART * left / size);
    }
    Some(found)
}
