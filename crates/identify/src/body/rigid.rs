//! Inertia and friction of an axis from its motion and what drives it.

use super::motion::Noise;
use super::squares::{Squares, SquaresFit, jackknife};
use super::{Averages, BodyLog, Figure, Motion, Rates, SLOWEST_TURN_S};
use lostmotion_base::math;
use serde::Serialize;

/// Half width of an interval, in parts of the figure, from which on the figure is not told.
const TOLD_SHARE: f64 = 0.5;
/// Share of the drive signal that one body may leave unexplained. A choice: records of stiff axes
/// leave 4 % at most, axes with a gap and a soft shaft 13 % and more, and their intervals do not
/// hold.
const ONE_BODY_SHARE: f64 = 0.08;
/// Share from which on it is not the motion's at all. A choice: the worst of sound logs leaves 0.3.
const UNMODELLED_PART: f64 = 0.3;
const UNRELATED_SHARE: f64 = 0.7;
/// Part of the motor's speed that the load's may be off by in a window that counts. A choice: within it both
/// move one way, and so does their friction.
const FOLLOWS_SHARE: f64 = 0.5;
/// Half windows for which the motor has to have moved one way to drive the load for certain, where the load
/// is not logged, and the part of the top acceleration that is no braking. Choices.
const DRIVEN_FOR: usize = 4;
const BRAKES_SHARE: f64 = 0.02;
/// Longest time between rows, s: an acceleration is over sooner. A choice, above all that drives log.
const SLOWEST_S: f64 = 0.1;
/// Standard errors from which on a further friction is believed.
const SURE_ERRORS: f64 = 4.0;
/// Speeds that Stribeck's decay is looked for at, in parts of the top speed.
const STRIBECK_SHARES: [f64; 10] = [0.01, 0.015, 0.02, 0.03, 0.045, 0.07, 0.1, 0.15, 0.2, 0.3];
/// Steps in which the speed of the decay is brought to its best.
const STRIBECK_STEPS: usize = 12;
/// Largest step of its logarithm, and the one that ends them.
const STRIBECK_STEP: [f64; 2] = [0.3, 1e-4];
/// Largest speed of the decay, in parts of the top speed: beyond, it is viscous friction.
const STRIBECK_LIMIT: f64 = 0.5;
/// Part of the top speed below which motion tells whether friction falls with speed, and the share
/// of the windows that has to be there. Choices.
const SLOW_SHARE: f64 = 0.05;
const SLOW_WINDOWS: f64 = 0.02;
/// Part of the windows that may be slower, and faster, and the ratio of what is left that tells viscous
/// from Coulomb friction. Choices.
const ALIKE: f64 = 0.1;
const LEAST_RATIO: f64 = 1.5;
/// Part of Coulomb friction by which it has to fall over the speeds of the windows for that to count. A choice.
const FALLS_SHARE: f64 = 0.1;
/// Noise of the speed within a window, in parts of the speed of the decay. A choice: the decay is
/// off by its square.
const LOCAL_NOISE: f64 = 0.05;
/// Times the speed of the decay at which nothing is left of it, and the part of it that the speed may
/// change by from one sample to the next for the log to show the decay. Choices.
const FALLEN: f64 = 3.0;
const QUICK: f64 = 0.1;
/// Fall of the residual by which Stribeck's decay has to pay. A choice.
const STRIBECK_GAIN: f64 = 0.97;

const INERTIA: usize = 0;
const VISCOUS: usize = 1;
const COULOMB: usize = 2;
const CONSTANT: usize = 3;
const STRIBECK: usize = 4;
const VISCOUS_SIGN: usize = 5;
const LATE: usize = 6;
/// Breakaway times the error of the logarithm of the decay's speed.
const STRIBECK_SPEED: usize = 7;
const STRIBECK_SIGN: usize = 8;
/// What the load speeds up and moves by beside the motor: its own part of inertia and viscous friction.
const SLIP_ACCELERATION: usize = 9;
const SLIP_SPEED: usize = 10;
/// Number of coefficients.
const COEFFICIENTS: usize = 11;

/// Friction of either direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sided {
    /// Viscous friction forwards and backwards.
    pub viscous: [Figure; 2],
}

/// Stribeck's decay: friction that is larger at small speeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Stribeck {
    /// What breakaway has above sliding.
    pub above: Figure,
    /// The same forwards and backwards, where the directions certainly differ.
    pub sided: Option<[Figure; 2]>,
    /// Speed at which 37 % of it is left, per s.
    pub speed: Figure,
}

