//! From a log to the gap.

use crate::{
    contact::{MEDIAN_OF_NORMAL, noise},
    error::{FitError, NotExcited},
    estimate::RESOLUTION_SHARE,
    huber::HUBER_TUNING,
    jitter,
    log::MotorLog,
    plausible,
    result::{BacklashFit, ToldCompliance},
    settings::FitSettings,
    solver::{Clarabel, QpSolver, SolveOptions},
    spread::{self, Spread},
    window,
};
use lostmotion_base::math::quantile;

use lostmotion_base::math;

use super::load::find_load;
use super::program::{Projected, Solved};
use super::replayed::replayed;
use super::segments::{
    COMMON, COMPLIANCE, Cutter, DAMPING_TIME, Equation, HALF_GAP, INVERSE_INERTIA, Segment,
};
use super::sides::Sides;
use super::uncertainty::{Prior, PriorKnowledge, RoundResult};
use crate::result::FittedLoad;

/// Rounds in which delta and the crossings' choice settle.
const ROUNDS_OF_CHOICE: usize = 3;
/// Standard errors that the compliance has to exceed to be told from the gap. A choice: three
/// sigma.
const MIN_COMPLIANCE_ERRORS: f64 = 3.0;
/// Share of the gap that is allowed for where the compliance cannot be told from it, as in a log
/// that repeats one stroke: scatter does not show what all crossings have in common. Origin
/// unknown, kept.
const BLURRED_GAP_SHARE: f64 = 1e-2;
/// A crossing whose median residual exceeds that of all crossings by more than this factor was
/// labelled wrongly.
const ODD_CROSSING: f64 = 4.0;
/// Noise of the motor's torque, in parts of the largest contact torque, beyond which the load's
/// motion cannot be told from it, of samples [`NOISE_PERIOD_S`] apart. A choice: the tests' logs have
/// up to 0.6 % and are covered, with some 2 % the intervals miss.
const MAX_NOISE_SHARE: f64 = 1e-2;
/// Time between samples for which [`MAX_NOISE_SHARE`] holds, s: white noise averages out with the
/// root of their number.
const NOISE_PERIOD_S: f64 = 1e-3;
/// Error of the model as a share of the wind-up. Tuned on logs whose gap is known: the compliance
/// came out 1 to 2 % too large, because masses that slide together are taken for rigid; the part of
/// this error that is alike on both flanks cancels.
const MODEL_ERROR_SHARE: f64 = 3e-3;
/// The same error as a share of the compliance itself. Tuned on the same logs.
const COMPLIANCE_ERROR_SHARE: f64 = 2e-2;
/// Width of the interval, in parts of the half gap, from which on the gap counts as not told. A
/// choice: a seventh of the gap either way is of use, more hardly.
const MAX_WIDTH_SHARE: f64 = 0.28;
/// Width of the interval, in parts of the half gap, up to which crossings are believed that do not
/// tell the gap from the wind-up. A choice: usual logs at 4 kHz have some 2 %.
const MAX_UNTOLD_WIDTH_SHARE: f64 = 0.1;
/// Time between samples, s, up to which the crossings are believed. Tuned: at 4 kHz their interval
/// holds the gap in at least 19 of 20 of the tests' logs, at 1 kHz in three quarters.
const SURE_PERIOD_S: f64 = 0.5e-3;

/// Fits the gap of an axis from the motor's signals alone, with [`Clarabel`].
///
/// The motor's inertia has to be given.
///
/// # Errors
/// Settings out of range, a log shorter than a window, a log that does not excite the gap, or a
/// solver that fails. A gap that was fitted but cannot be told from zero is no error: see
/// [`BacklashFit::excited`].
pub fn fit_motor_only(log: &MotorLog, settings: &FitSettings) -> Result<BacklashFit, FitError> {
    fit_motor_only_with(log, settings, &Clarabel)
}

