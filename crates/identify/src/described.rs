//! What a description of the axis says beside the log: where the two contradict each other, the gap that goes with
//! the other one of them belongs to its interval, or the description is refused.

use crate::{
    error::{Cause, FitError, NotExcited},
    result::{BacklashFit, Otherwise, Presumed},
    settings::FitSettings,
};

/// Half-widths of their intervals by which two gaps are certainly two. A choice: intervals hold 95 of 100
/// gaps, and a right description must not be refused.
const APART_WIDTHS: f64 = 3.0;
/// Factor by which the stiffness that a log shows has to be off the described one. A choice: what is taken from
/// catalogues leaves out joints, which make a shaft softer by half.
const STIFFNESS_FACTOR: f64 = 3.0;

/// A log's fits with a description.
pub(crate) struct Described<'a> {
    pub(crate) settings: &'a FitSettings,
    /// The fit with other settings.
    pub(crate) refit: &'a dyn Fn(&FitSettings) -> Result<BacklashFit, FitError>,
    /// Whether neither its times nor its load were off.
    pub(crate) is_clean: bool,
}

impl Described<'_> {
    /// The fit with what its interval has to hold for the description.
    pub(crate) fn held_against(&self, mut fit: BacklashFit) -> Result<BacklashFit, FitError> {
        if let Some(alone) = self.with_the_logs_motor(&fit) {
            if self.is_clean {
                return Err(contradiction(&fit, &alone));
            }
            fit.join(Presumed::MotorOfTheLog, &alone);
        }
        match self.with_described_stiffness(&fit) {
            Some(Ok(stiff)) => fit.join(Presumed::DescribedStiffness, &stiff),
            // With what is described the log tells no gap.
            Some(Err(
                why @ FitError::NotExcited(
                    NotExcited::IntervalTooWide { .. } | NotExcited::LatenessUnknown { .. },
                ),
            )) => return Err(why),
            Some(Err(_)) | None => {}
        }
        Ok(fit)
    }

    /// The fit without the description of the motor, where the log tells the gap without it, and another one. A
    /// torque constant or a lead that is a little off passes for a workpiece in the inertia, while inertia and
    /// friction of the motor, taken off a torque in another scale, bend the wind-up.
    fn with_the_logs_motor(&self, fit: &BacklashFit) -> Option<BacklashFit> {
        let settings = self.settings;
        if !settings.motor_friction_known || settings.motor_inertia_kgm2.is_none() || !fit.excited {
            return None;
        }
        let of_log = FitSettings {
            motor_friction_known: false,
            motor_inertia_kgm2: None,
            motor_viscous_nm_s_per_rad: 0.0,
            motor_coulomb_nm: 0.0,
            ..*settings
        };
        let alone = (self.refit)(&of_log).ok()?;
        let apart = (fit.half_gap_rad - alone.half_gap_rad).abs();
        (apart > APART_WIDTHS * (half_width(fit) + half_width(&alone))).then_some(alone)
    }

    /// The fit with the stiffness that is described, where the log shows quite another one: in a motion of one
    /// frequency the torque hardly changes on a flank, and little passes for wind-up.
    fn with_described_stiffness(&self, fit: &BacklashFit) -> Option<Result<BacklashFit, FitError>> {
        let settings = self.settings;
        let known = settings.known_stiffness_nm_per_rad?;
        if settings.stiffness_nm_per_rad.is_some() || settings.motor_inertia_kgm2.is_none() {
            return None;
        }
        let factor = if self.is_clean { STIFFNESS_FACTOR } else { 1.0 };
        let [low, high] = fit.compliance_interval_rad_per_nm;
        let described = 1.0 / known;
        if (low / factor..=high * factor).contains(&described) {
            return None;
        }
        let told = FitSettings {
            stiffness_nm_per_rad: Some(known),
            ..*settings
        };
        Some((self.refit)(&told))
    }
}

impl BacklashFit {
    /// Makes the interval hold another fit's.
    fn join(&mut self, presumed: Presumed, other: &BacklashFit) {
        let ([low, high], [other_low, other_high]) =
            (self.half_gap_interval_rad, other.half_gap_interval_rad);
        self.half_gap_interval_rad = [low.min(other_low), high.max(other_high)];
        self.otherwise.push(Otherwise {
            presumed,
            half_gap_rad: other.half_gap_rad,
        });
        if self.excited && self.half_gap_interval_rad[0] <= 0.0 {
            self.excited = false;
            self.reason = Some(NotExcited::GapBelowNoise {
                half_gap_rad: self.half_gap_rad,
                upper_rad: self.half_gap_interval_rad[1],
            });
        }
    }
}

fn half_width(fit: &BacklashFit) -> f64 {
    let [low, high] = fit.half_gap_interval_rad;
    0.5 * (high - low)
}

/// Why the description of the motor cannot be right.
fn contradiction(fit: &BacklashFit, alone: &BacklashFit) -> FitError {
    let percent = |fit: &BacklashFit| 100.0 * half_width(fit) / fit.half_gap_rad;
    FitError::Implausible {
        what: format!(
            "with the motor of the axis the gap is {:.3} times (+-{:.1} %) what it is with the motor that the log itself shows (+-{:.1} %)",
            fit.half_gap_rad / alone.half_gap_rad,
            percent(fit),
            percent(alone),
        ),
        cause: Cause::OtherAxis,
    }
}