/// That friction hardly falls with speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StribeckBound {
    /// What breakaway has above sliding, at most (95 %).
    pub above: f64,
    /// Slowest speed of a fall that this holds for, per s.
    pub from_speed: f64,
}

/// Inertia and friction, in units of the drive signal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RigidBody {
    /// Drive signal per acceleration.
    pub inertia: Figure,
    /// Drive signal per speed.
    pub viscous: Figure,
    /// Drive signal against sliding.
    pub coulomb: Figure,
    /// Drive signal against motion at the usual speed, Coulomb and viscous friction together: told where
    /// the two are not.
    pub drag: Figure,
    /// Drive signal at any speed: gravity, or an offset.
    pub constant: Figure,
    /// Where the directions have certainly another viscous friction.
    pub sided: Option<Sided>,
    /// Where friction certainly falls with speed.
    pub stribeck: Option<Stribeck>,
    /// Where slow motion shows no such fall: what it is at most.
    pub stribeck_bound: Option<StribeckBound>,
    /// Time by which the drive signal is ahead of what moves the axis, s; negative where it is late,
    /// as behind a filter.
    pub drive_ahead: Figure,
    /// Residual over drive signal, root mean squares.
    pub residual_share: f64,
    /// Windows that were used.
    pub rows: usize,
    /// What cannot be told, and which motion would tell it.
    pub untold: Vec<String>,
}

/// Fits inertia and friction; what the log does not tell is said in the second part.
///
/// # Errors
/// What is missing: no drive signal, no motion in both directions, no windows in which the axis
/// moves one way.
pub fn fit_body(log: &BodyLog, motion: &Motion) -> Result<RigidBody, String> {
    if log.drive.is_empty() {
        return Err(
            "the log has no current, torque or force: inertia and friction are not told".to_owned(),
        );
    }
    if log.period_s > SLOWEST_S {
        return Err(format!(
            "the rows are {} s apart, and an acceleration is over sooner: log faster, or say in which unit the times are; in s they may be ms",
            log.period_s
        ));
    }
    let both = [1.0, -1.0].iter().all(|&direction| {
        motion
            .strokes
            .iter()
            .any(|stroke| stroke.direction == direction)
    });
    if !both {
        return Err("the axis moves one way only: move it to and fro, friction and a constant force are told apart by the direction".to_owned());
    }
    let mut plain = fit(log, motion, &Terms::default()).ok_or(
        "the axis never moves one way for long enough: make longer strokes at several speeds",
    )?;
    let mut others = vec![Other::Windows, Other::Rows, Other::Turns];
    if log.load.is_empty() {
        others.push(Other::Driven);
    }
    let others = others.into_iter().filter_map(|other| {
        let terms = Terms {
            other,
            ..Terms::default()
        };
        Some(fit(log, motion, &terms)?.x)
    });
    plain.widen_to(&others.collect::<Vec<_>>());
    let share = plain.rms / plain.target_rms;
    if share > UNRELATED_SHARE {
        return Err(format!(
            "{:.0} % of the drive signal have nothing to do with the motion: it may be another column, or of another axis",
            100.0 * share
        ));
    }
    let speeds = speeds(log, motion);
    let usual = speeds.get(speeds.len() / 2).copied().unwrap_or_default();
    let drag = |x: &[f64; COEFFICIENTS]| x[COULOMB] + x[VISCOUS] * usual;
    let mut body = RigidBody {
        drag: jackknife(drag(&plain.x), plain.without.iter().map(drag)),
        inertia: plain.figures[INERTIA],
        viscous: plain.figures[VISCOUS],
        coulomb: plain.figures[COULOMB],
        constant: plain.figures[CONSTANT],
        sided: None,
        stribeck: None,
        stribeck_bound: None,
        drive_ahead: plain.figures[LATE],
        residual_share: share,
        rows: plain.rows,
        untold: Vec::new(),
    };
    let by_direction = Terms {
        sided_viscous: true,
        ..Terms::default()
    };
    if let Some(sided) = fit(log, motion, &by_direction) {
        let viscous = directions(&sided, VISCOUS, VISCOUS_SIGN);
        body.sided = viscous.map(|viscous| Sided { viscous });
    }
    match decay(log, motion, &plain) {
        Ok((found, stribeck)) => {
            body.viscous = found.figures[VISCOUS];
            body.coulomb = found.figures[COULOMB];
            body.inertia = found.figures[INERTIA];
            body.constant = found.figures[CONSTANT];
            body.drive_ahead = found.figures[LATE];
            body.residual_share = found.rms / found.target_rms;
            body.stribeck = Some(stribeck);
        }
        Err(NoDecay::SlowMissing(share)) => body.untold.push(format!(
            "whether friction falls with speed (Stribeck) cannot be told, because only {:.1} % of the motion is slower than a twentieth of the top speed: move steadily at a tenth, a thirtieth and a hundredth of the top speed, both ways",
            100.0 * share
        )),
        Err(NoDecay::Unclear) => body.untold.push(
            "whether friction falls with speed (Stribeck) cannot be told, because the log fits with and without it: move steadily at a tenth, a thirtieth and a hundredth of the top speed, several times both ways".to_owned(),
        ),
        Err(NoDecay::Least(most)) => body.stribeck_bound = Some(most),
    }
    if body.drag.interval[1] < 0.0 && body.inertia.value > 0.0 {
        return Err(format!(
            "friction would drive the axis, by {:.1} to {:.1}: its columns may be of other times, or of another axis",
            -body.drag.interval[1], -body.drag.interval[0]
        ));
    }
    let together = body.apart(&speeds);
    let told = |figure: Figure| {
        let half = 0.5 * (figure.interval[1] - figure.interval[0]);
        half <= TOLD_SHARE * figure.value.abs()
    };
    for (figure, what) in [
        (
            body.inertia,
            "the inertia: accelerate harder, at least till the current doubles",
        ),
        (
            body.viscous,
            "the viscous friction: move steadily at speeds of at least one to five",
        ),
        (
            body.coulomb,
            "the Coulomb friction: move steadily both ways at a slow speed",
        ),
    ] {
        let is_said = together.is_some() && figure != body.inertia;
        if !told(figure) && !is_said {
            body.untold.push(what.to_owned());
        }
    }
    body.untold.extend(together);
    if !body.is_one_body() {
        body.untold.push(format!(
            "inertia and friction with certainty: {:.0} % of the drive signal is not that of one body; gap and shaft move on their own, and the intervals do not hold",
            100.0 * body.residual_share
        ));
    }
    Ok(body)
}

