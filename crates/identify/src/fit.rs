//! The fit with the load's position known.

use crate::{
    body::Motion,
    contact::{self, Contact},
    deadzone::MotorGuess,
    described::Described,
    error::{FitError, NotExcited, SolverStatus},
    estimate::{COMPLIANCE, Estimate, INERTIA, RESOLUTION_SHARE},
    instruments::{self, Exact},
    jitter,
    lateness::{ContactFit, Fitted, Lateness},
    log::BacklashLog,
    plausible,
    result::{BacklashFit, ToldCompliance},
    rounding::{Rounded, Row},
    settings::FitSettings,
    solver::{Clarabel, QpSolver},
    window,
};
use lostmotion_base::math::quantile;

/// Systematic error of the model as a share of the wind-up: the current between two samples of the
/// log is not their mean. Measured on the simulated axis, whose current loop runs five times per
/// sample: 0.03 to 0.04 %.
const MODEL_ERROR_SHARE: f64 = 5e-4;
/// Systematic error of averages as a share of the encoders' resolution where it is coarse beside the
/// wind-up: at speeds of whole counts per row rounding is the same over a stroke. A choice: without it
/// 82 of 100 intervals of stiffnesses held in logs of 5 mm/s with counts of 1 um and rows every 1 ms.
const COARSE_SHARE: f64 = 0.2;
/// Fits in a row where the motor's inertia is unknown: each takes the sides from the inertia that
/// the one before found. A choice: each round corrects what is left of the inertia's error by an
/// order; more only cost time.
const INERTIA_ROUNDS: usize = 4;
/// Rounds in which what a fit finds of the load's lateness is taken off before the next. A choice: each leaves a
/// tenth of it or less.
const LATENESS_ROUNDS: usize = 3;
/// What lateness makes of the position difference at top speed, in parts of that difference's span, from which
/// on it is taken off. A choice: less moves no window to another flank.
const LATENESS_SHARE: f64 = 0.01;
/// Share of the windows that have to be whole. A choice: a tenth of the rows may be missing at random.
const WHOLE_SHARE: f64 = 0.05;

/// Width of the interval, in parts of the half gap, from which on the gap counts as not told. A
/// choice: the interval then holds gaps that differ by a factor of three.
const MAX_WIDTH_SHARE: f64 = 1.0;

/// Fits the gap of an axis with [`Clarabel`].
///
/// ```
/// use lostmotion_base::math;
/// use lostmotion_drive::{AxisOutput, Setpoint};
/// use lostmotion_identify::{BacklashLog, FitSettings, fit_backlash};
/// use lostmotion_methods::{AxisConfig, MethodId, build_runner};
///
/// // Three seconds of a simulated axis with a gap of 0.2 rad that swings to and fro.
/// let axis = AxisConfig::paper().with_gap(0.2);
/// let setpoints: Vec<Setpoint> = (0..3000)
///     .map(|n| 9.0 * f64::from(n) * 1e-3)
///     .map(math::sin_cos)
///     .map(|(sin, cos)| Setpoint::moving(3.0 * sin, 27.0 * cos, -243.0 * sin))
///     .collect();
/// let mut recorded = AxisOutput::new(true);
/// build_runner(&axis, MethodId::NONE, 0.0)?.push(&setpoints, &mut recorded)?;
/// let log = BacklashLog::from_samples(250e-6, &recorded.trace.unwrap_or_default())?;
/// let fit = fit_backlash(&log, &FitSettings::for_axis(&axis))?;
/// assert!(fit.excited && (2.0 * fit.half_gap_rad / 0.2 - 1.0).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Settings out of range, a log shorter than a window, a log that does not excite the gap, or a
/// solver that fails. A gap that was fitted but cannot be told from zero is no error: see
/// [`BacklashFit::excited`].
pub fn fit_backlash(log: &BacklashLog, settings: &FitSettings) -> Result<BacklashFit, FitError> {
    fit_backlash_with(log, settings, &Clarabel)
}