/// As [`fit_motor_only`], with another solver.
///
/// # Errors
/// As [`fit_motor_only`].
pub fn fit_motor_only_with(
    log: &MotorLog,
    settings: &FitSettings,
    solver: &dyn QpSolver,
) -> Result<BacklashFit, FitError> {
    settings.check()?;
    let inertia = settings.motor_inertia_kgm2.ok_or(FitError::Setting {
        name: "motor_inertia_kgm2",
        value: 0.0,
        expected: "given, for a fit from the motor alone",
    })?;
    plausible::check(log.as_backlash_log(), settings, false)?;
    let half = window::half_width(settings, log.period_s());
    let crossed = crossed(log, settings, solver, inertia, half);
    // Crossings of a fast log leave nothing to a replay, which takes seconds, if they tell the gap
    // from the wind-up or leave it little.
    let apart = |fit: &BacklashFit| {
        let [low_rad, high_rad] = fit.half_gap_interval_rad;
        !fit.excited
            || fit.stiffness_nm_per_rad.is_some()
            || high_rad - low_rad <= MAX_UNTOLD_WIDTH_SHARE * fit.half_gap_rad
    };
    let sure = log.period_s() <= SURE_PERIOD_S && crossed.as_ref().is_ok_and(apart);
    if sure || matches!(crossed, Err(FitError::TooShort { .. })) {
        return crossed.and_then(told);
    }
    let Some(replayed) = replayed(log, settings) else {
        return crossed.and_then(told);
    };
    match (replayed, crossed) {
        (Ok(fit), _) if fit.excited => told(fit),
        // No gap that could be told from zero: told where the crossings say so, too.
        (Ok(_), Ok(crossed)) if !crossed.excited => Ok(crossed),
        (Ok(fit), _) => {
            let [low_rad, high_rad] = fit.half_gap_interval_rad;
            Err(NotExcited::MotorToldTooLittle { low_rad, high_rad }.into())
        }
        // Too few clear crossings are the cause, save where noise hides them or more of them would
        // not help.
        (Err(reason), Err(FitError::NotExcited(unclear))) => {
            let hidden = matches!(unclear, NotExcited::NoiseHidesLoad { .. })
                || matches!(reason, NotExcited::ShaftTooFast { .. });
            Err(cause(log, if hidden { reason } else { unclear }).into())
        }
        (Err(_), Err(error)) => Err(error),
        (Err(reason), Ok(_)) => Err(cause(log, reason).into()),
    }
}

/// The cause of a misfit: rows beside their times look like a load that is not as modelled.
fn cause(log: &MotorLog, reason: NotExcited) -> NotExcited {
    let rows = log.as_backlash_log();
    let jitter_s = jitter::jitter_s(rows);
    let usual_s = FitSettings::default().half_window_s;
    if jitter::half_window_s(rows, jitter_s, usual_s) > usual_s {
        NotExcited::TimesWrong {
            jitter_ms: 1e3 * jitter_s,
        }
    } else {
        reason
    }
}

/// A fit whose interval is not too wide.
fn told(fit: BacklashFit) -> Result<BacklashFit, FitError> {
    let [low_rad, high_rad] = fit.half_gap_interval_rad;
    if fit.excited && high_rad - low_rad > MAX_WIDTH_SHARE * fit.half_gap_rad {
        return Err(NotExcited::MotorToldTooLittle { low_rad, high_rad }.into());
    }
    Ok(fit)
}

