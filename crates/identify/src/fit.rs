//! The fit with the load's position known.

use serde::{Deserialize, Serialize};

use crate::{
    contact::{self, Contact, quantile},
    error::{FitError, NotExcited},
    huber::{Minimiser, Regression},
    log::BacklashLog,
    settings::FitSettings,
    solver::{Clarabel, QpSolver, SolveOptions, SolverStatus},
    spread::{self, Spread},
    window,
};

/// Huber's constant: 95 % efficiency on normal residuals.
const HUBER: f64 = 1.345;
/// Rounds in which the residual scale and the fit settle on one another.
const SCALE_ROUNDS: usize = 3;
/// Samples on which they do.
const SCALE_SAMPLES: usize = 2000;
/// Torque variation within the sides, over its RMS, below which gap and wind-up cannot be told apart.
const LEAST_VARIATION: f64 = 0.01;

/// Half gap, compliance and offset of an axis, with what speaks for and against them. Motor side: rad, N m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BacklashFit {
    /// Half gap, rad. The total gap is twice this.
    pub half_gap_rad: f64,
    /// 95 % interval of the half gap, rad, not below zero.
    pub half_gap_interval_rad: [f64; 2],
    /// Standard error of the half gap, rad, from the scatter between blocks of the log.
    pub half_gap_error_rad: f64,
    /// Compliance of the shaft, rad/(N m).
    pub compliance_rad_per_nm: f64,
    /// Standard error of the compliance, rad/(N m); zero where the stiffness was given.
    pub compliance_error_rad_per_nm: f64,
    /// Stiffness of the shaft, N m/rad; none where the fit found no compliance.
    pub stiffness_nm_per_rad: Option<f64>,
    /// Middle of the gap: `theta_M - theta_L` half-way between the flanks, rad.
    pub offset_rad: f64,
    /// RMS of all residuals, rad.
    pub residual_rms_rad: f64,
    /// Robust standard deviation of the residuals (median absolute residual over 0.6745), rad.
    pub residual_scale_rad: f64,
    /// Where the Huber loss turns linear, rad.
    pub huber_delta_rad: f64,
    /// Residuals beyond that.
    pub outliers: usize,
    /// Contact torque from which on a sample counted, N m.
    pub torque_threshold_nm: f64,
    /// Samples in the log.
    pub samples_logged: usize,
    /// Samples that one averaging window advances by.
    pub window_samples: usize,
    /// Window averages used, that is, in firm contact.
    pub samples_used: usize,
    /// Of these with the positive flank in contact.
    pub samples_positive: usize,
    /// Of these with the negative flank in contact.
    pub samples_negative: usize,
    /// Changes of side seen.
    pub traversals: usize,
    /// Blocks of the log behind the standard error.
    pub blocks: usize,
    /// Independent samples that would give the same standard error.
    pub effective_samples: f64,
    /// Whether the log tells the gap from zero.
    pub excited: bool,
    /// If not, why.
    pub reason: Option<NotExcited>,
    /// How the problem was solved.
    pub solver: SolverReport,
}

/// What the solver did.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SolverReport {
    /// Its name.
    pub name: String,
    /// Worst status of the solves behind the result.
    pub status: SolverStatus,
    /// Iterations over these solves.
    pub iterations: u32,
    /// Solves behind the result.
    pub solves: u32,
    /// Samples with variables of their own in the last solve.
    pub explicit_samples: usize,
    /// Gradient of the whole objective at the result, per sample and in scaled units; 0 at the exact minimum.
    pub optimality: f64,
}

/// Fits the gap of an axis with [`Clarabel`].
///
/// # Errors
/// Settings out of range, a log shorter than a window, a log that does not excite the gap, or a solver that fails. A gap that
/// was fitted but cannot be told from zero is no error: see [`BacklashFit::excited`].
pub fn fit_backlash(log: &BacklashLog, settings: &FitSettings) -> Result<BacklashFit, FitError> {
    fit_backlash_with(log, settings, &Clarabel)
}

/// As [`fit_backlash`], with a solver of one's own.
///
/// # Errors
/// As [`fit_backlash`].
pub fn fit_backlash_with(log: &BacklashLog, settings: &FitSettings, solver: &dyn QpSolver) -> Result<BacklashFit, FitError> {
    settings.check()?;
    let half = window::half_width(settings, log.period_s());
    let windows = window::averages(log, settings, half);
    if windows.len() < 3 {
        return Err(FitError::TooShort { samples: log.len(), needed: half.saturating_mul(4).saturating_add(1) });
    }
    let contact = contact::select(&windows, settings, half as f64 * log.period_s())?;
    let sides = |sample: &contact::ContactSample| (sample.side, sample.torque_nm);
    let estimate = if let Some(stiffness) = settings.stiffness_nm_per_rad {
        let compliance = 1.0 / stiffness;
        let rows = contact.samples.iter().map(|sample| [sample.side, 1.0]).collect();
        let targets = contact.samples.iter().map(|sample| sample.difference_rad - compliance * sample.torque_nm).collect();
        let regression = Regression { rows, targets, nonnegative: [true, false] };
        Estimate::of(&regression, log, settings, solver, &contact)?.with_compliance(compliance)
    } else {
        check_variation(&contact)?;
        let rows = contact.samples.iter().map(sides).map(|(side, torque)| [side, 1.0, torque]).collect();
        let targets = contact.samples.iter().map(|sample| sample.difference_rad).collect();
        let regression = Regression { rows, targets, nonnegative: [true, false, true] };
        Estimate::of(&regression, log, settings, solver, &contact)?
    };
    Ok(estimate.report(log, &contact, half, solver.name()))
}

