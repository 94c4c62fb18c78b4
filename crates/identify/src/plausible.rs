//! Whether a log goes with the axis that it is said to be of: units, signs and columns.
//!
//! A log in other units is fitted as smoothly as a right one. But the current has to accelerate the
//! inertia that the description tells: `K_t i = J alpha + F sign(w) + b w + constant`, regressed
//! over all windows in which the axis moves, gives an inertia and a friction. Noise is in the
//! current only, so that the slope is not biased. A wrong unit shows as a known factor on the
//! inertia, a wrong sign as its sign. Motor and load have to travel alike, and a positive torque
//! has to wind the motor up ahead of the load.

use crate::{
    body::MAX_PERIOD_S,
    deadzone::Deadzone,
    error::{Cause, FitError},
    huber::{NormalEquations, Piece, Regression, solve_small},
    log::{BacklashLog, MotorLog},
    settings::FitSettings,
    window::{self, WindowSample},
};

/// Peak current over the rated one that passes. A choice: drives allow three to five times the rated
/// current; in milliamperes a hundredth of it is beyond this.
const MOST_RATED: f64 = 10.0;
/// Half-width of the windows here, s. A choice: long, since strokes last tenths of a second and the
/// current is noisy.
const HALF_WINDOW_S: f64 = 1e-2;
/// How near, as a ratio, the factor of times in a wrong unit has to be for rows that are far apart to be
/// those of a fast log. A choice: what is averaged over few rows is known to so much.
const TIME_TOLERANCE: f64 = 30.0;
/// Ratio of found and described inertia that passes. A choice: a heavy workpiece or a peak value
/// taken for an RMS value pass, no wrong unit does.
const INERTIA_TOLERANCE: f64 = 1.6;
/// Ratio of described and found inertia that passes. A choice: no workpiece makes an axis lighter,
/// but masses are told roughly; a torque of a motor of 0.7 N m/A in place of its current is off by
/// more.
const LIGHTER_TOLERANCE: f64 = 1.3;
/// Standard errors beyond which a difference counts; the textbook error is too small for residuals
/// that hold for many windows. A choice.
const SURE_ERRORS: f64 = 12.0;
/// How near, as a ratio, a factor has to be to that of a wrong unit to be named as its cause. A
/// choice: the load's mass is known to so much.
const CAUSE_TOLERANCE: f64 = 1.25;
/// Difference of the travel of motor and load, in parts of it, that passes. A choice: far above
/// what gap and wind-up take of short strokes, below any wrong unit.
const TRAVEL_TOLERANCE: f64 = 0.2;
/// Least correlation of motor and load position for which one follows the other. A choice.
const MIN_CORRELATION: f64 = 0.99;
/// Difference of motor and load, RMS in rad at the motor, from which on the load would have to follow.
/// A choice: a turn of the motor, far above any gap with its wind-up.
const MAX_APART_RAD: f64 = std::f64::consts::TAU;
/// Travel over the difference of motor and load from which on an axis moves as one body. A choice:
/// a millimetre or two of a usual axis.
const MIN_TRAVEL: f64 = 30.0;

/// Speed of motor and load apart, in parts of the motor's, up to which an axis moves as one body. A choice:
/// far above what wind-up changes by while an axis speeds up, far below what it is across a gap.
const APART_SHARE: f64 = 0.05;
/// Fewest windows in which the axis moves from which an inertia is told. A choice.
const FEWEST_WINDOWS: usize = 20;

/// The axis as one body, as current and acceleration show it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RigidMass {
    /// Inertia of motor and load together, kg m2.
    inertia_kgm2: f64,
    /// Its standard error, kg m2, as of independent windows.
    inertia_error_kgm2: f64,
}

impl RigidMass {
    /// The body that explains the current best; `None` if the axis hardly moves. With the load's position
    /// what the motor does across its gap, alone, is left out.
    fn of(log: &BacklashLog, settings: &FitSettings, with_load: bool) -> Option<Self> {
        let half = (HALF_WINDOW_S / log.period_s()).round().max(1.0) as usize;
        // Without inertia and friction the window's torque is that of the current alone; friction
        // of a trace makes it tell in which windows the motor moves one way.
        let bare = FitSettings {
            motor_viscous_nm_s_per_rad: 0.0,
            motor_coulomb_nm: f64::MIN_POSITIVE,
            ..*settings
        };
        let windows = window::averages(log, &bare, 0.0, half);
        let mut moving: Vec<&WindowSample> =
            windows.iter().filter(|w| w.one_way && w.whole).collect();
        let is_one =
            |w: &&&WindowSample| w.rate_rad_s.abs() <= APART_SHARE * w.velocity_rad_s.abs();
        // A load in other units is never with its motor.
        if with_load && moving.iter().filter(is_one).count() >= FEWEST_WINDOWS {
            moving.retain(|w| is_one(&w));
        }
        let data = Regression::<4> {
            rows: moving
                .iter()
                .map(|w| {
                    [
                        w.acceleration_rad_s2,
                        w.velocity_rad_s.signum(),
                        w.velocity_rad_s,
                        1.0,
                    ]
                })
                .collect(),
            targets: moving.iter().map(|w| w.torque_nm).collect(),
            nonnegative: [false; 4],
        };
        let x = data.least_squares();
        let count = moving.len();
        if count < FEWEST_WINDOWS {
            return None;
        }
        let (mut normal, mut square) = (NormalEquations::<4>::default(), 0.0);
        for (k, row) in data.rows.iter().enumerate() {
            let residual = data.residual(k, &x);
            normal.add(row, residual, Piece::Square);
            square += residual * residual;
        }
        let column = solve_small(&normal.matrix, &[1.0, 0.0, 0.0, 0.0])?;
        Some(Self {
            inertia_kgm2: x[0],
            inertia_error_kgm2: (column[0] * square / (count - 4) as f64).sqrt(),
        })
    }
}

