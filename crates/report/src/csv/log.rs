//! Logs of an axis, for fitting its gap.

use super::cells::Cells;
use crate::error::ReadError;
use lostmotion_drive::config::AxisUnit;
use std::io::Read;

/// Fewest rows of a log: velocity and acceleration are taken by differences.
const FEWEST_ROWS: usize = 3;

/// How far the time between two rows may be off, in parts of the period. A choice: times written with
/// few decimals pass.
const TIME_TOLERANCE_SHARE: f64 = 0.01;

/// A log of one axis at a fixed rate.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisLog {
    /// Mean time between two rows, s.
    pub period_s: f64,
    /// Unit of the positions.
    pub unit: AxisUnit,
    /// Motor positions in `unit`, at the load.
    pub motor: Vec<f64>,
    /// Load positions in `unit`; empty if only the motor was read.
    pub load: Vec<f64>,
    /// Torque-forming current, A.
    pub current_a: Vec<f64>,
}

/// Reads the columns `t_s`, `motor_<u>`, `load_<u>` and `current_a` of a log, as an axis trace has
/// them; others are ignored. `name` is the file's name for messages.
///
/// # Errors
/// An empty file, one that is no table, a missing column, a cell that is not a finite number, rows
/// that are not evenly spaced in time.
pub fn read_log(input: impl Read, name: &str) -> Result<AxisLog, ReadError> {
    read(input, name, true)
}

/// As [`read_log`] without the column `load_<u>`, whether it is there or not.
///
/// # Errors
/// As [`read_log`].
pub fn read_motor_log(input: impl Read, name: &str) -> Result<AxisLog, ReadError> {
    read(input, name, false)
}

fn read(input: impl Read, name: &str, with_load: bool) -> Result<AxisLog, ReadError> {
    let mut cells = Cells::new(input, name)?;
    let time = cells.column("t_s")?;
    let (motor, unit) = cells.column_with_unit("motor", "motor position")?;
    let load = if with_load {
        Some(cells.column_with_unit("load", "load position")?)
    } else {
        None
    };
    // The gap is in the difference of the two: one scale has to hold for both.
    if let Some((load, load_unit)) = &load
        && unit != *load_unit
    {
        return Err(cells.mixed_units(&motor, load));
    }
    let current = cells.column("current_a")?;
    let mut log = AxisLog {
        period_s: 0.0,
        unit,
        motor: Vec::new(),
        load: Vec::new(),
        current_a: Vec::new(),
    };
    let (mut start_s, mut before_s) = (0.0, 0.0);
    while cells.next_row()? {
        let time_s = cells.number(&time)?;
        // The first step is the period; every later one is held against it.
        let step_s = time_s - before_s;
        match log.motor.len() {
            0 => start_s = time_s,
            _ if step_s <= 0.0 => {
                return Err(cells.bad(
                    &time,
                    format!("is not after {before_s} s, the time of the row before"),
                    ORDER_HINT,
                ));
            }
            1 => log.period_s = step_s,
            _ if (step_s - log.period_s).abs() > TIME_TOLERANCE_SHARE * log.period_s => {
                let why = format!(
                    "is {step_s:.6} s after the row before; the first two rows are {:.6} s apart",
                    log.period_s
                );
                return Err(cells.bad(&time, why, EVEN_HINT));
            }
            _ => {}
        }
        before_s = time_s;
        log.motor.push(cells.number(&motor)?);
        if let Some((load, _)) = &load {
            log.load.push(cells.number(load)?);
        }
        log.current_a.push(cells.number(&current)?);
    }
    if log.motor.len() < FEWEST_ROWS {
        return Err(ReadError::Empty {
            name: name.to_owned(),
            needed: FEWEST_ROWS,
        });
    }
    // The mean over the whole log is free of the rounding of single times.
    log.period_s = (before_s - start_s) / (log.motor.len() - 1) as f64;
    Ok(log)
}

/// Hint for rows out of order.
const ORDER_HINT: &str = "rows have to be in order of time, none twice";
/// Hint for rows at other times than they should be.
const EVEN_HINT: &str = "a log needs rows evenly spaced in time, none missing";
