//! Results of fits as `--fitted` reads them.

use crate::input;
use crate::output::Failure;
use lostmotion::base::units::number;
use lostmotion::drive::config::{AxisUnit, Gap};
use lostmotion::identify::{FIT_SCHEMA, FitResult, motor_rad_per_unit};
use lostmotion::methods::AxisConfig;
use lostmotion::methods::fitted_lookup::ToldLoad;
use std::path::Path;

/// Motor radian for a unit of the log.
pub(crate) fn rad_per_unit(
    config: &AxisConfig,
    unit: AxisUnit,
    name: &str,
) -> Result<f64, Failure> {
    motor_rad_per_unit(config, unit).map_err(|error| Failure::message(format!("{name}: {error}")))
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
    if result.schema != FIT_SCHEMA {
        return Err(Failure::message(format!(
            "{shown} has schema {}; this version reads {FIT_SCHEMA}",
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
    // Methods err small by as much as the log leaves open, however well the gap was known before.
    let [least, _] = result.gap_interval;
    let open = (result.gap - least) / result.gap;
    if (0.0..1.0).contains(&open) {
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