/// Refuses a log whose units, signs or columns cannot be right; `with_load`: it has the load's
/// position.
pub(crate) fn check(
    log: &BacklashLog,
    settings: &FitSettings,
    with_load: bool,
) -> Result<(), FitError> {
    // What the motion shows comes first, since it names the unit.
    motion(log, settings, with_load)?;
    let Some(rated) = settings.rated_torque_nm else {
        return Ok(());
    };
    let rated = rated / settings.torque_constant_nm_per_a;
    let peak = log
        .current()
        .iter()
        .fold(0.0, |most: f64, i| most.max(i.abs()));
    if peak > MOST_RATED * rated {
        return Err(FitError::Implausible {
            what: format!(
                "the current reaches {peak:.4} A, {:.1} times the rated current of the motor",
                peak / rated
            ),
            cause: Cause::CurrentUnit,
        });
    }
    Ok(())
}

impl MotorLog {
    /// Whether units and signs go with the axis of the settings, as every fit asks before it begins:
    /// the current has to accelerate the inertia that they tell.
    ///
    /// # Errors
    /// [`FitError::Implausible`], with what was found and its likely cause.
    pub fn goes_with(&self, settings: &FitSettings) -> Result<(), FitError> {
        check(self.as_backlash_log(), settings, false)
    }
}

/// What the motion shows of it.
fn motion(log: &BacklashLog, settings: &FitSettings, with_load: bool) -> Result<(), FitError> {
    let implausible = |what: String, cause| Err(FitError::Implausible { what, cause });
    if log.period_s() > MAX_PERIOD_S {
        let what = format!("the rows are {} s apart", log.period_s());
        // Acceleration goes with the square of the time: a thousandth of it makes the inertia right.
        let ratio = settings
            .known_inertia_kgm2
            .and_then(|known| Some(RigidMass::of(log, settings, with_load)?.inertia_kgm2 / known));
        let Some(ratio) =
            ratio.filter(|ratio| (1e6 / TIME_TOLERANCE..1e6 * TIME_TOLERANCE).contains(ratio))
        else {
            return implausible(what, Cause::SlowRows);
        };
        let what = format!(
            "{what}, and current and acceleration show {ratio:.3e} times the inertia of the axis"
        );
        return implausible(what, Cause::Milliseconds);
    }
    if with_load {
        let Travel {
            ratio,
            correlation,
            together,
            far,
            apart,
        } = Travel::of(log);
        // Known lengths tell a held load, which a motor winds up against, from a load that goes its
        // own way: a current, or the position of something else.
        if settings.known_inertia_kgm2.is_some() && !together && apart > MAX_APART_RAD {
            let what = format!(
                "the load does not follow the motor (correlation {correlation:.2}, {apart:.1} rad apart at the motor)"
            );
            return implausible(what, Cause::MixedColumns);
        }
        // Both columns have to move alike, whatever the axis.
        if together && (ratio - 1.0).abs() > TRAVEL_TOLERANCE {
            let what = format!("the load moves {ratio:.4} times as far as the motor");
            let cause = if ratio < 0.0 {
                Cause::PositionSigns
            } else {
                Cause::ColumnUnits
            };
            return implausible(what, cause);
        }
        // A motor that winds up against a held load is no axis that moves as one body.
        if !far {
            return Ok(());
        }
    }
    let Some(body) = RigidMass::of(log, settings, with_load) else {
        return Ok(());
    };
    let error = SURE_ERRORS * body.inertia_error_kgm2;
    if body.inertia_kgm2 < -error {
        let what = "the axis accelerates against its current".to_owned();
        return implausible(what, Cause::CurrentSign);
    }
    if let Some(known) = settings.known_inertia_kgm2 {
        let (low, high) = (body.inertia_kgm2 - error, body.inertia_kgm2 + error);
        if low > INERTIA_TOLERANCE * known || high < known / LIGHTER_TOLERANCE {
            let ratio = body.inertia_kgm2 / known;
            let what =
                format!("current and acceleration show {ratio:.4} times the inertia of the axis");
            return implausible(what, cause_of(ratio, settings));
        }
    }
    if with_load && swapped(log, settings) {
        let what = "a positive torque makes the motor fall behind the load".to_owned();
        return implausible(what, Cause::SwappedColumns);
    }
    Ok(())
}

