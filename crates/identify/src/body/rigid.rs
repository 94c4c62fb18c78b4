//! Inertia and friction of an axis from its motion and what drives it.

use super::squares::{SquaresFit, jackknife};
use super::windows::{
    COEFFICIENTS, CONSTANT, COULOMB, INERTIA, LATE, Other, STRIBECK, STRIBECK_SIGN, STRIBECK_SPEED,
    Terms, VISCOUS, VISCOUS_SIGN, fit,
};
use super::{BodyLog, Figure, Motion, Rates};
use lostmotion_base::math;
use serde::Serialize;

/// Share of missing rows from which on they are why no window is left. A choice.
const LOST_SHARE: f64 = 0.02;
/// Half width of an interval, in parts of the figure, from which on the figure is not told.
const TOLD_SHARE: f64 = 0.5;
/// Share of the drive signal that one body may leave unexplained. A choice: records of stiff axes
/// leave 4 % at most; axes with a gap and a soft shaft whose load is not logged leave 13 % and more,
/// and their intervals do not hold.
const ONE_BODY_SHARE: f64 = 0.08;
/// Share from which on it is not the motion's at all. A choice: the worst of sound logs leaves 0.3.
const UNRELATED_SHARE: f64 = 0.7;
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
/// Fall of the residual by which Stribeck's decay has to pay. A choice.
const STRIBECK_GAIN: f64 = 0.97;

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
    check_log(log, motion)?;
    let plain = fit_plain(log, motion)?;
    let speeds = speeds(log, motion);
    let mut body = RigidBody::of(&plain, &speeds);
    let by_direction = Terms {
        sided_viscous: true,
        ..Terms::default()
    };
    if let Some(sided) = fit(log, motion, &by_direction) {
        let viscous = directions(&sided, VISCOUS, VISCOUS_SIGN);
        body.sided = viscous.map(|viscous| Sided { viscous });
    }
    body.take_decay(decay(log, motion, &plain));
    if body.drag.interval[1] < 0.0 && body.inertia.value > 0.0 {
        return Err(format!(
            "friction would drive the axis, by {:.1} to {:.1}: its columns may be of other times, or of another axis",
            -body.drag.interval[1], -body.drag.interval[0]
        ));
    }
    body.say_what_is_vague(&speeds);
    Ok(body)
}

/// Refuses a log without a drive signal, too slow for accelerations, or of one direction.
fn check_log(log: &BodyLog, motion: &Motion) -> Result<(), String> {
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
    Ok(())
}

/// The fit of the plain terms; what other choices make of a figure belongs to its interval.
///
/// # Errors
/// Why no window is left, or that the drive signal is not the motion's.
fn fit_plain(log: &BodyLog, motion: &Motion) -> Result<SquaresFit<COEFFICIENTS>, String> {
    let mut plain = fit(log, motion, &Terms::default()).ok_or_else(|| {
        let lost = log.lost_share();
        if lost > LOST_SHARE {
            return format!(
                "rows are missing so often, {:.0} % of them, that hardly a stretch of the log is whole: log every row",
                1e2 * lost
            );
        }
        "the axis never moves one way for long enough: make longer strokes at several speeds"
            .to_owned()
    })?;
    let mut others = vec![Other::Windows, Other::Rows, Other::Turns];
    if log.load.is_empty() {
        others.push(Other::Driven);
    }
    if !log.load.is_empty() {
        others.push(Other::OneBody);
    }
    let others = others.into_iter().filter_map(|other| {
        let terms = Terms {
            other,
            ..Terms::default()
        };
        Some(fit(log, motion, &terms)?.x)
    });
    plain.widen_to(&others.collect::<Vec<_>>());
    let share = residual_share(&plain);
    if share > UNRELATED_SHARE {
        return Err(format!(
            "{:.0} % of the drive signal have nothing to do with the motion: it may be another column, or of another axis",
            100.0 * share
        ));
    }
    Ok(plain)
}

/// Residual over drive signal, root mean squares.
fn residual_share(found: &SquaresFit<COEFFICIENTS>) -> f64 {
    found.rms / found.target_rms
}

