//! Inertia and friction of an axis from its motion and what drives it.

use super::squares::{Squares, SquaresFit};
use super::{Averages, BodyLog, Figure, Motion, Rates};
use lostmotion_base::math;
use serde::Serialize;

/// Half width of an interval, in parts of the figure, from which on the figure is not told.
const TOLD_SHARE: f64 = 0.5;
/// Share of the drive signal that one body may leave unexplained. A choice: records of stiff axes
/// leave 4 % at most, axes with a gap and a soft shaft 13 % and more, and their intervals do not
/// hold.
const ONE_BODY_SHARE: f64 = 0.08;
/// Standard errors from which on a further friction is believed.
const SURE_ERRORS: f64 = 4.0;
/// Speeds that Stribeck's decay is looked for at, in parts of the top speed.
const STRIBECK_SHARES: [f64; 10] = [0.01, 0.015, 0.02, 0.03, 0.045, 0.07, 0.1, 0.15, 0.2, 0.3];
/// Fall of the residual by which Stribeck's decay has to pay. A choice.
const STRIBECK_GAIN: f64 = 0.97;

const INERTIA: usize = 0;
const VISCOUS: usize = 1;
const COULOMB: usize = 2;
const CONSTANT: usize = 3;
const STRIBECK: usize = 4;
const VISCOUS_SIGN: usize = 5;
const LATE: usize = 6;
/// Number of coefficients.
const COEFFICIENTS: usize = 7;

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
    /// Speed at which 37 % of it is left, per s.
    pub speed: f64,
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
    /// Drive signal at any speed: gravity, or an offset.
    pub constant: Figure,
    /// Where the directions have certainly another viscous friction.
    pub sided: Option<Sided>,
    /// Where friction certainly falls with speed.
    pub stribeck: Option<Stribeck>,
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
    let both = [1.0, -1.0].iter().all(|&direction| {
        motion
            .strokes
            .iter()
            .any(|stroke| stroke.direction == direction)
    });
    if !both {
        return Err("the axis moves one way only: move it to and fro, friction and a constant force are told apart by the direction".to_owned());
    }
    let plain = fit(log, motion, None, false).ok_or(
        "the axis never moves one way for long enough: make longer strokes at several speeds",
    )?;
    let mut body = RigidBody {
        inertia: plain.figures[INERTIA],
        viscous: plain.figures[VISCOUS],
        coulomb: plain.figures[COULOMB],
        constant: plain.figures[CONSTANT],
        sided: None,
        stribeck: None,
        drive_ahead: plain.figures[LATE],
        residual_share: plain.rms / plain.target_rms,
        rows: plain.rows,
        untold: Vec::new(),
    };
    if let Some(sided) = fit(log, motion, None, true) {
        let other = sided.figures[VISCOUS_SIGN];
        if other.value.abs() > SURE_ERRORS * other.error {
            let of = |sign: f64| {
                let value = |x: &[f64; COEFFICIENTS]| x[VISCOUS] + sign * x[VISCOUS_SIGN];
                super::squares::jackknife(value(&sided.x), sided.without.iter().map(value))
            };
            body.sided = Some(Sided {
                viscous: [of(1.0), of(-1.0)],
            });
        }
    }
    let steps = STRIBECK_SHARES.iter().map(|share| share * motion.top_speed);
    let best = steps
        .filter(|&speed| speed > motion.rest_speed)
        .filter_map(|speed| Some((speed, fit(log, motion, Some(speed), false)?)))
        .min_by(|a, b| a.1.rms.total_cmp(&b.1.rms));
    match best {
        Some((speed, found))
            if found.rms < STRIBECK_GAIN * plain.rms
                && found.x[STRIBECK] > SURE_ERRORS * found.figures[STRIBECK].error
                && found.x[COULOMB] > 0.0 =>
        {
            body.viscous = found.figures[VISCOUS];
            body.coulomb = found.figures[COULOMB];
            body.inertia = found.figures[INERTIA];
            body.constant = found.figures[CONSTANT];
            body.drive_ahead = found.figures[LATE];
            body.residual_share = found.rms / found.target_rms;
            body.stribeck = Some(Stribeck {
                above: found.figures[STRIBECK],
                speed,
            });
        }
        _ => body.untold.push(
            "whether friction falls with speed (Stribeck): move at a tenth, a thirtieth and a hundredth of the top speed, both ways".to_owned(),
        ),
    }
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
        if !told(figure) {
            body.untold.push(what.to_owned());
        }
    }
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
}

/// Windows in which the axis moves one way, as rows.
fn fit(
    log: &BodyLog,
    motion: &Motion,
    stribeck_speed: Option<f64>,
    sided: bool,
) -> Option<SquaresFit<COEFFICIENTS>> {
    let half = motion.half;
    let rates = Rates::new(&log.motor, half, log.period_s);
    let drive = Averages::new(&log.drive, half);
    // Speeds within a window are taken over half of it.
    let near = (half / 2).max(2);
    let close = Rates::new(&log.motor, near, log.period_s);
    let margin = half + near + 1;
    let mut squares = Squares::new(log.len());
    // Neighbouring windows share most of their samples: half of them say as much.
    let stride = (half / 4).max(1);
    for at in (margin..log.len().saturating_sub(margin)).step_by(stride) {
        let velocity = rates.velocity(at);
        let sign = velocity.signum();
        // The ends of the window weigh little.
        let one_way = [at - half / 2, at, at + half / 2]
            .iter()
            .all(|&place| close.velocity(place) * sign > motion.rest_speed);
        if !one_way || log.touches_lost(at - half..=at + half) {
            continue;
        }
        let decay = stribeck_speed.map_or(0.0, |speed| {
            let ratio = velocity / speed;
            math::exp(-ratio * ratio)
        });
        let (before, here) = (drive.mean(at - 1), drive.mean(at));
        let mut row = [0.0; COEFFICIENTS];
        row[INERTIA] = rates.acceleration(at);
        row[VISCOUS] = velocity;
        row[COULOMB] = sign;
        row[CONSTANT] = 1.0;
        row[STRIBECK] = sign * decay;
        row[VISCOUS_SIGN] = velocity.abs();
        // A drive signal that comes late or early has its own rate as an error, which looks like
        // friction.
        row[LATE] = (before - here) / log.period_s;
        // A servo holds its signal from one sample to the next: half of either window's.
        squares.add(at, row, 0.5 * (before + here));
    }
    let mut used = [true; COEFFICIENTS];
    used[STRIBECK] = stribeck_speed.is_some();
    used[VISCOUS_SIGN] = sided;
    squares.solve(&used)
}
