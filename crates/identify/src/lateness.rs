//! A load whose position is read later or earlier than the motor's, by less than can be taken off before.
//!
//! What is read late by `tau` is `tau v` behind. That looks like viscous friction winding the shaft up
//! and, at one speed, like a gap. The contact torque is known, so that a log of several speeds tells
//! the two apart: a column of the motor's speed in the fit then holds the lateness. Where it does not,
//! the gap hangs on what lateness is presumed, and its interval holds those up to
//! [`FitSettings::lateness_s`].

use crate::{
    body::LoadOff,
    contact::Contact,
    error::{FitError, NotExcited},
    estimate::{
        COMPLIANCE, COULOMB, DAMPING, Estimate, EstimateJob, GAP, INERTIA, OFFSET, PLACE, SPEED,
        VISCOUS,
    },
    instruments::{self, Beside, Exact},
    log::BacklashLog,
    settings::FitSettings,
    solver::QpSolver,
    window::WindowSample,
};

/// Lateness by which its effect on gap and compliance is tried, s: both change in proportion.
const PROBE_S: f64 = 10e-6;
/// Systematic error of a lateness that was found, s. A choice: the current between two rows is not their mean.
const MODEL_ERROR_S: f64 = 0.5e-6;
/// Torque variation within the sides, over its RMS, below which gap and wind-up cannot be told
/// apart. Derived: with a variation of 1 % an error of 0.1 % in the torque is one of 10 % in the
/// compliance.
const MIN_TORQUE_VARIATION: f64 = 0.01;

/// Nothing presumed of how the load is read.
const RIGHT: [f64; 2] = [0.0, 0.0];
/// What an unseen scale makes of the gap, in parts of the half interval, from which on a column for it is tried. A
/// choice: less widens the interval by less than a fifth.
const SCALE_COUNTS_FROM: f64 = 0.2;

/// What lateness and an unseen scale do to the figures of a fit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Lateness {
    /// What the half gap is off by for the most that may be unseen, rad.
    pub(crate) half_gap_rad: f64,
    /// What the compliance is off by for it, rad/(N m).
    pub(crate) compliance_rad_per_nm: f64,
    /// What the half gap is off by for the largest scale of the load that may be unseen, rad.
    pub(crate) scale_half_gap_rad: f64,
    /// What the compliance is off by for it, rad/(N m).
    pub(crate) scale_compliance_rad_per_nm: f64,
    /// Lateness that was found along with the gap and is certain.
    pub(crate) found: Option<LoadOff>,
}

impl Lateness {
    /// How the load is off: what was taken off, with the lateness that the fit tells more closely than the
    /// stretches do.
    pub(crate) fn load_off(&self, log: &BacklashLog) -> Option<LoadOff> {
        match (log.load_off().copied(), self.found) {
            (Some(off), Some(late)) => Some(off.read_as(&late)),
            (off, late) => off.or(late),
        }
    }
}

/// Inputs of the fits of one log's contact.
pub(crate) struct ContactFit<'a> {
    pub(crate) log: &'a BacklashLog,
    pub(crate) settings: &'a FitSettings,
    pub(crate) solver: &'a dyn QpSolver,
    pub(crate) windows: &'a [WindowSample],
    pub(crate) contact: &'a Contact,
    pub(crate) exact: Exact,
    pub(crate) finely: bool,
}

/// An estimate with the contact whose samples it is from.
pub(crate) struct Fitted {
    pub(crate) contact: Contact,
    pub(crate) estimate: Estimate,
    pub(crate) lateness: Lateness,
}

