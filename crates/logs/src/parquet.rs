//! Apache Parquet: the flat columns of numbers, brought from columns into rows.
//!
//! The directory of a file stands at its end, so the file is held whole, up to
//! [`ReadOptions::max_bytes`]; its pages are unpacked one by one.

use crate::error::LogError;
use crate::parquet_pages::Pages;
use crate::roles::{period_s, time_among, time_unit};
use crate::source::{Channel, FileColumns, Format, Header, MAX_CHANNELS, ReadOptions, Row, Source};
use crate::text::is_measured;
use crate::thrift;
use crate::unit::Unit;
use bytes::Bytes;
use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type as Physical};
use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetMetaData;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;
use std::io::Read;

/// What a file begins with.
pub(crate) const MAGIC: &[u8] = b"PAR1";

/// What the numbers of a column are.
#[derive(Clone, Copy, PartialEq)]
enum ColumnKind {
    Plain,
    /// Whole numbers of which so many are one.
    Decimal(f64),
    /// Whole numbers without a sign.
    Unsigned,
    /// Points in time, with this worth in s.
    Stamp(f64),
}

/// A column that is read.
struct ParquetColumn {
    /// Its place among the leaves of the schema.
    leaf: usize,
    name: String,
    kind: ColumnKind,
    /// Levels of a value that is there; fewer are null.
    level: i16,
    wanted: bool,
    physical: Physical,
    pages: Option<Pages>,
    /// Value of the row; `None` where it is null.
    value: Option<f64>,
    /// The first point in time, from which they count.
    origin: Option<i64>,
}

struct ParquetTable {
    name: String,
    bytes: Bytes,
    file: SerializedFileReader<Bytes>,
    columns: Vec<ParquetColumn>,
    time: Option<usize>,
    time_factor: f64,
    /// The next row group.
    group: usize,
    /// Rows of the one before that are still to come.
    left: u64,
    most_bytes: usize,
    rows: u64,
}

/// An error of the format, as one of the file.
fn damaged(name: &str, error: &ParquetError) -> LogError {
    let text = error.to_string();
    // Brotli and LZO are rare.
    let (what, hint) = match text.split_once("Disabled feature at compile time: ") {
        Some((_, codec)) => (
            format!("this Parquet file is compressed with {codec}, which is not read"),
            "write it with zstd, snappy, gzip or lz4, or without compression",
        ),
        None => (
            format!("this Parquet file cannot be read: {text}"),
            "the file may be cut or damaged",
        ),
    };
    LogError::file(name, what, hint)
}

/// The whole of a log, or a refusal of one that is too large.
fn whole(mut input: impl Read, name: &str, most: usize) -> Result<Bytes, LogError> {
    let mut bytes = Vec::new();
    let read = input
        .by_ref()
        .take(most as u64 + 1)
        .read_to_end(&mut bytes)
        .map_err(|source| LogError::Io {
            name: name.to_owned(),
            source,
        });
    read?;
    if bytes.len() > most {
        let what =
            format!("a Parquet file is held in memory, and this one has more than {most} bytes");
        let hint = "allow more with --max-memory-mb, or write fewer columns or rows";
        return Err(LogError::file(name, what, hint));
    }
    Ok(bytes.into())
}

/// Refuses a footer whose lists are longer than it.
fn check_footer(bytes: &[u8]) -> Result<(), &'static str> {
    // What is no footer is refused by the format's reader.
    let Some((before, [a, b, c, d, ..])) = bytes.split_last_chunk::<8>() else {
        return Ok(());
    };
    let length = u32::from_le_bytes([*a, *b, *c, *d]);
    let first = usize::try_from(length)
        .ok()
        .and_then(|length| before.len().checked_sub(length));
    first.map_or(Ok(()), |first| thrift::pass(&before[first..]).map(drop))
}

/// Refuses column chunks that lie outside of the file, and counts below zero: the format's reader
/// takes them for granted.
fn check_places(file: &ParquetMetaData, length: u64) -> Result<(), ParquetError> {
    let leaves = file.file_metadata().schema_descr().num_columns();
    for group in file.row_groups() {
        if group.num_columns() != leaves || group.num_rows() < 0 {
            let what = "a row group has not the columns of the schema, or fewer than no rows";
            return Err(ParquetError::General(what.to_owned()));
        }
        for column in group.columns() {
            let first = column.dictionary_page_offset();
            let first = first.unwrap_or_else(|| column.data_page_offset());
            let range = u64::try_from(first)
                .ok()
                .zip(u64::try_from(column.compressed_size()).ok());
            let end = range.and_then(|(first, size)| first.checked_add(size));
            if column.num_values() < 0 || end.is_none_or(|end| end > length) {
                let path = column.column_path().string();
                let what = format!("column `{path}` lies outside of the file");
                return Err(ParquetError::General(what));
            }
        }
    }
    Ok(())
}

