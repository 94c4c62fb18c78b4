//! Reading tables: a header, then numbers, with the place of whatever is wrong.

use crate::error::ReadError;
use csv::{ByteRecord, ErrorKind};
use lostmotion_base::text::shortened;
use lostmotion_drive::config::AxisUnit;
use std::io::Read;

/// Rows end here. With the default, which takes `\r\n` as one end, the reader's line numbers lag by
/// one behind `\r\n`; the `\r` is trimmed with the blanks instead.
const ROW_END: csv::Terminator = csv::Terminator::Any(b'\n');

/// Longest piece of a file shown in a message, characters. A choice: most of a terminal's line.
const LONGEST_SHOWN: usize = 60;

/// Largest magnitude of a number in a table, in whatever unit it is: no place, time or current of a
/// machine, nor a time since 1970 in ms, comes near. A choice.
const LARGEST: f64 = 1e13;

/// The units that a column's name can state.
pub(super) const UNITS: [AxisUnit; 3] = [AxisUnit::Mm, AxisUnit::Deg, AxisUnit::Rad];

/// A table being read row by row.
pub(super) struct Cells<R> {
    name: String,
    reader: csv::Reader<Kept<R>>,
    header: Vec<String>,
    header_line: u64,
    record: ByteRecord,
}

/// A column that was found: its place and its header.
#[derive(Clone, Debug)]
pub(super) struct Column {
    index: usize,
    pub(super) header: String,
}

impl<R: Read> Cells<R> {
    /// Reads the header. `name` is the file's name for messages.
    pub(super) fn new(input: R, name: &str) -> Result<Cells<R>, ReadError> {
        // Rows of any length are let through here: their refusal needs the line and both counts.
        let mut reader = csv::ReaderBuilder::new()
            // The header is read as a row, for its line and for messages about it.
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .terminator(ROW_END)
            .from_reader(Kept {
                input,
                bytes: Some(Vec::new()),
                count: 0,
                last: b'\n',
            });
        let mut record = ByteRecord::new();
        let read = reader
            .read_byte_record(&mut record)
            .map_err(|e| read_error(name, e))?;
        if !read {
            return Err(ReadError::Empty {
                name: name.to_owned(),
                needed: 1,
            });
        }
        let header_line = line_of(&reader, &record);
        // Only the header is looked for in the bytes themselves: rows need none of them kept.
        let raw = reader.get_mut().bytes.take().unwrap_or_default();
        let header = header_cells(&record).map_err(|(byte, before)| ReadError::NotText {
            name: name.to_owned(),
            line: header_line,
            byte,
            offset: offset_of(&raw, &record, before),
        })?;
        Ok(Cells {
            name: name.to_owned(),
            reader,
            header,
            header_line,
            record,
        })
    }

    /// The file's name.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// The column of exactly this name.
    pub(super) fn column(&self, wanted: &str) -> Result<Column, ReadError> {
        self.find(wanted)?
            .ok_or_else(|| self.missing(format!("`{wanted}`")))
    }

    /// The column `stem_mm`, `stem_deg` or `stem_rad`.
    pub(super) fn column_with_unit(
        &self,
        stem: &str,
        what: &'static str,
    ) -> Result<(Column, AxisUnit), ReadError> {
        let of_unit = |unit: AxisUnit| {
            let column = self.find(&format!("{stem}_{}", unit.symbol()));
            column.map(|column| Some((column?, unit))).transpose()
        };
        let found: Vec<(Column, AxisUnit)> = UNITS
            .into_iter()
            .filter_map(of_unit)
            .collect::<Result<_, _>>()?;
        // Two columns of one quantity may disagree: refused, not chosen between.
        match found.as_slice() {
            [] => Err(self.missing(format!("`{stem}_mm`, `{stem}_deg` or `{stem}_rad`"))),
            [one] => Ok(one.clone()),
            [first, second, ..] => Err(self.ambiguous(what, &first.0, &second.0)),
        }
    }

