//! One log, whatever its format: recognised from its first bytes, read row by row.

use crate::error::LogError;
use crate::text::Lines;
use crate::unit::Unit;
use crate::{accelerometer, camonitor, halsampler, halscope, sinumerik, table, tncscope, twincat};
use std::fmt;
use std::io::{BufRead, Chain, Cursor, Read};

/// Bytes that are looked at before the first row is given. A choice: the header of a trace with
/// some hundred signals, and enough rows to see which numbers belong together.
const HEAD_BYTES: usize = 1 << 16;

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
        })
    }
}

/// What a log does not say of itself.
#[derive(Clone, Debug, Default, PartialEq)]
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

/// What a log has.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Its format.
    pub format: Format,
    /// Its channels, group after group.
    pub channels: Vec<Channel>,
    /// Number of clocks.
    pub groups: usize,
    /// What was found and taken for granted, for the user.
    pub said: Vec<String>,
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
    /// Line of the log.
    pub line: u64,
    /// Time, s; of logs whose rate comes last the number of the row ([`LogReader::time_scale_s`]).
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

/// A log being read.
pub struct LogReader<'a> {
    name: String,
    header: Header,
    source: Box<dyn Source + 'a>,
    /// After the end, or an error, no row follows whatever stands behind.
    ended: bool,
}

impl fmt::Debug for LogReader<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LogReader")
            .field("name", &self.name)
            .field("header", &self.header)
            .finish_non_exhaustive()
    }
}

impl<'a> LogReader<'a> {
    /// Recognises the format and reads the header. `name` is the file's name for messages.
    ///
    /// # Errors
    /// An empty file, bytes that are no text, a format that is known and not readable, a header
    /// without columns of numbers, a log without times where [`ReadOptions::period_s`] is not given.
    pub fn new<R: BufRead + 'a>(
        mut input: R,
        name: &str,
        options: &ReadOptions,
    ) -> Result<LogReader<'a>, LogError> {
        if let Some(period_s) = options.period_s
            && !(period_s.is_finite() && period_s > 0.0)
        {
            let what = format!("a period of {period_s} s");
            return Err(LogError::file(name, what, "give a positive one"));
        }
        let mut head = Vec::new();
        let mut first = input.by_ref().take(HEAD_BYTES as u64);
        first
            .read_to_end(&mut head)
            .map_err(|source| LogError::Io {
                name: name.to_owned(),
                source,
            })?;
        let whole = head.len() < HEAD_BYTES;
        let seen = Head::new(&head, whole);
        refuse_others(name, &head, &seen)?;
        let format = seen.format();
        let input: Input<R> = Cursor::new(head.clone()).chain(input);
        if format == Format::SinumerikTrace {
            let (header, source) = sinumerik::open(input, name)?;
            return Ok(Self::of(name, header, source));
        }
        let lines = Lines::new(input, name);
        let (header, source): (Header, Box<dyn Source + 'a>) = match format {
            Format::HalscopeNamed | Format::Halscope | Format::HalscopeDisplay => {
                halscope::open(lines)?
            }
            Format::Halsampler => halsampler::open(lines, &seen, options)?,
            Format::TwincatScope => twincat::open(lines)?,
            Format::Tncscope => tncscope::open(lines)?,
            Format::Camonitor => camonitor::open(lines, &seen)?,
            Format::KlipperAccelerometer => accelerometer::klipper(lines)?,
            Format::DuetAccelerometer => accelerometer::duet(lines)?,
            _ => table::open(lines, &seen, options)?,
        };
        Ok(Self::of(name, header, source))
    }

    fn of(name: &str, header: Header, source: Box<dyn Source + 'a>) -> LogReader<'a> {
        LogReader {
            name: name.to_owned(),
            header,
            source,
            ended: false,
        }
    }

    /// The file's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Format, channels, and what was taken for granted.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Reads these channels alone: a cell of another one that is no number is NaN instead of an
    /// error.
    pub fn select(&mut self, channels: &[usize]) {
        let mut wanted = vec![false; self.header.channels.len()];
        for &channel in channels {
            if let Some(wanted) = wanted.get_mut(channel) {
                *wanted = true;
            }
        }
        self.source.select(&wanted);
    }

    /// Reads the next row; false at the end.
    ///
    /// # Errors
    /// A row that is not what the header says, with its line and column.
    pub fn next_row(&mut self, row: &mut Row) -> Result<bool, LogError> {
        if self.ended {
            return Ok(false);
        }
        let read = self.source.next_row(row);
        self.ended = !matches!(read, Ok(true));
        read
    }

    /// Seconds in one unit of [`Row::time_s`]; 1 but for logs that tell their rate at their end.
    pub fn time_scale_s(&self) -> f64 {
        self.source.time_scale_s()
    }

    /// What was noticed since the last call: rows that were dropped, columns that were left out.
    pub fn remarks(&mut self) -> Vec<String> {
        self.source.remarks()
    }
}

