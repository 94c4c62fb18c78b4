//! Logs of an axis, for fitting its gap.

use super::cells::Cells;
use crate::error::ReadError;
use lostmotion_drive::config::AxisUnit;
use std::io::Read;

/// Fewest rows of a log: velocity and acceleration are taken by differences.
const FEWEST_ROWS: usize = 3;

/// A log of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisLog {
    /// Time of each row, s, rising.
    pub time_s: Vec<f64>,
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
/// out of order. Rows at uneven times pass.
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
        time_s: Vec::new(),
        unit,
        motor: Vec::new(),
        load: Vec::new(),
        current_a: Vec::new(),
    };
    while cells.next_row()? {
        let time_s = cells.number(&time)?;
        if let Some(&before_s) = log.time_s.last()
            && time_s <= before_s
        {
            return Err(cells.bad(
                &time,
                format!("is not after {before_s} s, the time of the row before"),
                ORDER_HINT,
            ));
        }
        log.time_s.push(time_s);
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
    Ok(log)
}

/// Hint for rows out of order.
const ORDER_HINT: &str = "rows have to be in order of time, none twice";
