//! What a log has, and what a reader of one format gives.

use crate::error::LogError;
use crate::unit::Unit;
use std::fmt;
use std::io::{Chain, Cursor};

/// Most channels of a log. A choice: scopes have up to a few hundred.
pub(crate) const MAX_CHANNELS: usize = 4096;

/// Formats that are recognised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// HALscope of LinuxCNC up to 2.8: names and values alternate.
    HalscopeNamed,
    /// HALscope of LinuxCNC 2.9: names in line 2.
    Halscope,
    /// HALscope of LinuxCNC 2.10: as 2.9 with two lines of display settings.
    HalscopeDisplay,
    /// The text of LinuxCNC's `halsampler`.
    Halsampler,
    /// TwinCAT Scope's text export.
    TwincatScope,
    /// A trace of Sinumerik Operate, XML.
    SinumerikTrace,
    /// Heidenhain's TNCscope, text.
    Tncscope,
    /// The text of EPICS' `camonitor`.
    Camonitor,
    /// Klipper's accelerometer.
    KlipperAccelerometer,
    /// RepRapFirmware's accelerometer.
    DuetAccelerometer,
    /// Any other table.
    Table,
    /// Apache Parquet.
    Parquet,
    /// MCAP, the container of robotics tools.
    Mcap,
}

impl Format {
    /// What its rows are called where they are counted.
    pub(crate) fn counted(self) -> &'static str {
        match self {
            Format::Parquet => "row",
            Format::Mcap => "message",
            _ => "line",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Format::HalscopeNamed => "HALscope, LinuxCNC up to 2.8",
            Format::Halscope => "HALscope, LinuxCNC 2.9",
            Format::HalscopeDisplay => "HALscope, LinuxCNC 2.10",
            Format::Halsampler => "halsampler",
            Format::TwincatScope => "TwinCAT Scope",
            Format::SinumerikTrace => "Sinumerik trace",
            Format::Tncscope => "Heidenhain TNCscope",
            Format::Camonitor => "EPICS camonitor",
            Format::KlipperAccelerometer => "Klipper accelerometer",
            Format::DuetAccelerometer => "RepRapFirmware accelerometer",
            Format::Table => "table",
            Format::Parquet => "Parquet",
            Format::Mcap => "MCAP",
        })
    }
}

/// What a log does not say of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOptions {
    /// Time between two rows, s, for logs without times.
    pub period_s: Option<f64>,
    /// Whether the first column of a `halsampler` text is the number of the sample; found from
    /// whether it rises by one where this is `None`.
    pub tagged: Option<bool>,
    /// Column of the time, for tables.
    pub time_column: Option<String>,
    /// Unit of that column, where its name does not tell it.
    pub time_unit: Option<Unit>,
    /// Most bytes of a log that are held at once: the whole of a Parquet file, a chunk of an MCAP
    /// file. Text is read line by line and needs none of it.
    pub max_bytes: usize,
}

/// [`ReadOptions::max_bytes`] where the caller does not say otherwise. A choice: a log of 1 GB is
/// read with so much memory.
const DEFAULT_MAX_BYTES: usize = 64 << 20;

impl Default for ReadOptions {
    fn default() -> ReadOptions {
        ReadOptions {
            period_s: None,
            tagged: None,
            time_column: None,
            time_unit: None,
            max_bytes: DEFAULT_MAX_BYTES,
        }
    }
}

/// One channel of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Its name in the log.
    pub name: String,
    /// Its unit, where the log tells it.
    pub unit: Option<Unit>,
    /// The clock that it is sampled by.
    pub group: usize,
}

/// The columns of a log that is a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileColumns {
    /// The column of each channel, from 1; those of times are counted, too.
    pub of_channels: Vec<usize>,
    /// How many columns there are.
    pub count: usize,
}

impl FileColumns {
    /// Channels that stand side by side behind `before` other columns.
    pub(crate) fn behind(before: usize, channels: usize) -> FileColumns {
        FileColumns {
            of_channels: (before + 1..=before + channels).collect(),
            count: before + channels,
        }
    }
}

/// What a log has.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Its format.
    pub format: Format,
    /// Its channels, group after group.
    pub channels: Vec<Channel>,
    /// Its columns; `None` where it has none, and channels are counted.
    pub columns: Option<FileColumns>,
    /// Number of clocks.
    pub groups: usize,
    /// What was found and taken for granted, for the user.
    pub said: Vec<String>,
    /// Of that, what was taken for the unit of its times.
    pub guessed_time: Option<String>,
}

impl Header {
    /// Places of the channels of a group, in the order of [`Row::values`].
    pub fn group(&self, group: usize) -> impl Iterator<Item = usize> + '_ {
        let channels = self.channels.iter().enumerate();
        channels.filter_map(move |(index, channel)| (channel.group == group).then_some(index))
    }
}

/// One sample of the channels of one clock.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Line of the log; of logs without lines the number of the row or message.
    pub line: u64,
    /// Time, s; of logs whose rate comes last the number of the row ([`crate::LogReader::time_scale_s`]).
    pub time_s: f64,
    /// The clock.
    pub group: usize,
    /// The recording: counts up where an unknown time was lost.
    pub part: u32,
    /// Values of the group's channels; NaN where a channel was not asked for and is no number.
    pub values: Vec<f64>,
}

/// The first bytes of a log and what follows.
pub(crate) type Input<R> = Chain<Cursor<Vec<u8>>, R>;

/// A reader of one format.
pub(crate) trait Source {
    /// The next row; false at the end.
    fn next_row(&mut self, row: &mut Row) -> Result<bool, LogError>;

    /// Channels that are read; a cell of another one may be anything.
    fn select(&mut self, _wanted: &[bool]) {}

    /// What was noticed up to now, for the user. Each remark is given once.
    fn remarks(&mut self) -> Vec<String> {
        Vec::new()
    }

    /// Seconds in one unit of [`Row::time_s`], known at the end.
    fn time_scale_s(&self) -> f64 {
        1.0
    }
}

/// The first lines of a log.
pub(crate) struct Head {
    /// Whole lines of the first bytes; the last one only where the file ends there.
    pub(crate) lines: Vec<String>,
}

impl Head {
    pub(crate) fn new(head: &[u8], whole: bool) -> Head {
        let bytes = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
        let text = match std::str::from_utf8(bytes) {
            Ok(text) => text.to_owned(),
            // A character may be cut at the end; Latin-1 elsewhere, as `Lines` takes it.
            Err(error) => match error.error_len() {
                None => String::from_utf8_lossy(bytes).into_owned(),
                Some(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
            },
        };
        let mut lines: Vec<String> = text
            .split('\n')
            .map(|line| line.trim_end_matches('\r').to_owned())
            .collect();
        // What follows the last line end is empty, or cut off by the end of the head.
        if !whole || lines.last().is_some_and(String::is_empty) {
            lines.pop();
        }
        if lines.is_empty() && !text.is_empty() {
            lines.push(text);
        }
        Head { lines }
    }

    /// Lines that are neither blank nor comments.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &str> {
        let lines = self.lines.iter().map(String::as_str);
        lines.filter(|line| !line.trim().is_empty())
    }
}