/// Deviations of the counts' rounding up to which motor and load may be apart by it alone. A choice.
const COUNTS_APART: f64 = 3.0;

/// How motor and load position go together.
struct Travel {
    /// Travel of the load over that of the motor.
    ratio: f64,
    /// Of the two positions; zero where one of them rests.
    correlation: f64,
    /// Whether the load's position follows the motor's at all.
    together: bool,
    /// Whether they travel far against their difference.
    far: bool,
    /// Their difference, RMS about its mean.
    apart: f64,
}

impl Travel {
    fn of(log: &BacklashLog) -> Self {
        let count = log.len() as f64;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
        let (motor, load) = (mean(log.motor()), mean(log.load()));
        let (mut motors, mut loads, mut product, mut between) = (0.0, 0.0, 0.0, 0.0);
        for (m, l) in log.motor().iter().zip(log.load()) {
            let (m, l) = (m - motor, l - load);
            motors += m * m;
            loads += l * l;
            product += m * l;
            between += (m - l) * (m - l);
        }
        let size = (motors * loads).sqrt();
        let correlation = if size > 0.0 { product / size } else { 0.0 };
        Travel {
            ratio: product / motors,
            correlation,
            together: correlation.abs() > MIN_CORRELATION,
            far: motors > MIN_TRAVEL * MIN_TRAVEL * between,
            apart: (between / count).sqrt(),
        }
    }
}

/// Whether the torque goes with the position difference the wrong way round. A difference of counts alone
/// goes either way.
fn swapped(log: &BacklashLog, settings: &FitSettings) -> bool {
    if Travel::of(log).apart <= COUNTS_APART * log.resolution_rad() {
        return false;
    }
    let half = window::half_width(settings, log.period_s());
    let inertia = settings.motor_inertia_kgm2.unwrap_or(0.0);
    let windows = window::averages(log, settings, inertia, half);
    // A load that is read earlier than its motor is ahead of it the faster the more.
    is_reversed(windows.clone()) && is_reversed(without_lateness(windows))
}

/// Whether the torque goes better with the position difference the wrong way round.
fn is_reversed(mut windows: Vec<WindowSample>) -> bool {
    let forward = Deadzone::fit(&windows);
    for window in &mut windows {
        window.difference_rad = -window.difference_rad;
    }
    match (forward, Deadzone::fit(&windows)) {
        (forward, Some(reverse)) => forward.is_none_or(|zone| reverse.explains_more_than(&zone)),
        _ => false,
    }
}

/// The same without the part of the position difference that grows with the speed, beside that of its
/// direction.
fn without_lateness(mut windows: Vec<WindowSample>) -> Vec<WindowSample> {
    let certain: Vec<&WindowSample> = windows.iter().filter(|w| w.one_way && w.whole).collect();
    let [late_s, ..] = Regression::<3> {
        rows: certain
            .iter()
            .map(|w| [w.velocity_rad_s, w.velocity_rad_s.signum(), 1.0])
            .collect(),
        targets: certain.iter().map(|w| w.difference_rad).collect(),
        nonnegative: [false; 3],
    }
    .least_squares();
    if late_s.is_finite() {
        for window in &mut windows {
            window.difference_rad -= late_s * window.velocity_rad_s;
        }
    }
    windows
}

/// The wrong unit that goes best with a factor on the inertia.
fn cause_of(ratio: f64, settings: &FitSettings) -> Cause {
    // Current over inertia and current over acceleration: what a wrong unit makes of the inertia.
    let percent = settings
        .rated_torque_nm
        .map(|torque| 100.0 * settings.torque_constant_nm_per_a / torque);
    let known = [
        (Some(1e6), Cause::Milliseconds),
        (percent, Cause::PercentOfRated),
        (
            settings.current_limit_a.map(|limit| 100.0 / limit),
            Cause::PercentOfLimit,
        ),
        (Some(25.4), Cause::Inches),
        (Some(1e3), Cause::Thousand),
        (Some(1e-3), Cause::Micrometres),
        (Some(1.0f64.to_degrees()), Cause::Degrees),
        (Some(1.0f64.to_radians()), Cause::Degrees),
        (Some(std::f64::consts::TAU), Cause::Revolutions),
        (
            settings
                .motor_rad_per_unit
                .map(|angle| std::f64::consts::TAU / angle),
            Cause::Revolutions,
        ),
        (
            settings.motor_rad_per_unit.map(f64::recip),
            Cause::MotorAngle,
        ),
        (
            Some(settings.torque_constant_nm_per_a),
            Cause::TorqueForCurrent,
        ),
    ];
    // At least 1 for positive ratios.
    let off = |factor: f64| (ratio / factor).max(factor / ratio);
    known
        .into_iter()
        .filter_map(|(factor, cause)| Some((off(factor?), cause)))
        .filter(|(off, _)| (1.0..CAUSE_TOLERANCE).contains(off))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(Cause::OtherAxis, |(_, cause)| cause)
}
