//! `fit` and `identify`: what a log tells of an axis.

use crate::apart::apart;
use crate::axis::described;
use crate::error::Refusal;
use crate::table::eights;
use lostmotion::drive::config::AxisUnit;
use lostmotion::identify::body::{BodyRows, Identified};
use lostmotion::identify::{AxisRows, FitResult, fit_axis};
use lostmotion::logs::{AxisLog, AxisOptions, ColumnSpec, DriveSignal, Role, read_axis};
use lostmotion::report::json;
use pyo3::prelude::*;
use pythonize::pythonize;
use std::collections::HashMap;
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

/// A log: a file in any format that is known, or columns.
#[derive(FromPyObject)]
pub(crate) enum Log {
    /// Bytes of numbers by the name of their column, and the unit of positions.
    Columns(HashMap<String, Vec<u8>>, String),
    /// A file, with what its columns are.
    File(PathBuf, Vec<String>),
}

/// Columns of an axis, in one unit.
struct Rows {
    name: String,
    unit: AxisUnit,
    time_s: Vec<f64>,
    motor: Vec<f64>,
    load: Vec<f64>,
    command: Vec<f64>,
    drive: Vec<f64>,
}

fn unit_of(symbol: &str) -> Result<AxisUnit, Refusal> {
    [AxisUnit::Mm, AxisUnit::Deg, AxisUnit::Rad]
        .into_iter()
        .find(|unit| unit.symbol() == symbol)
        .ok_or_else(|| {
            let hint = "units of positions are mm, deg and rad; convert others before";
            Refusal::data(format!("\"{symbol}\" is no unit of an axis"), hint)
        })
}

impl Rows {
    fn of(log: Log, needed: &[Role], without: &[Role]) -> Result<Rows, Refusal> {
        let (path, columns) = match log {
            Log::File(path, columns) => (path, columns),
            Log::Columns(mut columns, unit) => {
                let mut column = |name: &str| {
                    let bytes = columns.remove(name).unwrap_or_default();
                    eights(&bytes, f64::from_ne_bytes)
                };
                return Ok(Rows {
                    name: "columns".to_owned(),
                    unit: unit_of(&unit)?,
                    time_s: column("time_s"),
                    motor: column("motor"),
                    load: column("load"),
                    command: column("command"),
                    drive: column("drive"),
                });
            }
        };
        let name = path.display().to_string();
        let columns = columns
            .iter()
            .map(|text| {
                let refused = |error| Refusal::option(format!("columns: {error}"), "");
                text.parse::<ColumnSpec>().map_err(refused)
            })
            .collect::<Result<Vec<_>, _>>()?;
        let options = AxisOptions {
            columns,
            needed: needed.to_vec(),
            without: without.to_vec(),
            ..AxisOptions::default()
        };
        let file = File::open(&path)
            .map_err(|error| Refusal::data(format!("cannot read {name}: {error}"), ""))?;
        let log: AxisLog = read_axis(BufReader::new(file), &name, &options)
            .map_err(|error| Refusal::data(error.to_string(), ""))?;
        Ok(Rows {
            unit: unit_of(log.unit.symbol)?,
            name,
            time_s: log.time_s,
            motor: log.motor,
            load: log.load,
            command: log.command,
            drive: log
                .drive
                .as_ref()
                .map_or(&[][..], DriveSignal::values)
                .to_vec(),
        })
    }
}

/// The gap of an axis: all figures, and the document that the command writes.
#[pyfunction]
pub(crate) fn fit<'py>(
    py: Python<'py>,
    log: Log,
    axis: Option<&Bound<'py, PyAny>>,
    drive: Option<&str>,
    motor_only: bool,
    lateness_s: f64,
) -> PyResult<(Bound<'py, PyAny>, String)> {
    let config = axis.map(|axis| described(axis, drive)).transpose()?;
    let result: FitResult = apart(py, None, move |_| {
        let aside = [Role::Command, Role::Torque, Role::Force];
        let rows = if motor_only {
            Rows::of(log, &[Role::Current], &[&aside[..], &[Role::Load]].concat())?
        } else {
            Rows::of(log, &[Role::Load, Role::Current], &aside)?
        };
        let measured = AxisRows {
            name: &rows.name,
            unit: rows.unit,
            time_s: &rows.time_s,
            motor: &rows.motor,
            load: (!motor_only).then_some(&rows.load),
            current_a: &rows.drive,
            lateness_s,
        };
        fit_axis(&measured, config.as_ref())
            .map_err(|error| Refusal::data(format!("{}: {error}", rows.name), ""))
    })?;
    let mut document = Vec::new();
    json::write_significant(&mut document, &result)?;
    let document = String::from_utf8_lossy(&document).into_owned();
    Ok((pythonize(py, &result)?, document))
}

/// What a log tells of an axis as one body: m or rad, and the log's unit of what drives it.
#[pyfunction]
pub(crate) fn identify<'py>(
    py: Python<'py>,
    log: Log,
    lateness_s: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let found = apart(py, None, move |_| {
        let rows = Rows::of(log, &[], &[])?;
        let columns = BodyRows {
            unit: rows.unit,
            time_s: &rows.time_s,
            motor: &rows.motor,
            load: &rows.load,
            command: &rows.command,
            drive: &rows.drive,
            lateness_s,
        };
        Identified::of(&columns)
            .map_err(|error| Refusal::data(format!("{}: {error}", rows.name), ""))
    })?;
    Ok(pythonize(py, &found)?)
}