/// As [`fit_backlash`], with another solver.
///
/// # Errors
/// As [`fit_backlash`].
pub fn fit_backlash_with(
    log: &BacklashLog,
    settings: &FitSettings,
    solver: &dyn QpSolver,
) -> Result<BacklashFit, FitError> {
    settings.check()?;
    plausible::check(log, settings, true)?;
    // A scale that is a little longer, or read a little later, would pass for gap and wind-up.
    let log = &log.put_right();
    // Rows beside their times make the acceleration noisy, and long windows less so.
    let jitter_s = jitter::jitter_s(log);
    let half_window_s = jitter::half_window_s(log, jitter_s, settings.half_window_s);
    let steady = FitSettings {
        half_window_s,
        ..*settings
    };
    let fit = fit_steady(log, &steady, solver).map_err(|error| match error {
        // A log that would tell the gap but for its times.
        FitError::NotExcited(
            NotExcited::IntervalTooWide { .. }
            | NotExcited::MotorUnknown { .. }
            | NotExcited::TooFewTraversals { .. }
            | NotExcited::OneSide { .. },
        ) if half_window_s > settings.half_window_s => NotExcited::TimesWrong {
            jitter_ms: 1e3 * jitter_s,
        }
        .into(),
        other => other,
    })?;
    // Times that are off, and a load that is, bend what the log tells by itself more than its interval.
    let is_clean = half_window_s <= settings.half_window_s && fit.load_off.is_none();
    Described {
        settings: &steady,
        refit: &|other: &FitSettings| fit_steady(log, other, solver),
        is_clean,
    }
    .held_against(fit)
}

/// The fit of a log whose windows are as long as its times want.
fn fit_steady(
    log: &BacklashLog,
    settings: &FitSettings,
    solver: &dyn QpSolver,
) -> Result<BacklashFit, FitError> {
    if !settings.motor_friction_known {
        return fit_unknown(log, settings, solver);
    }
    let mut fit = fit_known(log, settings, solver)?;
    // The flanks are told by the position difference, which lateness moves.
    let mut log = std::borrow::Cow::Borrowed(log);
    for _ in 0..LATENESS_ROUNDS {
        let left_s = left_of_lateness(&log, &fit);
        if left_s == 0.0 {
            break;
        }
        log = std::borrow::Cow::Owned(log.with_late_taken_off(left_s));
        fit = fit_known(&log, settings, solver)?;
    }
    if log.late_s() == 0.0 {
        // What was found but does not matter was not taken off.
        fit.load_off = log.load_off().copied();
    }
    let [low_rad, high_rad] = fit.half_gap_interval_rad;
    // An interval as wide as the gap itself is no value, unless it says that the gap is small.
    if low_rad > 0.0 && high_rad - low_rad > MAX_WIDTH_SHARE * fit.half_gap_rad {
        let is_late = 4.0 * fit.half_gap_lateness_rad > high_rad - low_rad;
        return Err(if is_late {
            NotExcited::LatenessUnknown {
                lateness_ms: 1e3 * settings.lateness_s,
                low_rad,
                high_rad,
            }
            .into()
        } else {
            NotExcited::IntervalTooWide { low_rad, high_rad }.into()
        });
    }
    Ok(fit)
}

/// Lateness that a fit found of the load in a log, beside what was taken off of it, s; zero where that does
/// not matter.
fn left_of_lateness(log: &BacklashLog, fit: &BacklashFit) -> f64 {
    let Some(found) = fit.load_off else {
        return 0.0;
    };
    let left_s = found.late_s - log.all_late_s();
    let top_speed = Motion::in_positions(log.motor(), log.period_s()).top_speed;
    if left_s.abs() * top_speed > LATENESS_SHARE * difference_span(log) {
        left_s
    } else {
        0.0
    }
}

/// The fit where nothing is known of the motor. Its inertia and friction turn up as columns of
/// their own, and wind-up and gap are told apart by the deflection's change with the torque, the
/// acceleration and the velocity: the gap alone changes with the flank and with nothing else.
/// Presumed is that the motor's friction is Coulomb and viscous.
fn fit_unknown(
    log: &BacklashLog,
    settings: &FitSettings,
    solver: &dyn QpSolver,
) -> Result<BacklashFit, FitError> {
    // Friction of the motor is no wind-up, friction of the load is: what is left is a bound.
    let unknown = || NotExcited::MotorUnknown {
        span: difference_span(log),
    };
    // Friction of a trace makes a window tell whether the motor moves one way.
    let bare = FitSettings {
        motor_coulomb_nm: f64::MIN_POSITIVE,
        ..*settings
    };
    let half = window::half_width(settings, log.period_s());
    let guess = MotorGuess::of(&window::averages(log, &bare, 0.0, half)).ok_or_else(unknown)?;
    // The flanks are told by a torque free of the motor's own; what the guess lacks is fitted.
    let guessed = FitSettings {
        motor_viscous_nm_s_per_rad: guess.viscous_nm_s_per_rad,
        motor_coulomb_nm: guess.coulomb_nm.max(f64::MIN_POSITIVE),
        ..*settings
    };
    let fit = match fit_at(log, &guessed, solver, guess.inertia_kgm2) {
        Ok((_, fit)) => fit,
        // Columns that go together leave the gap open: that is for want of the motor's data.
        Err(FitError::NotExcited(
            NotExcited::TooFewTraversals { .. }
            | NotExcited::TorqueNotVaried { .. }
            | NotExcited::TorqueHidden { .. },
        ))
        | Err(FitError::Solver {
            status: SolverStatus::Unbounded,
            ..
        }) => return Err(unknown().into()),
        Err(error) => return Err(error),
    };
    let [low, high] = fit.half_gap_interval_rad;
    // The gap may look like nothing, too, where it hides in the motor's columns.
    if !fit.excited || high - low > MAX_WIDTH_SHARE * fit.half_gap_rad {
        return Err(unknown().into());
    }
    Ok(fit)
}