    /// Two columns of one quantity.
    pub(super) fn ambiguous(
        &self,
        what: &'static str,
        first: &Column,
        second: &Column,
    ) -> ReadError {
        ReadError::AmbiguousColumn {
            name: self.name.clone(),
            line: self.header_line,
            what,
            first: first.header.clone(),
            second: second.header.clone(),
        }
    }

    /// The column of exactly this name, if there is one. Of two with that name neither is taken:
    /// they may disagree.
    pub(super) fn find(&self, wanted: &str) -> Result<Option<Column>, ReadError> {
        let header = self.header.iter().enumerate();
        let mut named = header.filter(|(_, cell)| *cell == wanted);
        let first = named.next();
        if named.next().is_some() {
            return Err(ReadError::RepeatedColumn {
                name: self.name.clone(),
                line: self.header_line,
                column: wanted.to_owned(),
            });
        }
        Ok(first.map(|(index, _)| Column {
            index,
            header: wanted.to_owned(),
        }))
    }

    fn missing(&self, wanted: String) -> ReadError {
        let found = shortened(&self.header.join(", "), 3 * LONGEST_SHOWN);
        ReadError::MissingColumn {
            name: self.name.clone(),
            line: self.header_line,
            wanted,
            found,
        }
    }

    /// Goes to the next row that is not blank; false at the end.
    pub(super) fn next_row(&mut self) -> Result<bool, ReadError> {
        loop {
            if !self
                .reader
                .read_byte_record(&mut self.record)
                .map_err(|e| read_error(&self.name, e))?
            {
                return Ok(false);
            }
            let (wanted, found) = (self.header.len() as u64, self.record.len() as u64);
            if wanted == found {
                return Ok(true);
            }
            // A line of blanks at the end is no row with too few cells.
            let blank = found == 1 && self.record.iter().all(|cell| cell.trim_ascii().is_empty());
            if !blank {
                return Err(ReadError::Ragged {
                    name: self.name.clone(),
                    line: line_of(&self.reader, &self.record),
                    wanted,
                    found,
                });
            }
        }
    }

    /// A finite number of the current row.
    pub(super) fn number(&self, column: &Column) -> Result<f64, ReadError> {
        let bytes = self
            .record
            .get(column.index)
            .unwrap_or_default()
            .trim_ascii();
        if bytes.is_empty() {
            return Err(self.bad(column, "is empty", "every row needs a number here"));
        }
        // Rust reads `inf` and `nan` as numbers, too: they would spread through everything computed
        // from the table.
        match std::str::from_utf8(bytes)
            .ok()
            .and_then(|text| text.parse::<f64>().ok())
        {
            None => Err(self.bad(
                column,
                "is not a number",
                "write numbers like -1.25 or 3e-4, with a point",
            )),
            Some(value) if !value.is_finite() => Err(self.bad(
                column,
                "is not a finite number",
                "remove the row, or fill in a value",
            )),
            Some(value) if value.abs() > LARGEST => Err(self.bad(
                column,
                format!("is beyond {LARGEST:e}"),
                "no machine has such a value; remove the row, or fill in another one",
            )),
            Some(value) => Ok(value),
        }
    }

    /// An error about a cell of the current row.
    pub(super) fn bad(
        &self,
        column: &Column,
        why: impl Into<String>,
        hint: &'static str,
    ) -> ReadError {
        let value = String::from_utf8_lossy(self.record.get(column.index).unwrap_or_default())
            .trim()
            .to_owned();
        ReadError::Cell {
            name: self.name.clone(),
            line: line_of(&self.reader, &self.record),
            column: column.header.clone(),
            value: shortened(&value, LONGEST_SHOWN),
            why: why.into(),
            hint,
        }
    }
}

