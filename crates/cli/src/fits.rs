//! Results of fits: what `axis fit` writes and `--fitted` reads.

use crate::input;
use crate::output::Failure;
use lostmotion::base::units::number;
use lostmotion::drive::config::{AxisUnit, Gap};
use lostmotion::identify::BacklashFit;
use lostmotion::methods::AxisConfig;
use lostmotion::methods::fitted_lookup::ToldLoad;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Version of [`FitResult`].
pub(crate) const SCHEMA: u32 = 1;

/// What `fit` writes. Fields are only ever added within one schema number.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct FitResult {
    /// [`SCHEMA`].
    pub(crate) schema: u32,
    /// Name of the log.
    pub(crate) log: String,
    /// Unit of the log's positions: `mm`, `deg` or `rad`.
    pub(crate) unit: String,
    /// Total gap in that unit, at the load.
    pub(crate) gap: f64,
    /// 95 % interval of the total gap in that unit.
    pub(crate) gap_interval: [f64; 2],
    /// Whether the log tells the gap from zero.
    pub(crate) excited: bool,
    /// Radian of the motor for one unit of the log, where the axis was given; otherwise the figures
    /// below are in the log's unit instead of rad, and per A instead of N m.
    pub(crate) motor_rad_per_unit: Option<f64>,
    /// Whether the load's positions were left out of it.
    #[serde(default)]
    pub(crate) motor_only: bool,
    /// Stiffness of the shaft at the load, where the axis was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) stiffness: Option<LoadStiffness>,
    /// The fit itself.
    pub(crate) fit: BacklashFit,
}

/// Stiffness of the shaft as the load feels it.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct LoadStiffness {
    /// `N/um` or `N m/rad`.
    pub(crate) unit: String,
    /// None where the shaft is stiffer than the log can tell.
    pub(crate) value: Option<f64>,
    /// 95 % interval; no upper end where the shaft is stiffer than the log can tell.
    pub(crate) interval: [Option<f64>; 2],
}

impl LoadStiffness {
    /// Of a fit in motor radian, so many of which make a unit of the log.
    pub(crate) fn new(fit: &BacklashFit, unit: AxisUnit, rad_per_unit: f64) -> LoadStiffness {
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

/// Motor radian for a unit of the log.
pub(crate) fn rad_per_unit(
    config: &AxisConfig,
    unit: AxisUnit,
    name: &str,
) -> Result<f64, Failure> {
    let per_axis_unit = config.transmission.motor_rad_per_unit();
    match (unit, config.unit()) {
        (log, axis) if log == axis => Ok(per_axis_unit),
        // Angles convert into each other; mm and angles do not.
        (AxisUnit::Deg, AxisUnit::Rad) => Ok(per_axis_unit.to_radians()),
        (AxisUnit::Rad, AxisUnit::Deg) => Ok(per_axis_unit.to_degrees()),
        (log, axis) => Err(Failure::message(format!(
            "{name}: the positions are in {}, but the axis is in {}",
            log.symbol(),
            axis.symbol()
        ))),
    }
}

/// The axis with gap and load of a fit told to the methods that may know them.
pub(crate) fn with_fit(path: &Path, config: &AxisConfig) -> Result<AxisConfig, Failure> {
    let shown = path.display().to_string();
    let text = input::text(path, "result of `axis fit`")?;
    let result: FitResult = serde_json::from_str(&text).map_err(|error| {
        Failure::message(format!(
            "{shown} is not a result of `lostmotion axis fit`: {error}"
        ))
    })?;
    // In another schema a key may mean something else: refused rather than misread.
    if result.schema != SCHEMA {
        return Err(Failure::message(format!(
            "{shown} has schema {}; this version reads {SCHEMA}",
            result.schema
        )));
    }
    let unit = [AxisUnit::Mm, AxisUnit::Deg, AxisUnit::Rad]
        .into_iter()
        .find(|unit| unit.symbol() == result.unit);
    let unit = unit.ok_or_else(|| {
        Failure::message(format!(
            "{shown}: unit is \"{}\"; it has to be mm, deg or rad",
            result.unit
        ))
    })?;
    // The gap of such a log is a bound, not a value.
    if !result.excited {
        return Err(Failure::message(format!(
            "{shown}: the log does not tell the gap from zero"
        )));
    }
    if !(result.gap.is_finite() && result.gap >= 0.0) {
        return Err(Failure::message(format!(
            "{shown}: gap is {}; it has to be finite and not negative",
            result.gap
        )));
    }
    // The total gap at the load, in the log's unit, becomes an angle of the motor.
    let gap_rad = result.gap * rad_per_unit(config, unit, &shown)?;
    // A gap beyond what the axis may have shows a log of another axis.
    let with_gap = config.with_gap(gap_rad / config.transmission.motor_rad_per_unit());
    with_gap.check().map_err(|error| {
        let gap = number(result.gap);
        Failure::message(format!(
            "{shown}: gap is {gap} {}, which the axis cannot have: {error}",
            result.unit
        ))
    })?;
    let mut told = config.clone();
    told.compensation.tell_gap(Gap::MotorRad(gap_rad));
    // Methods err small by as much as the log leaves open.
    let [least, _] = result.gap_interval;
    let open = (result.gap - least) / result.gap;
    if open > told.compensation.gap_uncertainty && open < 1.0 {
        told.compensation.gap_uncertainty = open;
    }
    // Without the axis the fit counts in the log's units: its load would be wrong by a factor.
    told.compensation.fitted_lookup.load = result
        .fit
        .load
        .filter(|_| result.motor_rad_per_unit.is_some())
        .map(|load| ToldLoad {
            inertia_kgm2: load.inertia_kgm2,
            viscous_nm_s_per_rad: load.viscous_nm_s_per_rad,
            coulomb_nm: load.coulomb_nm,
            constant_nm: load.constant_nm,
        });
    told.check()
        .map_err(|error| Failure::message(format!("{shown}: {error}")))?;
    Ok(told)
}