/// Span of the position difference without the outer hundredths of the log: gap and wind-up.
fn difference_span(log: &BacklashLog) -> f64 {
    let differences = || {
        let pairs = log.motor().iter().zip(log.load());
        pairs.map(|(motor, load)| motor - load).collect()
    };
    quantile(differences(), 0.99) - quantile(differences(), 0.01)
}

/// The fit with the motor's friction as given.
fn fit_known(
    log: &BacklashLog,
    settings: &FitSettings,
    solver: &dyn QpSolver,
) -> Result<BacklashFit, FitError> {
    if let Some(inertia) = settings.motor_inertia_kgm2 {
        return Ok(fit_at(log, settings, solver, inertia)?.1);
    }
    // The sides are told by the contact torque, which needs the inertia: from none on, in rounds.
    let mut inertia = 0.0;
    for _ in 1..INERTIA_ROUNDS {
        inertia = fit_at(log, settings, solver, inertia)?.0;
    }
    Ok(fit_at(log, settings, solver, inertia)?.1)
}

/// The fit with sides taken from the contact torque at this motor inertia, and the inertia that it
/// finds where none is given.
fn fit_at(
    log: &BacklashLog,
    settings: &FitSettings,
    solver: &dyn QpSolver,
    inertia: f64,
) -> Result<(f64, BacklashFit), FitError> {
    let half = window::half_width(settings, log.period_s());
    let windows = window::averages(log, settings, inertia, half);
    // Fewer windows have no neighbours by which slip could be told.
    if windows.len() < 3 {
        return Err(FitError::TooShort {
            samples: log.len(),
            needed: half.saturating_mul(4).saturating_add(1),
        });
    }
    // Windows with a missing row are left out.
    if WHOLE_SHARE * windows.len() as f64
        > windows.iter().filter(|window| window.whole).count() as f64
    {
        let percent = 1e2 * log.lost_share();
        return Err(NotExcited::RowsLost { percent }.into());
    }
    // Windows in firm contact; a log that shows too few of them is refused here.
    let contact = contact::select(&windows, settings, half as f64 * log.period_s())?;
    let exact = match (settings.motor_friction_known, settings.motor_inertia_kgm2) {
        (false, _) => Exact::Motion,
        (true, None) => Exact::Acceleration,
        (true, Some(_)) => Exact::Sides,
    };
    // Of an unknown motor more is to be told than the rounding of slow strokes hides.
    let finely =
        exact == Exact::Motion || instruments::rounds_finely(&contact, log.resolution_rad());
    let Fitted {
        contact,
        estimate,
        lateness,
    } = ContactFit {
        log,
        settings,
        solver,
        windows: &windows,
        contact: &contact,
        exact,
        finely,
    }
    .fitted()?;
    let compliance = estimate.coefficients[COMPLIANCE];
    // The column of the acceleration has the coefficient c (J - J_assumed).
    let found = if compliance > 0.0 {
        (inertia + estimate.coefficients[INERTIA] / compliance).max(0.0)
    } else {
        inertia
    };
    Ok((
        found,
        estimate.report(log, &contact, half, found, finely, &lateness),
    ))
}

impl Estimate {
    /// What the half gap may be off by for rounding that does not average out, rad.
    fn unspread(&self, log: &BacklashLog, contact: &Contact, half: usize) -> f64 {
        let area = (half * half) as f64;
        let samples = contact.samples.iter().zip(&self.gap_pulls);
        let rows = samples.flat_map(|(sample, pull)| {
            // Each window is a triangle of rows.
            (0..=2 * half).map(move |row| Row {
                at: sample.index * half + row,
                stretch: sample.episode,
                side: sample.side,
                weight: pull * (half - half.abs_diff(row)) as f64 / area,
            })
        });
        let rounded = Rounded {
            motor: log.motor(),
            load: log.load(),
            steps: log.rounded_rad(),
            half,
            scale: log.load_off().map_or(0.0, |off| off.scale),
        };
        rounded.unspread(&rows.collect::<Vec<Row>>())
    }

