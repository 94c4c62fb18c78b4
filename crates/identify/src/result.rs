//! The result of a fit.

use lostmotion_drive::config::Gap;
use serde::{Deserialize, Serialize};

use crate::body::LoadOff;
use crate::error::{NotExcited, SolverStatus};

/// Half gap, compliance and offset of an axis, with their uncertainty. Motor side:
/// rad, N m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BacklashFit {
    /// Half gap, rad. The total gap is twice this.
    pub half_gap_rad: f64,
    /// 95 % interval of the half gap, rad, not below zero: Student's t times the standard error,
    /// and the allowance.
    pub half_gap_interval_rad: [f64; 2],
    /// Standard error of the half gap, rad, from the scatter between blocks of the log.
    pub half_gap_error_rad: f64,
    /// Allowance for errors that scatter does not show, rad: 2 % of the encoders' resolution,
    /// 0.05 % of the wind-up and what a late current shifts. Errors of the motor data are not
    /// included (a fit from the motor alone allows 0.3 % of the wind-up, and 1 % of the gap where
    /// the compliance cannot be told from it): a torque constant wrong by a share e shifts the half
    /// gap by up to e times the wind-up.
    pub half_gap_allowance_rad: f64,
    /// The part of that for a load whose position may be read later or earlier than the motor's
    /// ([`FitSettings::lateness_s`](crate::FitSettings::lateness_s)), rad; zero where the log tells it, as one of several speeds does.
    #[serde(default)]
    pub half_gap_lateness_rad: f64,
    /// Compliance of the shaft, rad/(N m).
    pub compliance_rad_per_nm: f64,
    /// Standard error of the compliance, rad/(N m); zero where the stiffness was given.
    pub compliance_error_rad_per_nm: f64,
    /// 95 % interval of the compliance, rad/(N m), not below zero.
    #[serde(default)]
    pub compliance_interval_rad_per_nm: [f64; 2],
    /// Stiffness of the shaft, N m/rad; `None` where it is stiffer than the log can tell: see the
    /// interval's lower end.
    pub stiffness_nm_per_rad: Option<f64>,
    /// 95 % interval of the stiffness, N m/rad; the upper end is `None` where it is stiffer than
    /// the log can tell.
    #[serde(default)]
    pub stiffness_interval_nm_per_rad: [Option<f64>; 2],
    /// Damping over stiffness of the shaft, s, as far as it exceeds what the current was logged
    /// late against the positions: the two act alike; zero where it was not fitted.
    pub damping_time_s: f64,
    /// 95 % interval of the damping time, s, not below zero.
    #[serde(default)]
    pub damping_time_interval_s: [f64; 2],
    /// How much later than the positions the current was logged at least, s.
    #[serde(default)]
    pub current_late_s: f64,
    /// 95 % interval of that, s, not below zero.
    #[serde(default)]
    pub current_late_interval_s: [f64; 2],
    /// Inertia of the motor as given, or as fitted, kg m2.
    pub motor_inertia_kgm2: f64,
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
    /// The load, where it had to be found along with the gap: in a fit from the motor alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load: Option<FittedLoad>,
    /// How the load's scale was off the motor's, which was taken off.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load_off: Option<LoadOff>,
    /// What the half gap would be with a stiffness or a motor that the log and the description of the axis do not
    /// agree on: the interval holds it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub otherwise: Vec<Otherwise>,
    /// How the problem was solved.
    pub solver: SolverReport,
}

/// A half gap that goes with what the fit did not presume.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Otherwise {
    /// What it presumes.
    pub presumed: Presumed,
    /// The half gap, rad.
    pub half_gap_rad: f64,
}

/// What log and description of an axis do not agree on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Presumed {
    /// The stiffness of the shaft as it is described; the log shows quite another one.
    DescribedStiffness,
    /// Inertia and friction of the motor as the log shows them; the described ones give quite another gap.
    MotorOfTheLog,
}

/// A compliance with its interval, and the stiffness that goes with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ToldCompliance {
    pub(crate) compliance_interval_rad_per_nm: [f64; 2],
    pub(crate) stiffness_nm_per_rad: Option<f64>,
    pub(crate) stiffness_interval_nm_per_rad: [Option<f64>; 2],
}

impl ToldCompliance {
    /// For a compliance that is known to this half-width.
    pub(crate) fn new(compliance: f64, half_width: f64) -> Self {
        let [low, high] = [(compliance - half_width).max(0.0), compliance + half_width];
        let inverse = |value: f64| (value > 0.0).then(|| 1.0 / value);
        ToldCompliance {
            compliance_interval_rad_per_nm: [low, high],
            // An interval that holds zero holds a rigid shaft: then only the lower bound is told.
            stiffness_nm_per_rad: inverse(low).and_then(|_| inverse(compliance)),
            stiffness_interval_nm_per_rad: [inverse(high), inverse(low)],
        }
    }
}

impl BacklashFit {
    /// Where `theta_M - theta_L` touches the negative and the positive flank, rad, from the load's
    /// logged zero: half gaps of different size, if that zero is where the axis was when motor and
    /// load were set to agree. Without such an index, and in a fit from the motor alone, only their
    /// sum has a meaning.
    pub fn flanks_rad(&self) -> [f64; 2] {
        [
            self.offset_rad - self.half_gap_rad,
            self.offset_rad + self.half_gap_rad,
        ]
    }

    /// The total gap, as the settings of an axis take it.
    pub fn total_gap(&self) -> Gap {
        Gap::MotorRad(2.0 * self.half_gap_rad)
    }
}

/// Load at the motor's shaft, as a fit from the motor alone found it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FittedLoad {
    /// Inertia, kg m2.
    pub inertia_kgm2: f64,
    /// Viscous friction, N m s/rad.
    pub viscous_nm_s_per_rad: f64,
    /// Coulomb friction, N m.
    pub coulomb_nm: f64,
    /// Constant torque against the positive direction, N m.
    pub constant_nm: f64,
}

/// How the solver reached the result.
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
    /// Gradient of the whole objective at the result, per sample and in scaled units; 0 at the
    /// exact minimum.
    pub optimality: f64,
}
