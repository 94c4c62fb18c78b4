//! Setpoints of one axis: a row a command cycle.

use super::cells::{Cells, Column, UNITS};
use crate::error::ReadError;
use lostmotion_base::Clock;
use lostmotion_drive::Setpoint;
use lostmotion_drive::config::{AxisUnit, Interpolator};
use std::io::Read;

/// How far a row's time may be off its tick, in parts of the period. A choice: times written with
/// few decimals pass.
const TIME_TOLERANCE_SHARE: f64 = 0.01;

/// Which column holds the positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetpointSource<'a> {
    /// `position`, or `position_mm`, `position_deg`, `position_rad`.
    Position,
    /// A column of this name, such as `x_mm` of a plan.
    Column(&'a str),
}

/// Columns with the force on the load: of a linear axis, and of one that turns.
const LOAD_FORCES: [&str; 2] = ["load_force_n", "load_torque_nm"];

/// Reads setpoints, one row a period of the clock, in constant memory: positions, and where there
/// are columns `velocity` (per s), `acceleration` (per s2) and `load_force_n` or `load_torque_nm`
/// these too. Other columns are ignored.
///
/// The force acts on the load against the positive direction, besides what the axis' description
/// has, from its row's time to that of the next row.
///
/// Iterates over them as they stand in the file, in the unit of the file. After an error it ends.
pub struct SetpointReader<R> {
    cells: Cells<R>,
    time: Column,
    position: Column,
    velocity: Option<Column>,
    acceleration: Option<Column>,
    load_force: Option<Column>,
    unit: Option<AxisUnit>,
    clock: Clock,
    rows: u64,
    start_s: f64,
    failed: bool,
}

impl<R: Read> SetpointReader<R> {
    /// Reads the header. `name` is the file's name for messages, `clock` the period that the rows
    /// have to have.
    ///
    /// # Errors
    /// An empty file, one that is no table, a missing column, both a force and a torque on the load.
    pub fn new(
        input: R,
        name: &str,
        source: SetpointSource<'_>,
        clock: Clock,
    ) -> Result<SetpointReader<R>, ReadError> {
        let cells = Cells::new(input, name)?;
        let time = cells.column("t_s")?;
        // A column that the user names says its unit by its ending; a plain `position` leaves it
        // open.
        let (position, unit) = match source {
            SetpointSource::Column(column) => (cells.column(column)?, unit_of(column)),
            SetpointSource::Position => match cells.find("position")? {
                Some(column) => (column, None),
                None => cells
                    .column_with_unit("position", "position")
                    .map(|(column, unit)| (column, Some(unit)))?,
            },
        };
        let (velocity, acceleration) = (cells.find("velocity")?, cells.find("acceleration")?);
        let [force, torque] = LOAD_FORCES;
        let load_force = match (cells.find(force)?, cells.find(torque)?) {
            (Some(first), Some(second)) => {
                return Err(cells.ambiguous("the force on the load", &first, &second));
            }
            (force, torque) => force.or(torque),
        };
        Ok(SetpointReader {
            cells,
            time,
            position,
            velocity,
            acceleration,
            load_force,
            unit,
            clock,
            rows: 0,
            start_s: 0.0,
            failed: false,
        })
    }

    /// The unit that the position column's name states, if it does.
    pub fn unit(&self) -> Option<AxisUnit> {
        self.unit
    }

    /// Whether there is a column of velocities.
    pub fn has_velocity(&self) -> bool {
        self.velocity.is_some()
    }

    /// The column that holds the force on the load, if there is one, and the one that an axis in
    /// `unit` has.
    pub fn load_force(&self, unit: AxisUnit) -> Option<(&str, &'static str)> {
        let [force, torque] = LOAD_FORCES;
        let suits = if unit == AxisUnit::Mm { force } else { torque };
        let column = self.load_force.as_ref()?;
        Some((&column.header, suits))
    }

    /// Whether there are all columns that an interpolator needs.
    pub fn serves(&self, interpolator: Interpolator) -> bool {
        (self.velocity.is_some() || !interpolator.needs_velocity())
            && (self.acceleration.is_some() || !interpolator.needs_acceleration())
    }

    /// Rows read so far.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    fn read(&mut self) -> Result<Option<Setpoint>, ReadError> {
        if !self.cells.next_row()? {
            if self.rows == 0 {
                return Err(ReadError::Empty {
                    name: self.cells.name().to_owned(),
                    needed: 1,
                });
            }
            return Ok(None);
        }
        let time_s = self.cells.number(&self.time)?;
        let position = self.cells.number(&self.position)?;
        let velocity = self
            .velocity
            .as_ref()
            .map(|column| self.cells.number(column))
            .transpose()?;
        let acceleration = self
            .acceleration
            .as_ref()
            .map(|column| self.cells.number(column))
            .transpose()?;
        let load_force = self
            .load_force
            .as_ref()
            .map(|column| self.cells.number(column))
            .transpose()?;
        // A table may begin at any time, such as one cut out of a longer run.
        if self.rows == 0 {
            self.start_s = time_s;
        }
        self.check_time(time_s)?;
        self.rows += 1;
        Ok(Some(Setpoint {
            position,
            velocity,
            acceleration,
            load_force,
            ..Setpoint::default()
        }))
    }

    fn check_time(&self, time_s: f64) -> Result<(), ReadError> {
        let period_s = self.clock.period_s();
        // Due by count, not by the row before: small errors of the times do not add up.
        let due_s = self.start_s + self.clock.seconds(self.rows);
        if (time_s - due_s).abs() <= TIME_TOLERANCE_SHARE * period_s {
            return Ok(());
        }
        let before_s = due_s - period_s;
        // Too early and too late are different mistakes: rows twice or out of order, rows missing.
        let (why, hint) = if time_s <= before_s + TIME_TOLERANCE_SHARE * period_s {
            (
                format!("is not after {before_s:.6} s, the time of the row before"),
                "rows have to be in order of time, none twice",
            )
        } else {
            let period_ms = period_s * 1e3;
            (
                format!("should be {due_s:.6} s; rows have to be {period_ms} ms apart"),
                "resample the table, and fill rows that are missing",
            )
        };
        Err(self.cells.bad(&self.time, why, hint))
    }
}

impl<R: Read> Iterator for SetpointReader<R> {
    type Item = Result<Setpoint, ReadError>;

    fn next(&mut self) -> Option<Result<Setpoint, ReadError>> {
        if self.failed {
            return None;
        }
        let item = self.read().transpose();
        // After an error the place in the table is not known: the iterator ends.
        self.failed = !matches!(item, Some(Ok(_)));
        item
    }
}

/// The unit that the end of a column's name states.
fn unit_of(column: &str) -> Option<AxisUnit> {
    let suffix = column.rsplit_once('_')?.1;
    UNITS.into_iter().find(|unit| unit.symbol() == suffix)
}