impl RigidBody {
    /// Whether one body explains the drive signal: otherwise the intervals do not hold.
    pub fn is_one_body(&self) -> bool {
        self.residual_share <= ONE_BODY_SHARE
    }

    /// Whether the axis speeds up against what drives it and friction helps it on: the sign of the
    /// drive signal, or of the position, is reversed.
    pub fn is_reversed(&self) -> bool {
        self.inertia.value < 0.0 && self.drag.interval[1] < 0.0
    }

    /// Widens the intervals of friction where the speeds of the windows, in their order, do not tell its parts
    /// apart; says so.
    fn apart(&mut self, speeds: &[f64]) -> Option<String> {
        let at =
            |part: f64| speeds.get((part * speeds.len().saturating_sub(1) as f64).round() as usize);
        let [slow, fast] = [*at(ALIKE)?, *at(1.0 - ALIKE)?];
        let fallen = self.viscous.interval[1] * (fast - slow);
        let falls = fallen < -FALLS_SHARE * self.coulomb.value.abs();
        if fast > LEAST_RATIO * slow && !falls {
            return None;
        }
        // Where speed hardly changes the two together are told, and each of them may be all of it.
        let drag = self.coulomb.value + self.viscous.value * slow;
        let hull = |[low, high]: [f64; 2], most: f64| [low.min(0.0), high.max(most)];
        self.coulomb.interval = hull(self.coulomb.interval, drag);
        self.viscous.interval = hull(self.viscous.interval, drag / slow);
        let why = if falls {
            "friction falls with speed at those of this log".to_owned()
        } else {
            format!("the axis moves at {slow:.3} to {fast:.3} per s for most of the time")
        };
        Some(format!(
            "Coulomb and viscous friction apart, because {why}: move steadily at several speeds, the fastest five times the slowest"
        ))
    }

    /// The deceleration up to which friction stops the axis without the motor, per s^2: beyond, a
    /// load behind a gap leaves the flank that drives it. `None` where the log does not tell it.
    pub fn held_deceleration(&self) -> Option<f64> {
        let [least, _] = self.coulomb.interval;
        let [positive, most] = self.inertia.interval;
        (least > 0.0 && positive > 0.0).then(|| least / most)
    }
}

