//! `lostmotion fit`.

use super::DONE;
use crate::args::machine::Fit;
use crate::failure::Failure;
use crate::voice::Voice;
use crate::{input, machines, output};
use lostmotion::drive::config::{AxisUnit, Gap};
use lostmotion::identify::{
    BacklashFit, BacklashLog, FitSettings, MotorLog, fit_backlash, fit_motor_only,
};
use lostmotion::methods::AxisConfig;
use lostmotion::methods::fitted_lookup::ToldLoad;
use lostmotion::report::atomic::AtomicFile;
use lostmotion::report::csv::{read_log, read_motor_log};
use lostmotion::report::{WriteError, json, number};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Version of [`FitResult`].
const SCHEMA: u32 = 1;

/// What `fit` writes. Fields are only ever added within one schema number.
#[derive(Debug, Serialize, Deserialize)]
struct FitResult {
    /// [`SCHEMA`].
    schema: u32,
    /// Name of the log.
    log: String,
    /// Unit of the log's positions: `mm`, `deg` or `rad`.
    unit: String,
    /// Total gap in that unit, at the load.
    gap: f64,
    /// 95 % interval of the total gap in that unit.
    gap_interval: [f64; 2],
    /// Whether the log tells the gap from zero.
    excited: bool,
    /// Radian of the motor for one unit of the log, where the axis was given; otherwise the figures
    /// below are in the log's unit instead of rad, and per A instead of N m.
    motor_rad_per_unit: Option<f64>,
    /// Whether the load's positions were left out of it.
    #[serde(default)]
    motor_only: bool,
    /// The fit itself.
    fit: BacklashFit,
}

/// Fits the gap of a log and writes it as JSON.
pub(crate) fn run(args: &Fit, voice: Voice) -> Result<u8, Failure> {
    let axis = args.axis.as_deref().map(machines::axis).transpose()?;
    let name = args.log.display().to_string();
    let input = input::open(&args.log, "log")?;
    let log = if args.motor_only {
        read_motor_log(input, &name)?
    } else {
        read_log(input, &name)?
    };
    let unit = log.unit;
    let (scale, settings) = match &axis {
        Some(config) => (
            rad_per_unit(config, unit, &name)?,
            FitSettings::for_axis(config),
        ),
        None => (1.0, FitSettings::default()),
    };
    let fitted = if args.motor_only {
        MotorLog::new(log.period_s, scaled(log.motor, scale), log.current_a)
            .and_then(|log| fit_motor_only(&log, &settings.motor_only()))
    } else {
        BacklashLog::new(
            log.period_s,
            scaled(log.motor, scale),
            scaled(log.load, scale),
            log.current_a,
        )
        .and_then(|log| fit_backlash(&log, &settings))
    };
    let fit = fitted.map_err(|error| Failure::message(format!("{name}: {error}")))?;
    let result = FitResult {
        schema: SCHEMA,
        log: name,
        unit: unit.symbol().to_owned(),
        gap: 2.0 * fit.half_gap_rad / scale,
        gap_interval: fit.half_gap_interval_rad.map(|half| 2.0 * half / scale),
        excited: fit.excited,
        motor_rad_per_unit: axis.map(|_| scale),
        motor_only: args.motor_only,
        fit,
    };
    write(&args.out, &result)?;
    if !voice.quiet {
        output::print(&summary(&result))?;
    }
    Ok(DONE)
}

/// Motor radian for a unit of the log.
fn rad_per_unit(config: &AxisConfig, unit: AxisUnit, name: &str) -> Result<f64, Failure> {
    let per_axis_unit = config.transmission.motor_rad_per_unit();
    match (unit, config.unit()) {
        (log, axis) if log == axis => Ok(per_axis_unit),
        (AxisUnit::Deg, AxisUnit::Rad) => Ok(per_axis_unit.to_radians()),
        (AxisUnit::Rad, AxisUnit::Deg) => Ok(per_axis_unit.to_degrees()),
        (log, axis) => Err(Failure::message(format!(
            "{name}: the positions are in {}, but the axis is in {}",
            log.symbol(),
            axis.symbol()
        ))),
    }
}

fn scaled(values: Vec<f64>, scale: f64) -> Vec<f64> {
    values.into_iter().map(|value| value * scale).collect()
}

fn write(path: &Path, result: &FitResult) -> Result<(), Failure> {
    let mut file = AtomicFile::create(path)?;
    json::write_significant(&mut file, result)
        .map_err(|error| WriteError::io("write", path, error))?;
    file.commit()?;
    Ok(())
}

fn summary(result: &FitResult) -> String {
    let unit = &result.unit;
    let [low, high] = result
        .gap_interval
        .map(|v| number::plain(number::round_to(v, 6)));
    let gap = number::plain(number::round_to(result.gap, 6));
    let fit = &result.fit;
    let used = format!(
        "{} of {} samples, {} traversals",
        fit.samples_used, fit.samples_logged, fit.traversals
    );
    let doubt = fit
        .reason
        .as_ref()
        .map(|reason| format!("the log does not tell the gap from zero: {reason}\n"))
        .unwrap_or_default();
    let more = result
        .motor_rad_per_unit
        .map(|_| found_beside(fit))
        .unwrap_or_default();
    format!("gap {gap} {unit} (95 %: {low} to {high} {unit}) from {used}\n{doubt}{more}")
}

/// What was found beside the gap, at the motor's shaft.
fn found_beside(fit: &BacklashFit) -> String {
    let shown = |value: f64| format!("{value:.3e}");
    let stiffness = fit
        .stiffness_nm_per_rad
        .map(|stiffness| format!("stiffness {} N m/rad\n", shown(stiffness)));
    let load = fit.load.map(|load| {
        let (inertia, viscous) = (shown(load.inertia_kgm2), shown(load.viscous_nm_s_per_rad));
        let (coulomb, constant) = (shown(load.coulomb_nm), shown(load.constant_nm));
        format!("load {inertia} kg m2, friction {coulomb} N m and {viscous} N m s/rad, constant {constant} N m\n")
    });
    [stiffness, load].into_iter().flatten().collect()
}

/// An axis whose compensators that may know them were told gap and load of a fit.
pub(crate) fn with_fit(path: &Path, config: &AxisConfig) -> Result<AxisConfig, Failure> {
    let shown = path.display().to_string();
    let text = input::text(path, "result of `fit`")?;
    let result: FitResult = serde_json::from_str(&text).map_err(|error| {
        Failure::message(format!("{shown} is no result of `lostmotion fit`: {error}"))
    })?;
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
    if !result.excited {
        return Err(Failure::message(format!(
            "{shown}: that log does not tell the gap from zero"
        )));
    }
    if !(result.gap.is_finite() && result.gap >= 0.0) {
        return Err(Failure::message(format!(
            "{shown}: gap is {}; it has to be finite and not negative",
            result.gap
        )));
    }
    let mut told = config.clone();
    told.compensation.tell_gap(Gap::MotorRad(
        result.gap * rad_per_unit(config, unit, &shown)?,
    ));
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