/// The line that the row just read begins in, from 1. Its own position does not tell: comments and
/// blank lines before it count as part of it.
fn line_of<R: Read>(reader: &csv::Reader<Kept<R>>, record: &ByteRecord) -> u64 {
    let (end, input) = (reader.position(), reader.get_ref());
    // The reader stands behind the row: in the next line, if the row has an end.
    let unended = end.byte() == input.count && input.last != b'\n';
    // Quoted cells may hold line ends.
    let inner = record.as_slice().iter().filter(|byte| **byte == b'\n');
    let lines = inner.count() as u64 + u64::from(!unended);
    end.line().saturating_sub(lines).max(1)
}

/// The header's cells without blanks and byte order mark; the first byte that is no text, and how
/// many bytes of the cells are before it, quotes not counted.
fn header_cells(record: &ByteRecord) -> Result<Vec<String>, (u8, usize)> {
    let mut before = 0;
    let mut cells = Vec::with_capacity(record.len());
    for (index, cell) in record.iter().enumerate() {
        let at = |place: usize| (cell[place], before + unquoted(&cell[..place]));
        // Where the text stops being UTF-8.
        let text = std::str::from_utf8(cell).map_err(|e| at(e.valid_up_to()))?;
        // Control characters are UTF-8, too: they tell a binary file from a table.
        if let Some(place) = text.trim_end().bytes().position(|b| b < b' ' && b != b'\t') {
            return Err(at(place));
        }
        // Spreadsheets write a byte order mark before the first name.
        let text = if index == 0 {
            text.trim_start_matches('\u{feff}')
        } else {
            text
        };
        cells.push(text.trim().to_owned());
        // The cell and its comma.
        before += unquoted(cell) + 1;
    }
    Ok(cells)
}

/// Number of bytes that are no quotes.
fn unquoted(bytes: &[u8]) -> usize {
    bytes.iter().filter(|byte| **byte != b'"').count()
}

/// Offset in the file of a byte of the header that has so many bytes of the cells before it. `raw`
/// is the file from its start.
fn offset_of(raw: &[u8], record: &ByteRecord, before: usize) -> u64 {
    let mut start = record.position().map_or(0, csv::Position::byte) as usize;
    // The reader drops a byte order mark, blank lines and comments, all of which stand before the
    // header's first cell.
    let is_mark = |rest: &[u8]| rest.starts_with(b"\xef\xbb\xbf");
    if start == 0 && is_mark(raw) && !record.iter().next().is_some_and(is_mark) {
        start = 3;
    }
    while let Some(b'#' | b'\n') = raw.get(start) {
        let line = raw.iter().skip(start).position(|byte| *byte == b'\n');
        start += line.map_or(1, |end| end + 1);
    }
    // Quotes may stand around a cell and doubled within it: both sides are counted without them.
    let rest = raw.iter().enumerate().skip(start);
    let mut text = rest.filter(|(_, byte)| **byte != b'"');
    text.nth(before).map_or(start, |(offset, _)| offset) as u64
}

/// An input of which what is read is kept, until it is taken.
struct Kept<R> {
    input: R,
    bytes: Option<Vec<u8>>,
    /// Number of bytes read, and the last of them.
    count: u64,
    last: u8,
}

impl<R: Read> Read for Kept<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.input.read(buffer)?;
        self.count += count as u64;
        if let Some(last) = buffer.iter().take(count).next_back() {
            self.last = *last;
        }
        if let Some(kept) = &mut self.bytes {
            kept.extend(buffer.iter().take(count));
        }
        Ok(count)
    }
}

fn read_error(name: &str, error: csv::Error) -> ReadError {
    let name = name.to_owned();
    // Rows of bytes are refused by the system alone; any other kind is shown as it is.
    match error.into_kind() {
        ErrorKind::Io(source) => ReadError::Io { name, source },
        other => ReadError::Io {
            name,
            source: std::io::Error::other(format!("{other:?}")),
        },
    }
}
