//! A fit in the terms of the axis: the log in its unit, total gap and stiffness at the load.

#[cfg(doc)]
use crate::LATENESS_S;
use crate::error::FitError;
use crate::fit::fit_backlash;
use crate::log::{BacklashLog, MotorLog};
use crate::motor_only::fit_motor_only;
use crate::result::BacklashFit;
use crate::settings::FitSettings;
use lostmotion_drive::config::{AxisConfig, AxisUnit};
use serde::{Deserialize, Serialize};

/// Version of [`FitResult`].
pub const FIT_SCHEMA: u32 = 1;

/// The gap of an axis from its log, in the unit of the log, as `lostmotion axis fit` writes it.
/// Fields are only ever added within one schema number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FitResult {
    /// [`FIT_SCHEMA`].
    pub schema: u32,
    /// Name of the log.
    pub log: String,
    /// Unit of the log's positions: `mm`, `deg` or `rad`.
    pub unit: String,
    /// Total gap in that unit, at the load.
    pub gap: f64,
    /// 95 % interval of the total gap in that unit.
    pub gap_interval: [f64; 2],
    /// Whether the log tells the gap from zero.
    pub excited: bool,
    /// Radian of the motor for one unit of the log, where the axis was given; otherwise the figures
    /// below are in the log's unit instead of rad, and per A instead of N m.
    pub motor_rad_per_unit: Option<f64>,
    /// Whether the load's positions were left out of it.
    #[serde(default)]
    pub motor_only: bool,
    /// Stiffness of the shaft at the load, where the axis was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<LoadStiffness>,
    /// The fit itself.
    pub fit: BacklashFit,
}

/// Stiffness of the shaft as the load feels it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoadStiffness {
    /// `N/um` or `N m/rad`.
    pub unit: String,
    /// None where the shaft is stiffer than the log can tell.
    pub value: Option<f64>,
    /// 95 % interval; no upper end where the shaft is stiffer than the log can tell.
    pub interval: [Option<f64>; 2],
}

impl LoadStiffness {
    /// Of a fit in motor radian, so many of which make a unit of the log.
    fn new(fit: &BacklashFit, unit: AxisUnit, rad_per_unit: f64) -> LoadStiffness {
        // Force over distance: both turn into torque and angle by the same ratio. A newton per
        // micrometre is 1e6 N/m, and a radian per millimetre 1e3 rad/m, whose square cancels that.
        let (name, ratio) = match unit {
            AxisUnit::Mm => ("N/um", rad_per_unit),
            AxisUnit::Rad => ("N m/rad", rad_per_unit),
            AxisUnit::Deg => ("N m/rad", rad_per_unit.to_degrees()),
        };
        let at_load = |motor: Option<f64>| motor.map(|stiffness| stiffness * ratio * ratio);
        LoadStiffness {
            unit: name.to_owned(),
            value: at_load(fit.stiffness_nm_per_rad),
            interval: fit.stiffness_interval_nm_per_rad.map(at_load),
        }
    }
}

/// A log in one unit that the axis does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the positions are in {}, but the axis is in {}", log.symbol(), axis.symbol())]
pub struct UnitMismatch {
    /// Unit of the log.
    pub log: AxisUnit,
    /// Unit of the axis.
    pub axis: AxisUnit,
}

/// Radian of the motor for a unit of the log.
///
/// # Errors
/// Lengths in the log of an axis that turns, or angles in that of a slide.
pub fn motor_rad_per_unit<C>(config: &AxisConfig<C>, unit: AxisUnit) -> Result<f64, UnitMismatch> {
    let per_axis_unit = config.transmission.motor_rad_per_unit();
    match (unit, config.transmission.unit()) {
        (log, axis) if log == axis => Ok(per_axis_unit),
        // Angles convert into each other; mm and angles do not.
        (AxisUnit::Deg, AxisUnit::Rad) => Ok(per_axis_unit.to_radians()),
        (AxisUnit::Rad, AxisUnit::Deg) => Ok(per_axis_unit.to_degrees()),
        (log, axis) => Err(UnitMismatch { log, axis }),
    }
}