/// Both directions of a coefficient, where they certainly differ.
fn directions(found: &SquaresFit<COEFFICIENTS>, both: usize, signed: usize) -> Option<[Figure; 2]> {
    let other = found.figures[signed];
    let of = |sign: f64| {
        let value = |x: &[f64; COEFFICIENTS]| x[both] + sign * x[signed];
        jackknife(value(&found.x), found.without.iter().map(value))
    };
    (other.value.abs() > SURE_ERRORS * other.error).then(|| [of(1.0), of(-1.0)])
}

/// Why no fall of friction with speed is given.
enum NoDecay {
    /// So small a share of the motion is slow.
    SlowMissing(f64),
    /// There is next to none.
    Least(StribeckBound),
    /// Neither is certain.
    Unclear,
}

/// Friction that falls with speed: the speed that explains the log best, and how much it is.
fn decay(
    log: &BodyLog,
    motion: &Motion,
    plain: &SquaresFit<COEFFICIENTS>,
) -> Result<(SquaresFit<COEFFICIENTS>, Stribeck), NoDecay> {
    let at = |speed: f64| Terms {
        stribeck_speed: Some(speed),
        ..Terms::default()
    };
    let speeds = STRIBECK_SHARES.iter().map(|share| share * motion.top_speed);
    let tried: Vec<(f64, SquaresFit<COEFFICIENTS>)> = speeds
        .filter(|&speed| speed > motion.rest_speed)
        .filter_map(|speed| Some((speed, fit(log, motion, &at(speed))?)))
        .collect();
    let best = tried.iter().min_by(|a, b| a.1.rms.total_cmp(&b.1.rms));
    let is_sure = |found: &SquaresFit<COEFFICIENTS>| {
        found.rms < STRIBECK_GAIN * plain.rms
            && found.x[STRIBECK] > SURE_ERRORS * found.figures[STRIBECK].error
            && found.x[COULOMB] > 0.0
    };
    let Some((start, _)) = best.filter(|(_, found)| is_sure(found)) else {
        let slow = slow_share(log, motion);
        if slow < SLOW_WINDOWS {
            return Err(NoDecay::SlowMissing(slow));
        }
        // What the speeds allow at most, from the slowest one on at which that is little.
        let few = |(_, found): &&(f64, SquaresFit<COEFFICIENTS>)| {
            found.figures[STRIBECK].interval[1] < TOLD_SHARE * plain.x[COULOMB]
        };
        let bounded = tried.iter().rev().take_while(few);
        // A friction that certainly rises does not fall.
        let most = |found: &SquaresFit<COEFFICIENTS>| found.figures[STRIBECK].interval[1].max(0.0);
        let least = bounded.map(|(speed, found)| (*speed, most(found)));
        let least = least.reduce(|(_, most), (slower, other)| (slower, most.max(other)));
        return Err(least.map_or(NoDecay::Unclear, |(from_speed, above)| {
            NoDecay::Least(StribeckBound { above, from_speed })
        }));
    };
    // Gauss and Newton's steps on the logarithm of the speed, whose error has a column of its own.
    let mut speed = *start;
    let refined = |speed: f64| Terms {
        refine_stribeck: true,
        ..at(speed)
    };
    for _ in 0..STRIBECK_STEPS {
        let found = fit(log, motion, &refined(speed)).ok_or(NoDecay::Unclear)?;
        let step = found.x[STRIBECK_SPEED] / found.x[STRIBECK];
        let [largest, least] = STRIBECK_STEP;
        speed *= math::exp(step.clamp(-largest, largest));
        if !(motion.rest_speed..STRIBECK_LIMIT * motion.top_speed).contains(&speed) {
            return Err(NoDecay::Unclear);
        }
        if step.abs() < least {
            break;
        }
    }
    let mut found = fit(log, motion, &refined(speed)).ok_or(NoDecay::Unclear)?;
    let off = |x: &[f64; COEFFICIENTS]| x[STRIBECK_SPEED] / x[STRIBECK];
    let logarithm = jackknife(off(&found.x), found.without.iter().map(off));
    // An interval of more than a factor of e either way is none.
    if !is_sure(&found) || logarithm.error.is_nan() || logarithm.interval[1] > 1.0 {
        return Err(NoDecay::Unclear);
    }
    // What other choices make of a figure belongs to its interval.
    let (mut off_by, mut others) = (0.0_f64, Vec::new());
    for other in [Other::Windows, Other::Speeds, Other::Rows, Other::Turns] {
        let terms = Terms {
            other,
            ..refined(speed)
        };
        let again = fit(log, motion, &terms).ok_or(NoDecay::Unclear)?;
        others.push(again.x);
        off_by = off_by.max((off(&again.x) - off(&found.x)).abs());
    }
    found.widen_to(&others);
    let logarithm = logarithm.widened(off_by);
    let by_direction = Terms {
        sided_stribeck: true,
        ..at(speed)
    };
    let sided = fit(log, motion, &by_direction);
    let stribeck = Stribeck {
        above: found.figures[STRIBECK],
        sided: sided.and_then(|sided| directions(&sided, STRIBECK, STRIBECK_SIGN)),
        speed: Figure {
            value: speed,
            error: speed * logarithm.error,
            interval: logarithm.interval.map(|end| speed * math::exp(end)),
        },
    };
    Ok((found, stribeck))
}

