//! One log, whatever its format: recognised from its first bytes, read row by row.

use crate::error::LogError;
#[cfg(feature = "mcap")]
use crate::mcap;
#[cfg(feature = "parquet")]
use crate::parquet;
use crate::source::{Format, Head, Header, Input, ReadOptions, Row, Source};
use crate::text::Lines;
use crate::{accelerometer, camonitor, halsampler, halscope, sinumerik, table, tncscope, twincat};
use std::fmt;
use std::io::{self, BufRead, BufReader, Cursor, Read};

/// Bytes that are looked at before the first row is given. A choice: the header of a trace with
/// some hundred signals, and enough rows to see which numbers belong together.
const HEAD_BYTES: usize = 1 << 16;

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
        #[cfg(feature = "parquet")]
        if head.starts_with(parquet::MAGIC) {
            let (header, source) = parquet::open(head.chain(input), name, options)?;
            return Ok(Self::of(name, header, source));
        }
        #[cfg(feature = "mcap")]
        if head.starts_with(mcap::MAGIC) {
            let input: Input<R> = Cursor::new(head).chain(input);
            let (header, source) = mcap::open(input, name, options)?;
            return Ok(Self::of(name, header, source));
        }
        let whole = head.len() < HEAD_BYTES;
        if memchr::memchr(b'\n', &head).is_none() && memchr::memchr(b'\r', &head).is_some() {
            let fed = LineFeeds(Cursor::new(head).chain(input));
            let fed: Box<dyn BufRead + 'a> = Box::new(BufReader::new(fed));
            return Self::new(fed, name, options);
        }
        let seen = Head::new(&head, whole);
        refuse_others(name, &head, &seen)?;
        let format = format(&seen);
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

/// A text whose lines end with CR alone, with LF in its place.
struct LineFeeds<R>(R);

impl<R: Read> Read for LineFeeds<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.0.read(buffer)?;
        for byte in buffer.iter_mut().take(count).filter(|byte| **byte == b'\r') {
            *byte = b'\n';
        }
        Ok(count)
    }
}

/// The format of a log that begins so.
fn format(head: &Head) -> Format {
    let line = |index: usize| head.lines.get(index).map_or("", String::as_str);
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
    if head
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
    if camonitor::is_one(head) {
        return Format::Camonitor;
    }
    if halsampler::is_one(head) {
        return Format::Halsampler;
    }
    Format::Table
}

const UNPACK: &str = "decompress it first";
const OTHER_TABLE: &str = "export it as CSV or Parquet";

/// What is no log of numbers at all, told by name.
fn refuse_others(name: &str, head: &[u8], seen: &Head) -> Result<(), LogError> {
    if head.is_empty() {
        return Err(LogError::file(name, "the file is empty", ""));
    }
    let begins = |bytes: &[u8]| head.starts_with(bytes);
    let known: &[(&[u8], &str, &str)] = &[
        (b"\xff\xfe", "UTF-16 text", "save it as UTF-8"),
        (b"\xfe\xff", "UTF-16 text", "save it as UTF-8"),
        (
            b"PAR1",
            "Parquet, which this build does not read",
            "build it with the feature parquet, or convert the log to CSV",
        ),
        (
            b"\x89MCAP",
            "MCAP, which this build does not read",
            "build it with the feature mcap, or convert the log to CSV",
        ),
        (b"\x1f\x8b", "compressed (gzip)", UNPACK),
        (b"\x28\xb5\x2f\xfd", "compressed (Zstandard)", UNPACK),
        (b"\xfd7zXZ", "compressed (xz)", UNPACK),
        (b"BZh", "compressed (bzip2)", UNPACK),
        (b"ARROW1", "an Arrow (Feather) file", OTHER_TABLE),
        (b"\x89HDF", "an HDF5 file", OTHER_TABLE),
        (b"TDSm", "a TDMS file", OTHER_TABLE),
        (b"SQLite format 3", "a SQLite database", OTHER_TABLE),
        (b"#ROSBAG", "a bag of ROS 1", "convert it to MCAP"),
        (
            b"PK\x03\x04",
            "a zip archive or a spreadsheet",
            "export it as CSV",
        ),
        (b"MATLAB 5.0", "a MATLAB file", OTHER_TABLE),
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