    fn report(
        self,
        log: &BacklashLog,
        contact: &Contact,
        half: usize,
        inertia: f64,
        finely: bool,
        lateness: &Lateness,
    ) -> BacklashFit {
        let (samples_positive, samples_negative) = contact.per_side();
        let [half_gap, offset, compliance, damping, ..] = self.coefficients;
        let torque_square = contact
            .samples
            .iter()
            .map(|sample| sample.window.torque_nm * sample.window.torque_nm)
            .sum::<f64>();
        // Typical wind-up, in whose parts the model's error is allowed for.
        let torque_rms = (torque_square / contact.samples.len() as f64).sqrt();
        let wind_up = compliance * torque_rms;
        // A current that comes late is taken for a mere delay. What delays it is more often a filter,
        // whose lag depends on the frequency: the whole effect of what is certainly late is allowed
        // for.
        let rate_square = contact
            .samples
            .iter()
            .map(|sample| sample.told_rate_rad_s * sample.told_rate_rad_s)
            .sum::<f64>();
        let rate_rms = (rate_square / contact.samples.len() as f64).sqrt();
        let damping_half_width = self.damping_spread.map_or(0.0, |spread| spread.half_width);
        let late_s = (-damping).max(0.0);
        let certainly_late_s = (-damping - damping_half_width).max(0.0);
        let rounding = if finely {
            RESOLUTION_SHARE
        } else {
            COARSE_SHARE
        };
        // Rows that were put between others have their rounding from both.
        let between = if finely || log.load_off().is_none() {
            0.0
        } else {
            0.5 * log.rounded_rad()[1]
        };
        let allowance = self.unspread(log, contact, half).max(between)
            + rounding * log.resolution_rad()
            + MODEL_ERROR_SHARE * wind_up
            + certainly_late_s * rate_rms;
        // Scatter and allowance add up: one is random, the other is not.
        let not_random = allowance + lateness.half_gap_rad + lateness.scale_half_gap_rad;
        let half_width = self.gap_spread.half_width + not_random;
        let interval = [(half_gap - half_width).max(0.0), half_gap + half_width];
        // The same errors seen as wind-up of the usual torque.
        let told = ToldCompliance::new(
            compliance,
            self.compliance_spread
                .map_or(0.0, |spread| spread.half_width + allowance / torque_rms)
                + lateness.compliance_rad_per_nm
                + lateness.scale_compliance_rad_per_nm,
        );
        let reason = (interval[0] <= 0.0).then_some(NotExcited::GapBelowNoise {
            half_gap_rad: half_gap,
            upper_rad: interval[1],
        });
        BacklashFit {
            half_gap_rad: half_gap,
            half_gap_interval_rad: interval,
            half_gap_error_rad: self.gap_spread.standard_error,
            half_gap_allowance_rad: not_random,
            half_gap_lateness_rad: lateness.half_gap_rad,
            compliance_rad_per_nm: compliance,
            compliance_error_rad_per_nm: self
                .compliance_spread
                .map_or(0.0, |spread| spread.standard_error),
            compliance_interval_rad_per_nm: told.compliance_interval_rad_per_nm,
            stiffness_nm_per_rad: told.stiffness_nm_per_rad,
            stiffness_interval_nm_per_rad: told.stiffness_interval_nm_per_rad,
            offset_rad: offset,
            damping_time_s: damping.max(0.0),
            damping_time_interval_s: [damping - damping_half_width, damping + damping_half_width]
                .map(|end| end.max(0.0)),
            current_late_s: late_s,
            current_late_interval_s: [certainly_late_s, late_s + damping_half_width]
                .map(|end| if late_s > 0.0 { end } else { 0.0 }),
            motor_inertia_kgm2: inertia,
            residual_rms_rad: self.rms,
            residual_scale_rad: self.scale,
            huber_delta_rad: self.delta,
            outliers: self.outliers,
            torque_threshold_nm: contact.threshold_nm,
            samples_logged: log.len(),
            window_samples: half,
            samples_used: contact.samples.len(),
            samples_positive,
            samples_negative,
            traversals: contact.traversals,
            blocks: self.gap_spread.blocks,
            effective_samples: self.gap_spread.effective_samples,
            excited: reason.is_none(),
            reason,
            load: None,
            load_off: lateness.load_off(log),
            otherwise: Vec::new(),
            solver: self.solver,
        }
    }
}