/// The fit over the crossings.
fn crossed(
    log: &MotorLog,
    settings: &FitSettings,
    solver: &dyn QpSolver,
    inertia: f64,
    half: usize,
) -> Result<BacklashFit, FitError> {
    let windows = window::averages(log.as_backlash_log(), settings, inertia, half);
    if windows.len() < 3 {
        return Err(FitError::TooShort {
            samples: log.len(),
            needed: half.saturating_mul(4).saturating_add(1),
        });
    }
    let spacing_s = half as f64 * log.period_s();
    let settle = ((settings.settle_s / spacing_s).ceil() as usize).max(1);
    // Flanks, then the load's inertia and friction, then the crossings that are judged by them.
    let sides = Sides::new(&windows, settings)?;
    // Noise that adds up twice in the load's motion hides the gap before it hides the sides.
    let torque_noise_nm =
        settings.torque_constant_nm_per_a * noise(log.as_backlash_log().current().iter().copied());
    let most_nm = MAX_NOISE_SHARE * sides.largest_nm() * (NOISE_PERIOD_S / log.period_s()).sqrt();
    if torque_noise_nm > most_nm {
        return Err(NotExcited::NoiseHidesLoad {
            noise_nm: torque_noise_nm,
            most_nm,
        }
        .into());
    }
    let needed = settings.min_traversals.max(2);
    let thin = |usable, seen| {
        FitError::NotExcited(NotExcited::CrossingsUnclear {
            usable,
            seen,
            needed,
        })
    };
    let load = find_load(&windows, &sides, settle, settings, solver)?
        .ok_or_else(|| thin(0, sides.changes()))?;
    // One window a sample: a load that breaks away is followed sample by sample.
    let samples = window::averages(log.as_backlash_log(), settings, inertia, 1);
    let cutter = Cutter {
        windows: &windows,
        samples: &samples,
        sides: &sides,
        load: &load,
        spacing_s,
        period_s: log.period_s(),
        half,
        settle,
        motor_inertia_kgm2: inertia,
    };
    let (segments, changes) = cutter.cut();
    if segments.len() < needed {
        return Err(thin(segments.len(), changes));
    }
    let job = MotorOnlyJob {
        log,
        settings,
        solver,
        load,
        changes,
        half,
        knowledge: PriorKnowledge {
            torque_noise_nm,
            period_s: log.period_s(),
            spacing_s,
            load,
            fastest_rad_s: windows
                .iter()
                .map(|window| window.rate_rad_s.abs())
                .fold(0.0, f64::max),
            largest_nm: sides.largest_nm(),
        },
        threshold_nm: sides.threshold_nm,
    };
    job.fit(segments)
}

/// The solver's tolerance here, in parts of the setting: priors in units of a window's deviation
/// make rows of unlike sizes.
const TOLERANCE_FACTOR: f64 = 0.1;

struct MotorOnlyJob<'a> {
    log: &'a MotorLog,
    settings: &'a FitSettings,
    solver: &'a dyn QpSolver,
    load: FittedLoad,
    changes: usize,
    half: usize,
    knowledge: PriorKnowledge,
    threshold_nm: f64,
}

impl MotorOnlyJob<'_> {
    fn fit(&self, mut segments: Vec<Segment>) -> Result<BacklashFit, FitError> {
        let options = SolveOptions {
            tolerance: TOLERANCE_FACTOR * self.settings.solver_tolerance,
            iterations: self.settings.solver_iterations,
        };
        // No residual scale below what the encoder resolves.
        let floor = (RESOLUTION_SHARE * self.log.resolution_rad()).max(1e-12);
        let robust = |residuals: Vec<f64>| (quantile(residuals, 0.5) / MEDIAN_OF_NORMAL).max(floor);
        let mut found = RoundResult {
            deviation: self.log.resolution_rad().max(floor),
            compliance: 1.0,
        };
        // Each round weighs by the scale and the compliance that the one before found.
        for round in 1.. {
            let priors = self.knowledge.priors(&found);
            let data = Projected::new(
                &segments,
                self.knowledge.drift(&found),
                &priors,
                found.deviation,
            );
            let start = data.regression.least_squares();
            // The first round has no scale yet: least squares gives one.
            let first = || {
                robust(
                    (0..data.equations)
                        .map(|k| data.regression.residual(k, &start).abs())
                        .collect(),
                )
            };
            if round == 1 {
                found.deviation = first();
            }
            let delta = self
                .settings
                .huber_delta_rad
                .unwrap_or(HUBER_TUNING * found.deviation);
            let solved = data.solve(delta, self.solver, &options)?;
            let residuals: Vec<f64> = solved
                .residuals
                .iter()
                .take(data.equations)
                .map(|r| r.abs())
                .collect();
            let usual = quantile(residuals.clone(), 0.5);
            found = RoundResult {
                deviation: robust(residuals),
                compliance: solved.x[COMPLIANCE],
            };
            if round == ROUNDS_OF_CHOICE {
                let last = LastRound {
                    job: self,
                    data: &data,
                    priors: &priors,
                    segments: &segments,
                    solved: &solved,
                    delta,
                    scale: found.deviation,
                };
                return last.report();
            }
            // Crossings that do not fit were labelled wrongly: the load rested where it was taken
            // to slide, or the reverse.
            segments = keep(segments, &data, &solved, ODD_CROSSING * usual);
            if segments.len() < self.settings.min_traversals.max(2) {
                break;
            }
        }
        Err(self.unclear(segments.len()).into())
    }

    fn unclear(&self, usable: usize) -> NotExcited {
        NotExcited::CrossingsUnclear {
            usable,
            seen: self.changes,
            needed: self.settings.min_traversals.max(usable + 1),
        }
    }
}