impl ContactFit<'_> {
    /// The estimate that goes with how the load is read.
    pub(crate) fn fitted(&self) -> Result<Fitted, FitError> {
        if self.log.load_off().is_some() {
            // What is left of a load that was put right is found along with the gap, and belongs to its
            // interval.
            return self.alone(Beside::PlaceAndSpeed, RIGHT);
        }
        let (fitted, beside) = if self.log.late_s() == 0.0 {
            self.beside_lateness()?
        } else {
            // So is what is left of lateness that was taken off.
            (self.alone(Beside::Speed, RIGHT)?, Beside::Speed)
        };
        self.beside_scale(fitted, beside)
    }

    /// A fit of some columns with what a scale that is too small to be taken off makes of it; where that is more
    /// than what a column of the place costs, with that column.
    fn beside_scale(&self, mut fitted: Fitted, beside: Beside) -> Result<Fitted, FitError> {
        let unseen = self.log.unseen_scale();
        if unseen == 0.0 {
            return Ok(fitted);
        }
        let shifted = self.alone(beside, [0.0, unseen])?.estimate;
        let off = |at: usize| (shifted.coefficients[at] - fitted.estimate.coefficients[at]).abs();
        let (half_gap_rad, compliance_rad_per_nm) = (off(GAP), off(COMPLIANCE));
        let lateness = &mut fitted.lateness;
        (
            lateness.scale_half_gap_rad,
            lateness.scale_compliance_rad_per_nm,
        ) = (half_gap_rad, compliance_rad_per_nm);
        let scatter = fitted.estimate.gap_spread.half_width;
        if half_gap_rad < SCALE_COUNTS_FROM * scatter {
            return Ok(fitted);
        }
        let bound = scatter + lateness.half_gap_rad + half_gap_rad;
        match self.alone(Beside::PlaceAndSpeed, RIGHT) {
            Ok(free) if free.estimate.gap_spread.half_width < bound => Ok(free),
            _ => Ok(fitted),
        }
    }

    /// A fit of a load that may be read later or earlier, with the columns that it has for that.
    fn beside_lateness(&self) -> Result<(Fitted, Beside), FitError> {
        let plain = self.alone(Beside::Nothing, RIGHT)?;
        if self.exact == Exact::Motion {
            // The column of the motor's viscous friction is that of lateness, too.
            return Ok((plain, Beside::Nothing));
        }
        // Little enough for the loss to weigh the samples alike.
        let shifted = self.alone(Beside::Nothing, [PROBE_S, 0.0])?.estimate;
        let off = |at: usize| {
            let change = shifted.coefficients[at] - plain.estimate.coefficients[at];
            self.settings.lateness_s / PROBE_S * change.abs()
        };
        let lateness = Lateness {
            half_gap_rad: off(GAP),
            compliance_rad_per_nm: off(COMPLIANCE),
            ..Lateness::default()
        };
        let bound = plain.estimate.gap_spread.half_width + lateness.half_gap_rad;
        // A log that does not tell it at all may fail here.
        if let Ok(free) = self.alone(Beside::Speed, RIGHT)
            && free.estimate.gap_spread.half_width < bound
        {
            return Ok((free, Beside::Speed));
        }
        Ok((Fitted { lateness, ..plain }, Beside::Nothing))
    }

    /// The estimate with these columns beside those of a load that is read as it should be, for a load
    /// that is presumed to be read so much later, s, and longer, in parts of the travel; see [`RIGHT`].
    fn alone(&self, beside: Beside, [late_s, scale]: [f64; 2]) -> Result<Fitted, FitError> {
        let (mut contact, strength) = instruments::tell(
            self.contact.clone(),
            self.windows,
            self.exact,
            self.finely,
            beside,
        );
        if self.settings.stiffness_nm_per_rad.is_none() {
            check_variation(&contact)?;
            // Where the motor is unknown its columns hold whatever torque the instruments do not tell.
            if self.exact != Exact::Motion && strength < instruments::LEAST_STRENGTH {
                let together_rad = apart(&contact);
                return Err(NotExcited::TorqueHidden { together_rad }.into());
            }
        }
        for sample in &mut contact.samples {
            let window = &mut sample.window;
            window.difference_rad -= late_s * window.velocity_rad_s;
            window.difference_rad += scale * window.position_rad;
        }
        let job = EstimateJob {
            contact: &contact,
            settings: self.settings,
            resolution: self.log.resolution_rad(),
            solver: self.solver,
        };
        let estimate = self.of_columns(&job, beside)?;
        let lateness = Lateness {
            found: estimate.lateness(self.log.all_late_s()),
            ..Lateness::default()
        };
        Ok(Fitted {
            contact,
            estimate,
            lateness,
        })
    }

    /// The estimate with the columns that the settings do not give.
    fn of_columns(&self, job: &EstimateJob<'_>, beside: Beside) -> Result<Estimate, FitError> {
        // Columns beside gap and offset: those that the settings do not give.
        let optional = [
            (COMPLIANCE, self.settings.stiffness_nm_per_rad.is_none()),
            (DAMPING, self.settings.fit_damping),
            (INERTIA, self.settings.motor_inertia_kgm2.is_none()),
        ];
        let optional: Vec<usize> = optional
            .into_iter()
            .filter(|(_, wanted)| *wanted)
            .map(|(column, _)| column)
            .collect();
        let is_motion = self.exact == Exact::Motion;
        // The number of columns is part of the regression's type.
        match (beside, optional.as_slice()) {
            (Beside::PlaceAndSpeed, _) if is_motion => job.estimate([
                GAP, OFFSET, COMPLIANCE, DAMPING, INERTIA, VISCOUS, COULOMB, PLACE,
            ]),
            (_, _) if is_motion => {
                job.estimate([GAP, OFFSET, COMPLIANCE, DAMPING, INERTIA, VISCOUS, COULOMB])
            }
            (Beside::PlaceAndSpeed, []) => job.estimate([GAP, OFFSET, PLACE, SPEED]),
            (Beside::PlaceAndSpeed, &[a]) => job.estimate([GAP, OFFSET, a, PLACE, SPEED]),
            (Beside::PlaceAndSpeed, &[a, b]) => job.estimate([GAP, OFFSET, a, b, PLACE, SPEED]),
            (Beside::PlaceAndSpeed, _) => {
                job.estimate([GAP, OFFSET, COMPLIANCE, DAMPING, INERTIA, PLACE, SPEED])
            }
            (Beside::Speed, []) => job.estimate([GAP, OFFSET, SPEED]),
            (Beside::Speed, &[a]) => job.estimate([GAP, OFFSET, a, SPEED]),
            (Beside::Speed, &[a, b]) => job.estimate([GAP, OFFSET, a, b, SPEED]),
            (Beside::Speed, _) => job.estimate([GAP, OFFSET, COMPLIANCE, DAMPING, INERTIA, SPEED]),
            (Beside::Nothing, []) => job.estimate([GAP, OFFSET]),
            (Beside::Nothing, &[a]) => job.estimate([GAP, OFFSET, a]),
            (Beside::Nothing, &[a, b]) => job.estimate([GAP, OFFSET, a, b]),
            (Beside::Nothing, _) => job.estimate([GAP, OFFSET, COMPLIANCE, DAMPING, INERTIA]),
        }
    }
}