impl RigidBody {
    /// The body of the plain terms; `speeds` are those of the windows, per s, in their order.
    fn of(plain: &SquaresFit<COEFFICIENTS>, speeds: &[f64]) -> RigidBody {
        let usual = speeds.get(speeds.len() / 2).copied().unwrap_or_default();
        let drag = |x: &[f64; COEFFICIENTS]| x[COULOMB] + x[VISCOUS] * usual;
        RigidBody {
            drag: jackknife(drag(&plain.x), plain.without.iter().map(drag)),
            inertia: plain.figures[INERTIA],
            viscous: plain.figures[VISCOUS],
            coulomb: plain.figures[COULOMB],
            constant: plain.figures[CONSTANT],
            sided: None,
            stribeck: None,
            stribeck_bound: None,
            drive_ahead: plain.figures[LATE],
            residual_share: residual_share(plain),
            rows: plain.rows,
            untold: Vec::new(),
        }
    }

    /// Takes over friction that falls with speed, or says why there is none.
    fn take_decay(&mut self, decay: Result<(SquaresFit<COEFFICIENTS>, Stribeck), NoDecay>) {
        match decay {
            Ok((found, stribeck)) => {
                self.viscous = found.figures[VISCOUS];
                self.coulomb = found.figures[COULOMB];
                self.inertia = found.figures[INERTIA];
                self.constant = found.figures[CONSTANT];
                self.drive_ahead = found.figures[LATE];
                self.residual_share = residual_share(&found);
                self.stribeck = Some(stribeck);
            }
            Err(NoDecay::SlowMissing(share)) => self.untold.push(format!(
                "whether friction falls with speed (Stribeck) cannot be told, because only {:.1} % of the motion is slower than a twentieth of the top speed: move steadily at a tenth, a thirtieth and a hundredth of the top speed, both ways",
                100.0 * share
            )),
            Err(NoDecay::Unclear) => self.untold.push(
                "whether friction falls with speed (Stribeck) cannot be told, because the log fits with and without it: move steadily at a tenth, a thirtieth and a hundredth of the top speed, several times both ways".to_owned(),
            ),
            Err(NoDecay::Least(most)) => self.stribeck_bound = Some(most),
        }
    }

    /// Whether one body explains the drive signal: otherwise the intervals do not hold.
    pub fn is_one_body(&self) -> bool {
        self.residual_share <= ONE_BODY_SHARE
    }

    /// Whether the axis speeds up against what drives it and friction helps it on: the sign of the
    /// drive signal, or of the position, is reversed.
    pub fn is_reversed(&self) -> bool {
        self.inertia.value < 0.0 && self.drag.interval[1] < 0.0
    }

    /// Says of each figure that its interval is wide, and which motion would tell it; `speeds` are those of the
    /// windows, in their order.
    fn say_what_is_vague(&mut self, speeds: &[f64]) {
        let together = self.apart(speeds);
        for (figure, what, how) in [
            (
                self.inertia,
                "the inertia",
                "accelerate harder, at least till the current doubles",
            ),
            (
                self.viscous,
                "the viscous friction",
                "move steadily at speeds of at least one to five",
            ),
            (
                self.coulomb,
                "the Coulomb friction",
                "move steadily both ways at a slow speed",
            ),
        ] {
            let is_said = together.is_some() && figure != self.inertia;
            let half = 0.5 * (figure.interval[1] - figure.interval[0]);
            let share = half / figure.value.abs();
            // A value that is given all the same is not untold, only vague.
            let how_far = if figure.is_told() {
                format!("more closely than {:.0} %", 100.0 * share)
            } else {
                "from zero".to_owned()
            };
            if !(share <= TOLD_SHARE || is_said) {
                self.untold.push(format!("{what} {how_far}: {how}"));
            }
        }
        self.untold.extend(together);
        if !self.is_one_body() {
            self.untold.push(format!(
                "inertia and friction with certainty: {:.0} % of the drive signal is not that of one body; gap and shaft move on their own, and the intervals do not hold",
                100.0 * self.residual_share
            ));
        }
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
