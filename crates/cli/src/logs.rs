//! Measured logs as commands take them: the file, what its columns are, and which part is meant.

use crate::input;
use crate::output::{self, DONE, Failure};
use clap::Args;
use lostmotion::drive::config::AxisUnit;
use lostmotion::logs::{
    AxisLog, AxisOptions, ColumnSpec, Format, LogReader, ReadOptions, Role, Row, read_axis,
};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

/// Bytes read at once. A choice: few calls, little memory.
const BUFFER_BYTES: usize = 1 << 18;
/// From this multiple of the usual time between two rows on a row is missing between them.
const MISSING_FROM: f64 = 1.75;

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

/// `axis log`.
#[derive(Debug, Args)]
pub(crate) struct LogOverview {
    /// Log in any format that is known
    pub(crate) log: PathBuf,
    #[command(flatten)]
    pub(crate) rows: LogRows,
}

/// What is added up of one channel.
#[derive(Clone)]
struct Extent {
    least: f64,
    most: f64,
    changes: u64,
    last: f64,
    /// Rows without a number, and the line of the first of them.
    missing: u64,
    missing_line: u64,
}

/// What is added up of one clock.
#[derive(Clone)]
struct Pace {
    rows: u64,
    first_s: f64,
    last_s: f64,
    shortest_s: f64,
    longest_s: f64,
}

/// Says what is in a log, in constant memory.
pub(crate) fn overview(args: &LogOverview) -> Result<u8, Failure> {
    let name = args.log.display().to_string();
    let mut reader = LogReader::new(open(&args.log)?, &name, &args.rows.read_options())?;
    let header = reader.header().clone();
    let groups: Vec<Vec<usize>> = (0..header.groups)
        .map(|group| header.group(group).collect())
        .collect();
    let fresh = Extent {
        least: f64::INFINITY,
        most: f64::NEG_INFINITY,
        changes: 0,
        last: f64::NAN,
        missing: 0,
        missing_line: 0,
    };
    let mut extents = vec![fresh; header.channels.len()];
    let fresh = Pace {
        rows: 0,
        first_s: f64::NAN,
        last_s: f64::NAN,
        shortest_s: f64::INFINITY,
        longest_s: 0.0,
    };
    let mut paces = vec![fresh; header.groups];
    let (from, to) = (
        args.rows.from.unwrap_or(f64::NEG_INFINITY),
        args.rows.to.unwrap_or(f64::INFINITY),
    );
    let most = args.rows.rows.map_or(u64::MAX, |rows| rows as u64);
    // Texts in a table's columns are no reason to refuse the whole log here.
    reader.select(&[]);
    let mut row = Row::default();
    while reader.next_row(&mut row)? {
        let (Some(pace), Some(members)) = (paces.get_mut(row.group), groups.get(row.group)) else {
            continue;
        };
        if row.time_s < from || row.time_s > to {
            continue;
        }
        if pace.rows == most {
            break;
        }
        if pace.rows == 0 {
            pace.first_s = row.time_s;
        } else {
            let step_s = row.time_s - pace.last_s;
            pace.shortest_s = pace.shortest_s.min(step_s);
            pace.longest_s = pace.longest_s.max(step_s);
        }
        pace.last_s = row.time_s;
        pace.rows += 1;
        for (&place, &value) in members.iter().zip(&row.values) {
            let Some(extent) = extents.get_mut(place) else {
                continue;
            };
            if !value.is_finite() {
                if extent.missing == 0 {
                    extent.missing_line = row.line;
                }
                extent.missing += 1;
                continue;
            }
            extent.least = extent.least.min(value);
            extent.most = extent.most.max(value);
            extent.changes += u64::from(value != extent.last);
            extent.last = value;
        }
    }
    let mut text = format!("format: {}\n", header.format);
    for said in header.said.iter().chain(&reader.remarks()) {
        text += &format!("  {said}\n");
    }
    let scale = reader.time_scale_s();
    for (group, (pace, members)) in paces.iter().zip(&groups).enumerate() {
        let mean_s = scale * (pace.last_s - pace.first_s) / pace.rows.saturating_sub(1) as f64;
        text += &format!(
            "clock {}: {} rows, {:.6} to {:.6} s, every {:.6} ms ({:.6} to {:.6})\n",
            group + 1,
            pace.rows,
            scale * pace.first_s,
            scale * pace.last_s,
            1e3 * mean_s,
            1e3 * scale * pace.shortest_s,
            1e3 * scale * pace.longest_s,
        );
        if scale * pace.shortest_s <= 0.0 {
            text += "  rows are not in order of time, or stand twice\n";
        } else if scale * pace.longest_s > MISSING_FROM * mean_s {
            // camonitor is silent while a value stays.
            text += if header.format == Format::Camonitor {
                "  nothing changed for a while\n"
            } else {
                "  rows are missing\n"
            };
        }
        for &place in members {
            let (Some(channel), Some(extent)) = (header.channels.get(place), extents.get(place))
            else {
                continue;
            };
            let unit = channel
                .unit
                .map_or("unit not told".to_owned(), |unit| unit.to_string());
            text += &format!("  {:>3} {} ", place + 1, channel.name);
            // Of a column of texts, or a channel that was never written.
            text += &if extent.least > extent.most {
                "holds no numbers\n".to_owned()
            } else {
                format!(
                    "({unit}): {} to {}, {} changes\n",
                    extent.least,
                    extent.most,
                    extent.changes.saturating_sub(1),
                )
            };
            if extent.missing > 0 && extent.least <= extent.most {
                text += &format!(
                    "      {} of its rows hold no finite number, the first in line {}\n",
                    extent.missing, extent.missing_line
                );
            }
        }
    }
    output::print(&text)?;
    Ok(DONE)
}