/// The speeds of the windows in which the axis moves, per s, in their order.
fn speeds(log: &BodyLog, motion: &Motion) -> Vec<f64> {
    let rates = Rates::new(&log.motor, motion.half, log.period_s);
    let windows = motion.half..log.len().saturating_sub(motion.half);
    let mut speeds: Vec<f64> = windows
        .map(|at| rates.velocity(at).abs())
        .filter(|&speed| speed > motion.rest_speed)
        .collect();
    speeds.sort_by(f64::total_cmp);
    speeds
}

/// The share of the moving windows that are slow.
fn slow_share(log: &BodyLog, motion: &Motion) -> f64 {
    let speeds = speeds(log, motion);
    let slow = speeds.partition_point(|&speed| speed < SLOW_SHARE * motion.top_speed);
    slow as f64 / f64::max(speeds.len() as f64, 1.0)
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

/// Which terms of friction are fitted beside the plain ones.
#[derive(Default)]
struct Terms {
    /// A fall with speed, at this speed.
    stribeck_speed: Option<f64>,
    /// The error of that speed.
    refine_stribeck: bool,
    /// Another fall in either direction.
    sided_stribeck: bool,
    /// Another viscous friction in either direction.
    sided_viscous: bool,
    /// What is done otherwise, to see what it makes of the figures.
    other: Other,
}

/// Choices of the fit on which a figure should not hang.
#[derive(Clone, Copy, Default, PartialEq)]
enum Other {
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
}

/// Windows in which the axis moves one way, as rows.
fn fit(log: &BodyLog, motion: &Motion, terms: &Terms) -> Option<SquaresFit<COEFFICIENTS>> {
    let half = match terms.other {
        Other::Windows => motion.half * 3 / 2,
        _ => motion.half,
    };
    let rates = Rates::new(&log.motor, half, log.period_s);
    // The servo holds its signal for a turn, of a length that the log does not tell: up to the whole time
    // between its rows.
    let turn = (SLOWEST_TURN_S / log.period_s).min(1.0);
    let held = match terms.other {
        Other::Turns => turn * turn,
        _ => 0.5 * turn * turn,
    };
    let drive = Averages::between(&log.drive, half, 1.0 - held);
    // Speeds within a window are taken over half of it.
    let near = (half / 2).max(2);
    let close = Rates::new(&log.motor, near, log.period_s);
    let load = (!log.load.is_empty()).then(|| {
        let whole = Rates::new(&log.load, half, log.period_s);
        (whole, Rates::new(&log.load, near, log.period_s))
    });
    let margin = half + near + 1;
    // The fall with speed is no straight line: within a window it is averaged, not taken at the
    // average speed.
    let falls = terms.stribeck_speed.map(|speed| {
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
        (Averages::new(&decay, half), Averages::new(&slope, half))
    });
    let mut noise = [&log.load, &log.drive].map(|column| Noise::of(column));
    let mut squares = Squares::new(log.len());
    // Neighbouring windows share most of their samples: half of them say as much.
    let stride = (half / 4).max(1);
    for at in (margin..log.len().saturating_sub(margin)).step_by(stride) {
        let velocity = rates.velocity(at);
        let sign = velocity.signum();
        // The ends of the window weigh little, but a body that sticks there tells nothing of
        // friction that falls with speed.
        let whole = falls.is_some() != (terms.other == Other::Rows);
        let reach = if whole { half } else { half / 2 };
        let one_way = [at - reach, at - half / 2, at, at + half / 2, at + reach]
            .iter()
            .all(|&place| close.velocity(place) * sign > motion.rest_speed);
        if !one_way || log.touches_lost(at - half..=at + half) {
            continue;
        }
        // While the motor crosses a gap the load's friction is not that of motion.
        let follows = |place: usize| {
            load.as_ref().is_none_or(|(_, load)| {
                let speed = close.velocity(place);
                (load.velocity(place) - speed).abs() < FOLLOWS_SHARE * speed.abs()
            })
        };
        if ![at - half, at - half / 2, at, at + half / 2, at + half]
            .into_iter()
            .all(follows)
        {
            continue;
        }
        let acceleration = rates.acceleration(at);
        if terms.other == Other::Driven {
            let before = at.checked_sub(DRIVEN_FOR * half);
            let brakes = acceleration * sign < -BRAKES_SHARE * motion.top_acceleration;
            let since = before.is_some_and(|before| {
                (before..at)
                    .step_by(near)
                    .all(|place| place < margin || close.velocity(place) * sign > motion.rest_speed)
            });
            if brakes || !since {
                continue;
            }
        }
        // An axis that passes the fall within a few samples does not show its form.
        let passes = |speed: f64| {
            let slowest = velocity.abs() - acceleration.abs() * half as f64 * log.period_s;
            slowest < FALLEN * speed && acceleration.abs() * log.period_s > QUICK * speed
        };
        if terms.other != Other::Rows && terms.stribeck_speed.is_some_and(passes) {
            continue;
        }
        noise
            .iter_mut()
            .for_each(|noise| noise.add(at - half, at + half));
        let (decay, slope) = falls.as_ref().map_or((0.0, 0.0), |(decay, slope)| {
            (decay.mean(at), slope.mean(at))
        });
        let (before, here) = (drive.mean(at - 1), drive.mean(at));
        let mut row = [0.0; COEFFICIENTS];
        row[INERTIA] = acceleration;
        row[VISCOUS] = velocity;
        row[COULOMB] = sign;
        row[CONSTANT] = 1.0;
        row[STRIBECK] = decay;
        row[VISCOUS_SIGN] = velocity.abs();
        row[STRIBECK_SPEED] = slope;
        row[STRIBECK_SIGN] = sign * decay;
        if let Some((load, _)) = &load {
            row[SLIP_ACCELERATION] = load.acceleration(at) - acceleration;
            row[SLIP_SPEED] = load.velocity(at) - velocity;
        }
        // A drive signal that comes late or early has its own rate as an error, which looks like
        // friction.
        row[LATE] = (before - here) / log.period_s;
        // A servo holds its signal from one sample to the next: half of either window's.
        squares.add(at, row, 0.5 * (before + here));
    }
    let mut used = [true; COEFFICIENTS];
    used[STRIBECK] = terms.stribeck_speed.is_some();
    used[STRIBECK_SPEED] = terms.refine_stribeck;
    used[STRIBECK_SIGN] = terms.sided_stribeck;
    used[VISCOUS_SIGN] = terms.sided_viscous;
    used[SLIP_ACCELERATION] = load.is_some();
    used[SLIP_SPEED] = load.is_some();
    // Noise of three samples with weights 1, -2, 1, and of the means of either half. That of the motor does not
    // count: the windows are as long as it wants.
    let span = half as f64 * log.period_s;
    let [of_load, of_drive] = noise.map(|noise| noise.mean());
    let products = [
        (
            SLIP_ACCELERATION,
            6.0 * of_load / (span * span * span * span),
        ),
        (SLIP_SPEED, 2.0 * of_load / (half as f64 * span * span)),
    ];
    // Counts are no white noise: what taking them out changes belongs to the intervals. Columns that are
    // hardly more than noise are left with it.
    let noisy = squares.clone().solve(&used);
    squares.without_noise(&products);
    let Some(mut found) = squares.solve(&used) else {
        return noisy;
    };
    found.widen_to(&[noisy?.x]);
    if load.is_none() {
        // Of white noise so much is left in the average of a window.
        let white = of_drive * 2.0 / (3.0 * half as f64);
        let left = (found.rms * found.rms - white).max(0.0).sqrt();
        let [size, ..] = squares.sizes();
        found.figures[INERTIA] = found.figures[INERTIA].widened(UNMODELLED_PART * left / size);
    }
    Some(found)
}