/// The first lines of a log.
pub(crate) struct Head {
    /// Whole lines of the first bytes; the last one only where the file ends there.
    pub(crate) lines: Vec<String>,
}

impl Head {
    fn new(head: &[u8], whole: bool) -> Head {
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

    fn format(&self) -> Format {
        let line = |index: usize| self.lines.get(index).map_or("", String::as_str);
        let first = line(0);
        if first.starts_with("Sampling period is ") {
            return Format::HalscopeNamed;
        }
        if first.starts_with("# Sampling period is ") {
            let display = line(2).starts_with("# Position:") || line(2).starts_with("# Scale:");
            return if display {
                Format::HalscopeDisplay
            } else {
                Format::Halscope
            };
        }
        if first.starts_with("%TNCscope") {
            return Format::Tncscope;
        }
        if self
            .lines
            .iter()
            .take(8)
            .any(|line| line.contains("<traceSession"))
        {
            return Format::SinumerikTrace;
        }
        if twincat::is_one(line(0), line(2)) {
            return Format::TwincatScope;
        }
        if first.starts_with("#time,accel_x") {
            return Format::KlipperAccelerometer;
        }
        if first.starts_with("Sample,X") || first.starts_with("Failed to start accelerometer") {
            return Format::DuetAccelerometer;
        }
        if camonitor::is_one(self) {
            return Format::Camonitor;
        }
        if halsampler::is_one(self) {
            return Format::Halsampler;
        }
        Format::Table
    }
}

/// What is no log of numbers at all, told by name.
fn refuse_others(name: &str, head: &[u8], seen: &Head) -> Result<(), LogError> {
    if head.is_empty() {
        return Err(LogError::file(name, "the file is empty", ""));
    }
    let begins = |bytes: &[u8]| head.starts_with(bytes);
    let known: &[(&[u8], &str, &str)] = &[
        (b"\xff\xfe", "UTF-16 text", "save it as UTF-8"),
        (b"\xfe\xff", "UTF-16 text", "save it as UTF-8"),
        (b"PAR1", "Parquet", "convert it to CSV"),
        (b"\x89MCAP", "MCAP", "convert it to CSV"),
        (b"\x1f\x8b", "compressed (gzip)", "decompress it first"),
        (
            b"PK\x03\x04",
            "a zip archive or a spreadsheet",
            "export it as CSV",
        ),
        (b"MATLAB 5.0", "a MATLAB file", "export it as CSV"),
        (
            b"THREAD ",
            "a set-up of HALscope, not its data",
            "use HALscope's `Save log`",
        ),
    ];
    for (start, what, hint) in known {
        if begins(start) {
            return Err(LogError::file(name, format!("this is {what}"), *hint));
        }
    }
    if let Some(at) = memchr::memchr(0, head) {
        let what = format!("byte 0x00 at offset {at}: this is no text");
        return Err(LogError::file(name, what, "export the log as text"));
    }
    if seen.rows().next().is_none() {
        return Err(LogError::file(name, "there are blank lines alone", ""));
    }
    Ok(())
}