/// Gap and wind-up differ only through the torque's variation within the sides.
fn check_variation(contact: &Contact) -> Result<(), NotExcited> {
    let (mut within, mut square) = (0.0, 0.0);
    for side in [1.0, -1.0] {
        let torques: Vec<f64> = contact.samples.iter().filter(|sample| sample.side * side > 0.0).map(|sample| sample.torque_nm).collect();
        let mean = torques.iter().sum::<f64>() / torques.len().max(1) as f64;
        within += torques.iter().map(|torque| (torque - mean) * (torque - mean)).sum::<f64>();
        square += torques.iter().map(|torque| torque * torque).sum::<f64>();
    }
    let variation = if square > 0.0 { (within / square).sqrt() } else { 0.0 };
    if variation < LEAST_VARIATION { Err(NotExcited::TorqueNotVaried { variation }) } else { Ok(()) }
}

/// Coefficients in the order half gap, offset, compliance, and what was found around them.
struct Estimate {
    half_gap: f64,
    offset: f64,
    compliance: f64,
    gap_spread: Spread,
    compliance_error: f64,
    delta: f64,
    rms: f64,
    scale: f64,
    outliers: usize,
    solver: SolverReport,
}

impl Estimate {
    fn of<const P: usize>(
        regression: &Regression<P>, log: &BacklashLog, settings: &FitSettings, solver: &dyn QpSolver, contact: &Contact,
    ) -> Result<Self, FitError> {
        let options = SolveOptions { tolerance: settings.solver_tolerance, iterations: settings.solver_iterations };
        let delta = match settings.huber_delta_rad {
            Some(delta) => delta,
            None => settle_delta(regression, log.resolution_rad(), solver, &options)?,
        };
        let Minimiser { x, status, iterations, solves, explicit, optimality } = regression.minimise(delta, solver, &options)?;
        let episodes: Vec<usize> = contact.samples.iter().map(|sample| sample.episode).collect();
        let blocks = spread::blocks(&episodes);
        let thin = || NotExcited::TooFewTraversals { seen: contact.traversals, needed: contact.traversals + 1 };
        let gap_spread = spread::spread(regression, &x, delta, &blocks, 0).ok_or_else(thin)?;
        let compliance_error = spread::spread(regression, &x, delta, &blocks, P - 1).ok_or_else(thin)?.standard_error;
        let residuals: Vec<f64> = (0..regression.targets.len()).map(|k| regression.residual(k, &x).abs()).collect();
        Ok(Self {
            half_gap: x[0],
            offset: x[1],
            compliance: x[P - 1],
            gap_spread,
            compliance_error,
            delta,
            rms: (residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len() as f64).sqrt(),
            outliers: residuals.iter().filter(|r| **r > delta).count(),
            scale: quantile(residuals, 0.5) / 0.6745,
            solver: SolverReport { name: String::new(), status, iterations, solves, explicit_samples: explicit, optimality },
        })
    }

    fn with_compliance(self, compliance: f64) -> Self {
        Self { compliance, compliance_error: 0.0, ..self }
    }

    fn report(self, log: &BacklashLog, contact: &Contact, half: usize, solver: &str) -> BacklashFit {
        let (samples_positive, samples_negative) = contact.per_side();
        let interval = [(self.half_gap - self.gap_spread.half_width).max(0.0), self.half_gap + self.gap_spread.half_width];
        let reason = (interval[0] <= 0.0).then_some(NotExcited::GapBelowNoise { half_gap_rad: self.half_gap, upper_rad: interval[1] });
        BacklashFit {
            half_gap_rad: self.half_gap,
            half_gap_interval_rad: interval,
            half_gap_error_rad: self.gap_spread.standard_error,
            compliance_rad_per_nm: self.compliance,
            compliance_error_rad_per_nm: self.compliance_error,
            stiffness_nm_per_rad: (self.compliance > 0.0).then(|| 1.0 / self.compliance),
            offset_rad: self.offset,
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
            solver: SolverReport { name: solver.to_owned(), ..self.solver },
        }
    }
}

/// Delta as a multiple of the residuals' robust scale, which itself depends on the fit: a few rounds on a thinned copy,
/// from least squares. The scale is not let below the encoders' resolution, nor below what rounding leaves of the data.
fn settle_delta<const P: usize>(
    regression: &Regression<P>, resolution: f64, solver: &dyn QpSolver, options: &SolveOptions,
) -> Result<f64, FitError> {
    let thinned = regression.thinned(SCALE_SAMPLES);
    let count = thinned.targets.len().max(1) as f64;
    let size = (thinned.targets.iter().map(|y| y * y).sum::<f64>() / count).sqrt();
    let floor = resolution.max(1e-9 * size).max(f64::MIN_POSITIVE.sqrt());
    // so wide a delta that the first round is least squares
    let mut delta = 1e3 * size + floor;
    for _ in 0..=SCALE_ROUNDS {
        let x = thinned.minimise(delta, solver, options)?.x;
        let residuals = (0..thinned.targets.len()).map(|k| thinned.residual(k, &x).abs()).collect();
        delta = HUBER * (quantile(residuals, 0.5) / 0.6745).max(floor);
    }
    Ok(delta)
}