/// What a leaf of the schema is; `None` where it is no column of numbers.
fn kind(column: &ColumnDescriptor) -> Option<ColumnKind> {
    let by_logical = match column.logical_type_ref() {
        Some(LogicalType::Timestamp(stamp)) => Some(&stamp.unit),
        _ => None,
    };
    let stamp = match (by_logical, column.converted_type()) {
        (Some(TimeUnit::MILLIS), _) | (None, ConvertedType::TIMESTAMP_MILLIS) => Some(1e-3),
        (Some(TimeUnit::MICROS), _) | (None, ConvertedType::TIMESTAMP_MICROS) => Some(1e-6),
        (Some(TimeUnit::NANOS), _) => Some(1e-9),
        _ => None,
    };
    let unsigned = matches!(
        column.converted_type(),
        ConvertedType::UINT_8
            | ConvertedType::UINT_16
            | ConvertedType::UINT_32
            | ConvertedType::UINT_64
    );
    match column.physical_type() {
        Physical::INT64 if stamp.is_some() => stamp.map(ColumnKind::Stamp),
        Physical::INT32 | Physical::INT64 if column.converted_type() == ConvertedType::DECIMAL => {
            // Powers of ten are whole numbers in a double up to this one.
            let scale = u32::try_from(column.type_scale())
                .ok()
                .filter(|scale| *scale <= 22);
            scale.map(|scale| ColumnKind::Decimal(10_u128.pow(scale) as f64))
        }
        Physical::INT32 | Physical::INT64 if unsigned => Some(ColumnKind::Unsigned),
        Physical::INT32
        | Physical::INT64
        | Physical::FLOAT
        | Physical::DOUBLE
        | Physical::BOOLEAN => Some(ColumnKind::Plain),
        Physical::INT96 | Physical::BYTE_ARRAY | Physical::FIXED_LEN_BYTE_ARRAY => None,
    }
}

pub(crate) fn open<'a>(
    input: impl Read,
    name: &str,
    options: &ReadOptions,
) -> Result<(Header, Box<dyn Source + 'a>), LogError> {
    let bytes = whole(input, name, options.max_bytes)?;
    let length = bytes.len() as u64;
    check_footer(&bytes).map_err(|what| damaged(name, &ParquetError::General(what.to_owned())))?;
    let file = SerializedFileReader::new(bytes.clone()).map_err(|error| damaged(name, &error))?;
    check_places(file.metadata(), length).map_err(|error| damaged(name, &error))?;
    let schema = file.metadata().file_metadata().schema_descr();
    let (mut columns, mut left_out) = (Vec::new(), Vec::new());
    for (leaf, column) in schema.columns().iter().enumerate() {
        let called = column.path().string();
        match kind(column).filter(|_| column.max_rep_level() == 0) {
            Some(kind) => columns.push(ParquetColumn {
                leaf,
                name: called,
                kind,
                level: column.max_def_level(),
                wanted: true,
                physical: column.physical_type(),
                pages: None,
                value: None,
                origin: None,
            }),
            None => left_out.push(called),
        }
    }
    let mut said = Vec::new();
    if !left_out.is_empty() {
        let names = lostmotion_base::text::shortened(&left_out.join(", "), 180);
        said.push(format!(
            "columns without one number a row are left out: {names}"
        ));
    }
    let (time, time_factor, guessed_time) = time(name, &columns, options, &mut said)?;
    let channels: Vec<Channel> = columns
        .iter()
        .enumerate()
        .filter(|(place, _)| Some(*place) != time)
        .map(|(_, column)| Channel {
            name: column.name.clone(),
            unit: Unit::in_name(&column.name),
            group: 0,
        })
        .collect();
    let of_channels = columns
        .iter()
        .enumerate()
        .filter(|(place, _)| Some(*place) != time)
        .map(|(_, column)| column.leaf + 1)
        .collect();
    if channels.is_empty() || channels.len() > MAX_CHANNELS {
        let what = format!("{} columns of numbers besides the time", channels.len());
        return Err(LogError::file(name, what, ""));
    }
    let header = Header {
        columns: Some(FileColumns {
            of_channels,
            count: schema.num_columns(),
        }),
        format: Format::Parquet,
        channels,
        groups: 1,
        said,
        guessed_time,
    };
    let table = ParquetTable {
        name: name.to_owned(),
        bytes,
        file,
        columns,
        time,
        time_factor,
        group: 0,
        left: 0,
        most_bytes: options.max_bytes,
        rows: 0,
    };
    Ok((header, Box::new(table)))
}

