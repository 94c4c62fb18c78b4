//! The fit with the load's position known.

use crate::{
    contact::{self, Contact},
    error::{FitError, NotExcited},
    estimate::{COMPLIANCE, DAMPING, Estimate, GAP, Job, OFFSET, RESOLVED},
    log::BacklashLog,
    result::BacklashFit,
    settings::FitSettings,
    solver::{Clarabel, QpSolver},
    window,
};

/// Share of the wind-up that the model is at best good to: the current between two samples of the log is not their mean. On
/// the simulated axis, whose current loop runs five times per sample, this shifts the torque by 0.03 to 0.04 %.
const MODELLED: f64 = 5e-4;
/// Torque variation within the sides, over its RMS, below which gap and wind-up cannot be told apart.
const LEAST_VARIATION: f64 = 0.01;

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
        let torques: Vec<f64> =
            contact.samples.iter().filter(|sample| sample.side * side > 0.0).map(|sample| sample.window.torque_nm).collect();
        let mean = torques.iter().sum::<f64>() / torques.len().max(1) as f64;
        within += torques.iter().map(|torque| (torque - mean) * (torque - mean)).sum::<f64>();
        square += torques.iter().map(|torque| torque * torque).sum::<f64>();
    }
    let variation = if square > 0.0 { (within / square).sqrt() } else { 0.0 };
    if variation < LEAST_VARIATION { Err(NotExcited::TorqueNotVaried { variation }) } else { Ok(()) }
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
