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
/// Share of the encoders' resolution that averages are at best good to: no encoder divides its counts more finely, and
/// errors that recur at the same angles do not average out.
const RESOLVED: f64 = 0.02;
/// Share of the wind-up that the model is at best good to: torque varies between the samples of the log.
const MODELLED: f64 = 5e-5;
/// Torque variation within the sides, over its RMS, below which gap and wind-up cannot be told apart.
const LEAST_VARIATION: f64 = 0.01;

/// Half gap, compliance and offset of an axis, with what speaks for and against them. Motor side: rad, N m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BacklashFit {
    /// Half gap, rad. The total gap is twice this.
    pub half_gap_rad: f64,
    /// 95 % interval of the half gap, rad, not below zero: Student's t times the standard error, and the allowance.
    pub half_gap_interval_rad: [f64; 2],
    /// Standard error of the half gap, rad, from the scatter between blocks of the log.
    pub half_gap_error_rad: f64,
    /// Allowance for what scatter cannot show, rad: 2 % of the encoders' resolution and 0.005 % of the wind-up.
    pub half_gap_allowance_rad: f64,
    /// Compliance of the shaft, rad/(N m).
    pub compliance_rad_per_nm: f64,
    /// Standard error of the compliance, rad/(N m); zero where the stiffness was given.
    pub compliance_error_rad_per_nm: f64,
    /// Stiffness of the shaft, N m/rad; none where the fit found no compliance.
    pub stiffness_nm_per_rad: Option<f64>,
    /// Damping over stiffness of the shaft, less what the current was logged late against the positions, s; zero where it
    /// was not fitted.
    pub damping_time_s: f64,
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
    if settings.stiffness_nm_per_rad.is_none() {
        check_variation(&contact)?;
    }
    let job = Job { contact: &contact, settings, resolution: log.resolution_rad(), solver };
    let estimate = match (settings.stiffness_nm_per_rad, settings.fit_damping) {
        (None, true) => job.estimate([GAP, OFFSET, COMPLIANCE, DAMPING])?,
        (None, false) => job.estimate([GAP, OFFSET, COMPLIANCE])?,
        (Some(_), true) => job.estimate([GAP, OFFSET, DAMPING])?,
        (Some(_), false) => job.estimate([GAP, OFFSET])?,
    };
    Ok(estimate.report(log, &contact, half))
}

/// Gap and wind-up differ only through the torque's variation within the sides.
fn check_variation(contact: &Contact) -> Result<(), NotExcited> {
    let (mut within, mut square) = (0.0, 0.0);
    for side in [1.0, -1.0] {
        let torques: Vec<f64> = contact.samples.iter().filter(|sample| sample.side * side > 0.0).map(|sample| sample.window.torque_nm).collect();
        let mean = torques.iter().sum::<f64>() / torques.len().max(1) as f64;
        within += torques.iter().map(|torque| (torque - mean) * (torque - mean)).sum::<f64>();
        square += torques.iter().map(|torque| torque * torque).sum::<f64>();
    }
    let variation = if square > 0.0 { (within / square).sqrt() } else { 0.0 };
    if variation < LEAST_VARIATION { Err(NotExcited::TorqueNotVaried { variation }) } else { Ok(()) }
}

/// Positions of the coefficients in an [`Estimate`].
const GAP: usize = 0;
const OFFSET: usize = 1;
const COMPLIANCE: usize = 2;
const DAMPING: usize = 3;

/// All that an estimate is made from.
struct Job<'a> {
    contact: &'a Contact,
    settings: &'a FitSettings,
    resolution: f64,
    solver: &'a dyn QpSolver,
}

/// Coefficients and what was found around them.
struct Estimate {
    coefficients: [f64; 4],
    gap_spread: Spread,
    compliance_error: f64,
    delta: f64,
    rms: f64,
    scale: f64,
    outliers: usize,
    solver: SolverReport,
}