/// The column of times and its worth in s, or the period of the rows.
fn time(
    name: &str,
    columns: &[ParquetColumn],
    options: &ReadOptions,
    said: &mut Vec<String>,
) -> Result<(Option<usize>, f64, Option<String>), LogError> {
    let refused = |(what, hint): (String, &str)| LogError::file(name, what, hint);
    let names: Vec<String> = columns.iter().map(|column| column.name.clone()).collect();
    let mut found = time_among(&names, options).map_err(refused)?;
    if found.is_none() && options.period_s.is_none() {
        // The one column of points in time needs no name.
        let mut stamps = (0..columns.len()).filter(|&place| {
            columns
                .get(place)
                .is_some_and(|column| matches!(column.kind, ColumnKind::Stamp(_)))
        });
        found = stamps.next().filter(|_| stamps.next().is_none());
    }
    let Some((place, column)) = found.and_then(|place| Some((place, columns.get(place)?))) else {
        let period_s = period_s(&names, options).map_err(refused)?;
        said.push(format!("rows are taken to be {} ms apart", 1e3 * period_s));
        return Ok((None, period_s, None));
    };
    if matches!(column.kind, ColumnKind::Stamp(_)) {
        said.push(format!(
            "`{}` holds points in time: they count from the first one",
            column.name
        ));
        return Ok((Some(place), 1.0, None));
    }
    let (unit, guess) = time_unit(&column.name, None, options).map_err(refused)?;
    said.extend(guess.clone());
    Ok((Some(place), unit.factor, guess))
}

impl ParquetColumn {
    /// Takes the value of the next row.
    fn advance(&mut self) -> Result<(), ParquetError> {
        let stored = match &mut self.pages {
            Some(pages) => pages.value()?,
            None => None,
        };
        let (kind, physical, origin) = (self.kind, self.physical, &mut self.origin);
        self.value = stored.map(|stored| match (kind, physical) {
            (_, Physical::DOUBLE) => f64::from_bits(stored),
            (_, Physical::FLOAT) => f64::from(f32::from_bits(stored as u32)),
            (ColumnKind::Unsigned, Physical::INT32) => f64::from(stored as u32),
            (ColumnKind::Unsigned, _) => stored as f64,
            (ColumnKind::Plain, _) => stored.cast_signed() as f64,
            (ColumnKind::Decimal(parts), _) => stored.cast_signed() as f64 / parts,
            // Apart from the first one, so that no nanosecond is lost in a large number.
            (ColumnKind::Stamp(factor), _) => {
                let first = *origin.get_or_insert(stored.cast_signed());
                stored.cast_signed().saturating_sub(first) as f64 * factor
            }
        });
        Ok(())
    }
}

impl ParquetTable {
    /// Takes the next row from its columns; false at the end.
    fn advance(&mut self) -> Result<bool, LogError> {
        let name = &self.name;
        while self.left == 0 {
            if self.group >= self.file.num_row_groups() {
                return Ok(false);
            }
            let group = self.file.metadata().row_group(self.group);
            self.left = u64::try_from(group.num_rows()).unwrap_or_default();
            let rows = usize::try_from(self.left).unwrap_or(usize::MAX);
            for column in &mut self.columns {
                let chunk = group.column(column.leaf);
                let pages = Pages::new(&self.bytes, chunk, rows, column.level, self.most_bytes);
                column.pages = Some(pages.map_err(|error| damaged(name, &error))?);
            }
            self.group += 1;
        }
        for column in &mut self.columns {
            column.advance().map_err(|error| {
                let what = format!("column `{}`: {error}", column.name);
                LogError::line(name, self.rows + 1, what, "the file is damaged")
                    .counting(Format::Parquet.counted())
            })?;
        }
        self.left -= 1;
        Ok(true)
    }

    /// A number of the row, or why it is none.
    fn value(&self, column: &ParquetColumn) -> Result<f64, LogError> {
        let (shown, what) = match column.value {
            Some(value) if is_measured(value) => return Ok(value),
            Some(value) if value.is_finite() => (
                format!("{value:e}"),
                "is larger than anything measured (1e30)",
            ),
            Some(value) => (value.to_string(), "is not a finite number"),
            None => ("null".to_owned(), "is no number"),
        };
        let hint = "remove the row, or the column";
        let row = self.rows + 1;
        let error = LogError::cell(&self.name, row, &column.name, &shown, what, hint);
        Err(error.counting(Format::Parquet.counted()))
    }
}

impl Source for ParquetTable {
    fn next_row(&mut self, row: &mut Row) -> Result<bool, LogError> {
        if !self.advance()? {
            return Ok(false);
        }
        row.values.clear();
        row.time_s = self.rows as f64 * self.time_factor;
        for (place, column) in self.columns.iter().enumerate() {
            if Some(place) == self.time {
                row.time_s = self.time_factor * self.value(column)?;
                continue;
            }
            match self.value(column) {
                Ok(value) => row.values.push(value),
                Err(_) if !column.wanted => row.values.push(f64::NAN),
                Err(error) => return Err(error),
            }
        }
        self.rows += 1;
        row.line = self.rows;
        row.group = 0;
        row.part = 0;
        Ok(true)
    }

    fn select(&mut self, wanted: &[bool]) {
        let mut wanted = wanted.iter();
        for (place, column) in self.columns.iter_mut().enumerate() {
            if Some(place) != self.time {
                column.wanted = wanted.next().copied().unwrap_or_default();
            }
        }
    }
}
