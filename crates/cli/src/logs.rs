//! Measured logs as commands take them: the file, what its columns are, and which part is meant.

use crate::input;
use crate::output::{self, Failure};
use clap::Args;
use lostmotion::drive::config::AxisUnit;
use lostmotion::logs::{AxisLog, AxisOptions, ColumnSpec, ReadOptions, Role, read_axis};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

/// Bytes read at once. A choice: few calls, little memory.
const BUFFER_BYTES: usize = 1 << 18;

/// A measured log.
#[derive(Debug, Args)]
pub(crate) struct LogInput {
    /// Log of an axis: HALscope, halsampler, TwinCAT Scope, Sinumerik trace, TNCscope, camonitor,
    /// Parquet, MCAP, or any table (columns t_s, motor_mm, load_mm, current_a are known by their names)
    pub(crate) log: PathBuf,
    /// What a column is: time, command, motor, load, current, torque or force, by its name in the
    /// log or its number in the file, from 1 with the time counted:
    /// motor=NAME,unit=um,sign=-,scale=2; may be repeated
    #[arg(long, value_name = "ROLE=NAME", allow_hyphen_values = true)]
    pub(crate) column: Vec<ColumnSpec>,
    #[command(flatten)]
    pub(crate) rows: LogRows,
}

/// How the rows of a log are taken.
#[derive(Debug, Args)]
pub(crate) struct LogRows {
    /// Time between two rows in ms, for a log that does not tell it
    #[arg(long, value_name = "MS")]
    pub(crate) period_ms: Option<f64>,
    /// Whether the first column of a halsampler text counts samples; found from the text otherwise
    #[arg(long, value_name = "true|false")]
    pub(crate) tagged: Option<bool>,
    /// First time taken, s of the log
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    pub(crate) from: Option<f64>,
    /// Last time taken, s of the log
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    pub(crate) to: Option<f64>,
    /// Most rows taken, from the first time on: 200000 unless told; all by `check-log`
    #[arg(long, value_name = "N")]
    pub(crate) rows: Option<usize>,
    /// Most memory for a log that is no text, in MB: the whole of a Parquet file, a chunk of an MCAP
    /// file
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) max_memory_mb: u32,
}

impl LogRows {
    /// How the log is read.
    pub(crate) fn read_options(&self) -> ReadOptions {
        ReadOptions {
            period_s: self.period_ms.map(|period| 1e-3 * period),
            tagged: self.tagged,
            max_bytes: (self.max_memory_mb as usize).saturating_mul(1 << 20),
            ..ReadOptions::default()
        }
    }
}

/// The file of a log.
pub(crate) fn open(path: &Path) -> Result<impl BufRead + use<>, Failure> {
    Ok(BufReader::with_capacity(
        BUFFER_BYTES,
        input::open(path, "log")?,
    ))
}

impl LogInput {
    /// The file's name for messages.
    pub(crate) fn name(&self) -> String {
        self.log.display().to_string()
    }

    /// Refuses a file that cannot be opened, before anything is written.
    pub(crate) fn exists(&self) -> Result<(), Failure> {
        input::open(&self.log, "log").map(drop)
    }

    /// Reads the channels of one axis; what was found and taken for granted goes to stderr.
    pub(crate) fn read(
        &self,
        needed: &[Role],
        without: &[Role],
        quiet: bool,
    ) -> Result<AxisLog, Failure> {
        let defaults = AxisOptions::default();
        let options = AxisOptions {
            read: self.rows.read_options(),
            columns: self.column.clone(),
            needed: needed.to_vec(),
            without: without.to_vec(),
            from_s: self.rows.from.unwrap_or(defaults.from_s),
            to_s: self.rows.to.unwrap_or(defaults.to_s),
            max_rows: self.rows.rows.unwrap_or(defaults.max_rows),
        };
        let log = read_axis(open(&self.log)?, &self.name(), &options)?;
        if !quiet {
            for said in &log.said {
                output::remark(&format!("{}: {said}", self.name()));
            }
        }
        Ok(log)
    }
}

/// The unit of the positions of a log.
pub(crate) fn axis_unit(log: &AxisLog) -> AxisUnit {
    let units = [AxisUnit::Mm, AxisUnit::Deg, AxisUnit::Rad];
    let found = units
        .into_iter()
        .find(|unit| unit.symbol() == log.unit.symbol);
    found.unwrap_or(AxisUnit::Mm)
}