/// Why a log does not give a [`FitResult`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AxisFitError {
    /// The log is in a unit that the axis does not have.
    #[error(transparent)]
    Unit(#[from] UnitMismatch),
    /// The fit refuses.
    #[error(transparent)]
    Fit(#[from] FitError),
}

/// Rows of one axis: what was measured, in one unit.
#[derive(Clone, Copy, Debug)]
pub struct AxisRows<'a> {
    /// Name of the log, for the result.
    pub name: &'a str,
    /// Unit of the positions.
    pub unit: AxisUnit,
    /// Times, s.
    pub time_s: &'a [f64],
    /// Positions of the motor at the load's side of the transmission.
    pub motor: &'a [f64],
    /// Positions of the load; `None` to do without them ([`fit_motor_only`]).
    pub load: Option<&'a [f64]>,
    /// Torque-forming current, A.
    pub current_a: &'a [f64],
    /// How much later or earlier than the motor's the position of the load may be read, s, where the log does
    /// not tell it: [`LATENESS_S`] where nobody knows, zero where one drive reads both at the same time.
    pub lateness_s: f64,
}

/// Fits the gap of an axis to what was measured. With the axis' description motor data are known
/// and the interval is narrower; without it they are found from the log, too.
///
/// ```
/// use lostmotion_drive::config::{AxisConfig, AxisUnit, NoSettings};
/// use lostmotion_identify::{AxisRows, LATENESS_S, fit_axis};
///
/// let axis = AxisConfig::<NoSettings>::paper();
/// let rows = AxisRows {
///     name: "log",
///     unit: AxisUnit::Mm,
///     time_s: &[0.0, 0.001],
///     motor: &[0.0, 0.0],
///     load: Some(&[0.0, 0.0]),
///     current_a: &[0.0, 0.0],
///     lateness_s: LATENESS_S,
/// };
/// let error = fit_axis(&rows, Some(&axis)).unwrap_err().to_string();
/// assert_eq!(error, "the positions are in mm, but the axis is in rad");
/// ```
///
/// # Errors
/// Another unit than the axis', columns that do not fit together, and what the fit says.
pub fn fit_axis<C>(
    rows: &AxisRows<'_>,
    axis: Option<&AxisConfig<C>>,
) -> Result<FitResult, AxisFitError> {
    // Without the axis nothing is known of lead and motor: the fit then counts in the unit of the
    // log.
    let (scale, mut settings) = match axis {
        Some(config) => (
            motor_rad_per_unit(config, rows.unit)?,
            FitSettings::for_axis(config),
        ),
        None => (1.0, FitSettings::without_axis()),
    };
    settings.lateness_s = rows.lateness_s;
    // Both fits work in radians of the motor, where current and inertia are known.
    let scaled = |values: &[f64]| values.iter().map(|value| value * scale).collect();
    let (motor, current_a) = (scaled(rows.motor), rows.current_a.to_vec());
    let fit = match rows.load {
        None => {
            let log = MotorLog::from_rows(rows.time_s, motor, current_a)?;
            fit_motor_only(&log, &settings.motor_only())?
        }
        Some(load) => {
            let log = BacklashLog::from_rows(rows.time_s, motor, scaled(load), current_a)?;
            fit_backlash(&log, &settings)?
        }
    };
    Ok(FitResult {
        schema: FIT_SCHEMA,
        log: rows.name.to_owned(),
        unit: rows.unit.symbol().to_owned(),
        // The fit works in half gaps and radians of the motor; people give total gaps at the load.
        gap: 2.0 * fit.half_gap_rad / scale,
        gap_interval: fit.half_gap_interval_rad.map(|half| 2.0 * half / scale),
        excited: fit.excited,
        stiffness: axis.map(|_| LoadStiffness::new(&fit, rows.unit, scale)),
        motor_rad_per_unit: axis.map(|_| scale),
        motor_only: rows.load.is_none(),
        fit,
    })
}