/// Position difference between the two sides, gap and wind-up together.
fn apart(contact: &Contact) -> f64 {
    let mean = |side: f64| {
        let of_side = || contact.samples.iter().filter(|sample| sample.side == side);
        let sum: f64 = of_side().map(|sample| sample.window.difference_rad).sum();
        sum / of_side().count().max(1) as f64
    };
    mean(1.0) - mean(-1.0)
}

/// Gap and wind-up differ only through the torque's variation within the sides.
fn check_variation(contact: &Contact) -> Result<(), NotExcited> {
    let (mut within, mut square) = (0.0, 0.0);
    // Within one side the gap is constant: only the torque's variation shows the compliance.
    for side in [1.0, -1.0] {
        let torques: Vec<f64> = contact
            .samples
            .iter()
            .filter(|sample| sample.side * side > 0.0)
            .map(|sample| sample.window.torque_nm)
            .collect();
        let mean = torques.iter().sum::<f64>() / torques.len().max(1) as f64;
        within += torques
            .iter()
            .map(|torque| (torque - mean) * (torque - mean))
            .sum::<f64>();
        square += torques.iter().map(|torque| torque * torque).sum::<f64>();
    }
    let variation = if square > 0.0 {
        (within / square).sqrt()
    } else {
        0.0
    };
    if variation < MIN_TORQUE_VARIATION {
        Err(NotExcited::TorqueNotVaried { variation })
    } else {
        Ok(())
    }
}

impl Estimate {
    /// How much later than the motor the load is read, where that was fitted and is certain; so much was taken
    /// off before.
    fn lateness(&self, before_s: f64) -> Option<LoadOff> {
        let half = self.speed_spread?.half_width;
        let late_s = before_s + self.coefficients[SPEED];
        (late_s.abs() > half).then(|| LoadOff {
            late_s,
            late_interval_s: [late_s - half - MODEL_ERROR_S, late_s + half + MODEL_ERROR_S],
            ..LoadOff::default()
        })
    }
}