impl Job<'_> {
    /// The regression with these columns, the half gap first; what is left out is known, or zero.
    fn regression<const P: usize>(&self, columns: [usize; P]) -> Regression<P> {
        let known = self.settings.stiffness_nm_per_rad.map_or(0.0, |stiffness| 1.0 / stiffness);
        let samples = || self.contact.samples.iter().map(|sample| (sample.side, &sample.window));
        Regression {
            rows: samples()
                .map(|(side, window)| {
                    let all = [side, 1.0, window.torque_nm, -window.rate_rad_s];
                    columns.map(|column| all[column])
                })
                .collect(),
            targets: samples().map(|(_, window)| window.difference_rad - known * window.torque_nm).collect(),
            // the damping time stays free, since a current logged late lowers it
            nonnegative: columns.map(|column| column == GAP || column == COMPLIANCE),
        }
    }

    fn estimate<const P: usize>(&self, columns: [usize; P]) -> Result<Estimate, FitError> {
        let regression = self.regression(columns);
        let options = SolveOptions { tolerance: self.settings.solver_tolerance, iterations: self.settings.solver_iterations };
        let delta = match self.settings.huber_delta_rad {
            Some(delta) => delta,
            None => settle_delta(&regression, self.resolution, self.solver, &options)?,
        };
        let Minimiser { x, status, iterations, solves, explicit, optimality } = regression.minimise(delta, self.solver, &options)?;
        let episodes: Vec<usize> = self.contact.samples.iter().map(|sample| sample.episode).collect();
        let blocks = spread::blocks(&episodes);
        let thin = || NotExcited::TooFewTraversals { seen: self.contact.traversals, needed: self.contact.traversals + 1 };
        let spread = |which| spread::spread(&regression, &x, delta, &blocks, which).ok_or_else(thin);
        let mut coefficients = [0.0, 0.0, self.settings.stiffness_nm_per_rad.map_or(0.0, |stiffness| 1.0 / stiffness), 0.0];
        columns.iter().zip(x).for_each(|(&column, x)| coefficients[column] = x);
        let compliance_error = match columns.iter().position(|&column| column == COMPLIANCE) {
            Some(which) => spread(which)?.standard_error,
            None => 0.0,
        };
        let residuals: Vec<f64> = (0..regression.targets.len()).map(|k| regression.residual(k, &x).abs()).collect();
        Ok(Estimate {
            coefficients,
            gap_spread: spread(0)?,
            compliance_error,
            delta,
            rms: (residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len() as f64).sqrt(),
            outliers: residuals.iter().filter(|r| **r > delta).count(),
            scale: quantile(residuals, 0.5) / 0.6745,
            solver: SolverReport {
                name: self.solver.name().to_owned(),
                status,
                iterations,
                solves,
                explicit_samples: explicit,
                optimality,
            },
        })
    }
}

impl Estimate {
    fn report(self, log: &BacklashLog, contact: &Contact, half: usize) -> BacklashFit {
        let (samples_positive, samples_negative) = contact.per_side();
        let [half_gap, offset, compliance, damping] = self.coefficients;
        let torque_square = contact.samples.iter().map(|sample| sample.window.torque_nm * sample.window.torque_nm).sum::<f64>();
        let wind_up = compliance * (torque_square / contact.samples.len() as f64).sqrt();
        let allowance = RESOLVED * log.resolution_rad() + MODELLED * wind_up;
        let half_width = self.gap_spread.half_width + allowance;
        let interval = [(half_gap - half_width).max(0.0), half_gap + half_width];
        let reason = (interval[0] <= 0.0).then_some(NotExcited::GapBelowNoise { half_gap_rad: half_gap, upper_rad: interval[1] });
        BacklashFit {
            half_gap_rad: half_gap,
            half_gap_interval_rad: interval,
            half_gap_error_rad: self.gap_spread.standard_error,
            half_gap_allowance_rad: allowance,
            compliance_rad_per_nm: compliance,
            compliance_error_rad_per_nm: self.compliance_error,
            stiffness_nm_per_rad: (compliance > 0.0).then(|| 1.0 / compliance),
            offset_rad: offset,
            damping_time_s: damping,
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
            solver: self.solver,
        }
    }
}

/// Delta as a multiple of the residuals' robust scale, which itself depends on the fit: a few rounds on a thinned copy,
/// from least squares. The scale is not let below what the encoders resolve, nor below what rounding leaves of the data.
fn settle_delta<const P: usize>(
    regression: &Regression<P>, resolution: f64, solver: &dyn QpSolver, options: &SolveOptions,
) -> Result<f64, FitError> {
    let thinned = regression.thinned(SCALE_SAMPLES);
    let count = thinned.targets.len().max(1) as f64;
    let size = (thinned.targets.iter().map(|y| y * y).sum::<f64>() / count).sqrt();
    let floor = (RESOLVED * resolution).max(1e-9 * size).max(f64::MIN_POSITIVE.sqrt());
    let scale_around = |x: &[f64; P]| {
        let residuals = (0..thinned.targets.len()).map(|k| thinned.residual(k, x).abs()).collect();
        HUBER * (quantile(residuals, 0.5) / 0.6745).max(floor)
    };
    let mut delta = scale_around(&thinned.least_squares());
    for _ in 0..SCALE_ROUNDS {
        delta = scale_around(&thinned.minimise(delta, solver, options)?.x);
    }
    Ok(delta)
}