/// The last round of the fit.
struct LastRound<'a> {
    job: &'a MotorOnlyJob<'a>,
    data: &'a Projected<COMMON>,
    priors: &'a [Prior],
    segments: &'a [Segment],
    solved: &'a Solved<COMMON>,
    /// Residual from which on the loss is linear, rad.
    delta: f64,
    /// Robust standard deviation of the residuals, rad.
    scale: f64,
}

/// How well a round tells its coefficients.
struct CoefficientSpreads {
    gap: Spread,
    compliance: Spread,
    damping: Spread,
    /// Standard deviations that the priors leave: rad, and rad/(N m).
    gap_by_priors: f64,
    compliance_by_priors: f64,
}

impl LastRound<'_> {
    /// The fit.
    fn report(&self) -> Result<BacklashFit, FitError> {
        let (job, solved, delta) = (self.job, self.solved, self.delta);
        let spreads = self
            .spreads()
            .ok_or_else(|| job.unclear(self.segments.len()))?;
        let (half_gap, compliance) = (solved.x[HALF_GAP], solved.x[COMPLIANCE]);
        let residuals = self.residuals();
        let allowance = self.allowance_rad(&spreads);
        // Scatter and priors are independent; the allowance is not random and is added.
        let half_width =
            math::hypot(spreads.gap.half_width, 2.0 * spreads.gap_by_priors) + allowance;
        let interval = [(half_gap - half_width).max(0.0), half_gap + half_width];
        let compliance_half_width = math::hypot(
            spreads.compliance.half_width,
            2.0 * spreads.compliance_by_priors,
        );
        let told = ToldCompliance::new(
            compliance,
            compliance_half_width + COMPLIANCE_ERROR_SHARE * compliance,
        );
        let damping = solved.x[DAMPING_TIME];
        let damping_half_width = spreads.damping.half_width;
        let reason = (interval[0] <= 0.0).then_some(NotExcited::GapBelowNoise {
            half_gap_rad: half_gap,
            upper_rad: interval[1],
        });
        let equations = self.equations();
        let positive = equations.filter(|equation| equation.side > 0.0).count();
        Ok(BacklashFit {
            half_gap_rad: half_gap,
            half_gap_interval_rad: interval,
            half_gap_error_rad: spreads.gap.standard_error,
            half_gap_allowance_rad: allowance,
            half_gap_lateness_rad: 0.0,
            compliance_rad_per_nm: compliance,
            compliance_error_rad_per_nm: spreads.compliance.standard_error,
            compliance_interval_rad_per_nm: told.compliance_interval_rad_per_nm,
            stiffness_nm_per_rad: told.stiffness_nm_per_rad,
            stiffness_interval_nm_per_rad: told.stiffness_interval_nm_per_rad,
            offset_rad: 0.0,
            damping_time_s: damping.max(0.0),
            damping_time_interval_s: [damping - damping_half_width, damping + damping_half_width]
                .map(|end| end.max(0.0)),
            current_late_s: (-damping).max(0.0),
            current_late_interval_s: [-damping - damping_half_width, -damping + damping_half_width]
                .map(|end| if damping < 0.0 { end.max(0.0) } else { 0.0 }),
            motor_inertia_kgm2: job.settings.motor_inertia_kgm2.unwrap_or(0.0),
            residual_rms_rad: (residuals.iter().map(|r| r * r).sum::<f64>() / self.count()).sqrt(),
            residual_scale_rad: self.scale,
            huber_delta_rad: delta,
            outliers: residuals.iter().filter(|r| r.abs() > delta).count(),
            torque_threshold_nm: job.threshold_nm,
            samples_logged: job.log.len(),
            window_samples: job.half,
            samples_used: residuals.len(),
            samples_positive: positive,
            samples_negative: residuals.len() - positive,
            traversals: job.changes,
            blocks: spreads.gap.blocks,
            effective_samples: spreads.gap.effective_samples,
            excited: reason.is_none(),
            reason,
            load: Some(self.load()),
            load_off: None,
            otherwise: Vec::new(),
            solver: solved.report.clone(),
        })
    }

    /// How well the coefficients are told; `None` where too few crossings are left to tell it.
    fn spreads(&self) -> Option<CoefficientSpreads> {
        let (data, solved, delta) = (self.data, self.solved, self.delta);
        let profiled = data.profiled(solved, delta);
        // Whole crossings are the blocks of the jackknife.
        let blocks = spread::blocks(&data.segment[..data.equations]);
        let spread = |which| spread::spread(&profiled, &solved.x, delta, &blocks, which);
        let by_priors = |which| data.prior_deviation(&profiled, solved, delta, self.priors, which);
        Some(CoefficientSpreads {
            gap: spread(HALF_GAP)?,
            compliance: spread(COMPLIANCE)?,
            damping: spread(DAMPING_TIME)?,
            gap_by_priors: by_priors(HALF_GAP)?,
            compliance_by_priors: by_priors(COMPLIANCE)?,
        })
    }

    /// The windows' equations.
    fn equations(&self) -> impl Iterator<Item = &Equation> {
        self.segments.iter().flat_map(|segment| &segment.equations)
    }

    /// How many there are.
    fn count(&self) -> f64 {
        self.equations().count().max(1) as f64
    }

    /// Residuals of the windows' equations, rad.
    fn residuals(&self) -> &[f64] {
        &self.solved.residuals[..self.data.equations]
    }

    /// What the gap is told by less beside scatter and priors, rad: resolution, error of the model, and what of a
    /// compliance within its own error may be gap.
    fn allowance_rad(&self, spreads: &CoefficientSpreads) -> f64 {
        let (half_gap, compliance) = (self.solved.x[HALF_GAP], self.solved.x[COMPLIANCE]);
        // Typical wind-up, in whose parts the model's error is allowed for.
        let squares = self.equations().map(|e| e.torque * e.torque);
        let wind_up = compliance * (squares.sum::<f64>() / self.count()).sqrt();
        // A compliance within its own error may be gap, and the gap compliance.
        let told_apart = compliance > MIN_COMPLIANCE_ERRORS * spreads.compliance.standard_error;
        let blurred = if told_apart {
            0.0
        } else {
            BLURRED_GAP_SHARE * half_gap
        };
        RESOLUTION_SHARE * self.job.log.resolution_rad() + MODEL_ERROR_SHARE * wind_up + blurred
    }

    /// The load, with the inertia of this fit in the place of that of the sliding windows, if it found one.
    fn load(&self) -> FittedLoad {
        let inverse_inertia = self.solved.x[INVERSE_INERTIA];
        FittedLoad {
            inertia_kgm2: if inverse_inertia > 0.0 {
                1.0 / inverse_inertia
            } else {
                self.job.load.inertia_kgm2
            },
            ..self.job.load
        }
    }
}

/// The crossings whose median residual is not odd.
fn keep(
    segments: Vec<Segment>,
    data: &Projected<COMMON>,
    solved: &Solved<COMMON>,
    most: f64,
) -> Vec<Segment> {
    let mut medians = vec![Vec::new(); segments.len()];
    for (index, residual) in data
        .segment
        .iter()
        .zip(&solved.residuals)
        .take(data.equations)
    {
        medians[*index].push(residual.abs());
    }
    segments
        .into_iter()
        .zip(medians)
        .filter(|(_, residuals)| quantile(residuals.clone(), 0.5) <= most)
        .map(|(segment, _)| segment)
        .collect()
}
