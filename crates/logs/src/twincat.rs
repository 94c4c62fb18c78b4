//! TwinCAT Scope's text export: header rows keyed by their first cell, groups of channels with a
//! column of times each.

use crate::error::LogError;
use crate::source::{Channel, FileColumns, Format, Header, MAX_CHANNELS, Row, Source};
use crate::text::{Lines, Separator, Splitter, no_number, number};
use std::borrow::Cow;
use std::io::BufRead;

/// Most header rows between the names and the data. A choice: today's scopes write 17.
const MAX_HEADER_ROWS: usize = 64;
/// Times from here on count 100 ns since 1601: those of a record in ms are far below.
const LEAST_FILETIME: f64 = 1e16;
/// Whole numbers beyond this lose digits as f64.
const WHOLE_BITS: &str = "INT64";

/// Whether these are the first and third line of such a file.
pub(crate) fn is_one(first: &str, third: &str) -> bool {
    first.starts_with("Name")
        && third
            .trim_start_matches('"')
            .starts_with("Starttime of export")
}

/// A header row: its key and its cells, the key among them for columns of times.
struct KeyedRow {
    key: String,
    cells: Vec<String>,
}

/// A time column or a channel.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Time,
    Value,
}

/// Reads the header rows.
pub(crate) fn open<'a, R: BufRead + 'a>(
    mut lines: Lines<R>,
) -> Result<(Header, Box<dyn Source + 'a>), LogError> {
    lines.advance()?;
    let behind = lines.text().chars().nth("Name".len());
    let separator = behind.filter(|c| !c.is_alphanumeric()).unwrap_or('\t');
    let separator = Separator::Char(separator);
    let mut splitter = separator.splitter();
    let rows = header_rows(&mut lines, &mut splitter)?;
    let first = (lines.line(), lines.text().to_owned(), lines.ended());
    let mut cells = Vec::new();
    splitter.split(&first.1, &mut cells);
    while cells.last().is_some_and(|cell| cell.is_empty()) {
        cells.pop();
    }
    let rows = HeaderRows {
        rows,
        columns: cells.len(),
    };
    let Some(names) = rows.exact("Name").or_else(|| rows.exact("SymbolName")) else {
        let what = format!(
            "no header row tells the {} columns of the data",
            rows.columns
        );
        return Err(LogError::line(
            lines.name(),
            first.0,
            what,
            "names hold the separator: export with semicolons or tabs",
        ));
    };
    let mut said = vec![format!("{}s between cells", separator.shown())];
    if names.key != "Name" {
        said.push("names hold the separator: channels are called by their symbols".to_owned());
    }
    let columns = rows
        .columns_of(names, &mut said)
        .map_err(|what| LogError::line(lines.name(), first.0, what, ""))?;
    let header = columns.header(said);
    let source = Twincat {
        names: header
            .channels
            .iter()
            .map(|channel| channel.name.clone())
            .collect(),
        wanted: vec![true; header.channels.len()],
        lines,
        splitter,
        places: columns.places,
        decimal: None,
        next: Some(first),
        cells: Vec::new(),
        current: None,
        origin: None,
        after_blank: false,
        remarks: Vec::new(),
    };
    Ok((header, Box::new(source)))
}

/// The header rows, and how many columns the data have.
struct HeaderRows {
    rows: Vec<KeyedRow>,
    columns: usize,
}

impl HeaderRows {
    /// The row of a key. Names with the separator in them make a header row longer than the data: then the
    /// symbols' names tell the columns.
    fn named(&self, key: &str) -> Option<&KeyedRow> {
        self.rows.iter().find(|row| {
            row.key == key && trimmed(&row.cells) <= self.columns && row.cells.len() >= self.columns
        })
    }

    /// The row of a key, if it tells which columns are times.
    fn exact(&self, key: &str) -> Option<&KeyedRow> {
        self.named(key).filter(|row| {
            row.cells
                .iter()
                .take(self.columns)
                .any(|cell| *cell == row.key)
        })
    }

    /// The columns as the row with their names tells them.
    ///
    /// # Errors
    /// What is wrong with them.
    fn columns_of(&self, names: &KeyedRow, said: &mut Vec<String>) -> Result<Columns, String> {
        let (mut places, mut channels, mut groups) = (Vec::new(), Vec::new(), 0);
        for (column, cell) in names.cells.iter().take(self.columns).enumerate() {
            if *cell == names.key {
                places.push(Place::Time);
                groups += 1;
                continue;
            }
            let Some(group) = usize::checked_sub(groups, 1) else {
                return Err("the first column is no column of times".to_owned());
            };
            places.push(Place::Value);
            channels.push(self.channel(column, cell, group, said));
        }
        if channels.len() > MAX_CHANNELS || channels.is_empty() {
            return Err(format!("{} channels", channels.len()));
        }
        if groups > 1 {
            said.push(format!("{groups} columns of times"));
        }
        Ok(Columns {
            places,
            channels,
            groups,
        })
    }

    /// The channel of a column, and what the user has to know of it.
    fn channel(&self, column: usize, name: &str, group: usize, said: &mut Vec<String>) -> Channel {
        let of = |key: &str| self.named(key).and_then(|row| row.cells.get(column));
        for key in ["ScaleFactor", "Unit ScaleFactor"] {
            if let Some(factor) = of(key).filter(|factor| *factor != "1") {
                said.push(format!(
                    "`{name}` is shown with {key} {factor}; values are taken as they stand"
                ));
            }
        }
        if of("Data-Type").is_some_and(|kind| kind.ends_with(WHOLE_BITS)) {
            said.push(format!(
                "`{name}` has 64 bits: whole numbers above 2^53 lose digits"
            ));
        }
        Channel {
            name: name.to_owned(),
            unit: of("Unit").and_then(|unit| unit.parse().ok()),
            group,
        }
    }
}

/// What each column is.
struct Columns {
    places: Vec<Place>,
    channels: Vec<Channel>,
    /// Columns of times.
    groups: usize,
}

impl Columns {
    /// The header of the log.
    fn header(&self, said: Vec<String>) -> Header {
        let is_value = |(_, place): &(usize, &Place)| matches!(place, Place::Value);
        let of_channels = self.places.iter().enumerate().filter(is_value);
        let of_channels = of_channels.map(|(column, _)| column + 1).collect();
        Header {
            columns: Some(FileColumns {
                of_channels,
                count: self.places.len(),
            }),
            format: Format::TwincatScope,
            groups: self.groups,
            channels: self.channels.clone(),
            said,
            guessed_time: None,
        }
    }
}

/// Cells without the empty ones at the end.
fn trimmed(cells: &[String]) -> usize {
    cells
        .iter()
        .rposition(|cell| !cell.is_empty())
        .map_or(0, |last| last + 1)
}

/// Reads up to the first row of data, which stays in `lines`.
fn header_rows<R: BufRead>(
    lines: &mut Lines<R>,
    splitter: &mut Splitter,
) -> Result<Vec<KeyedRow>, LogError> {
    let mut rows: Vec<KeyedRow> = Vec::new();
    // The first four lines tell of the export itself; then the names begin.
    let mut began = false;
    while lines.advance()? {
        let text = lines.text();
        if text.trim().is_empty() {
            continue;
        }
        let mut cells = Vec::new();
        splitter.split(text, &mut cells);
        let first = cells.first().map_or("", |cell| cell.as_ref());
        let is_number = number(first, '.').is_some() || number(first, ',').is_some();
        if began && is_number {
            return Ok(rows);
        }
        began |= first == "Name";
        if began {
            if rows.len() == MAX_HEADER_ROWS {
                break;
            }
            rows.push(KeyedRow {
                key: first.to_owned(),
                cells: cells.into_iter().map(Cow::into_owned).collect(),
            });
        }
    }
    Err(LogError::file(
        lines.name(),
        "there are no rows of data behind the header",
        "the first cell of a row of data is a time",
    ))
}

struct Twincat<R> {
    lines: Lines<R>,
    splitter: Splitter,
    places: Vec<Place>,
    names: Vec<String>,
    wanted: Vec<bool>,
    decimal: Option<char>,
    /// The first row of data, read with the header.
    next: Option<(u64, String, bool)>,
    /// Cells of the current line.
    cells: Vec<String>,
    /// Line, column and group that come next in the current line.
    current: Option<(u64, usize, usize)>,
    /// The first time, where times are counts since 1601.
    origin: Option<u64>,
    after_blank: bool,
    remarks: Vec<String>,
}

impl<R: BufRead> Twincat<R> {
    /// Splits the next line into cells; false at the end.
    fn next_line(&mut self) -> Result<bool, LogError> {
        let (line, text, ended) = match self.next.take() {
            Some(first) => first,
            None => loop {
                if !self.lines.advance()? {
                    return Ok(false);
                }
                // A line of blanks is the end of all groups in some exports, not a row.
                if self.lines.text().is_empty() {
                    self.after_blank = true;
                    continue;
                }
                let text = self.lines.text().to_owned();
                break (self.lines.line(), text, self.lines.ended());
            },
        };
        if text.trim() == "EOF" {
            return Ok(false);
        }
        let mut cells = Vec::new();
        self.splitter.split(&text, &mut cells);
        let numeric = cells
            .iter()
            .any(|cell| number(cell, '.').is_some() || number(cell, ',').is_some());
        if self.after_blank && !numeric {
            self.remarks.push(format!(
                "line {line} and what follows are no data and were left out"
            ));
            return Ok(false);
        }
        // Groups that have ended leave nothing, blanks, or separators alone.
        while cells.last().is_some_and(|cell| cell.is_empty()) {
            cells.pop();
        }
        if cells.len() > self.places.len() {
            let what = format!(
                "{} cells where the header has {}",
                cells.len(),
                self.places.len()
            );
            return Err(LogError::line(self.lines.name(), line, what, ""));
        }
        // A row ends where a group ends, unless the export was cut.
        let whole = self
            .places
            .get(cells.len())
            .is_none_or(|place| *place == Place::Time);
        if !whole {
            if !ended {
                self.remarks
                    .push(format!("line {line} is cut and was left out"));
                return Ok(false);
            }
            let what = format!("{} cells end within a group of channels", cells.len());
            return Err(LogError::line(
                self.lines.name(),
                line,
                what,
                "the row is cut",
            ));
        }
        self.cells.clear();
        self.cells.extend(cells.into_iter().map(Cow::into_owned));
        self.current = Some((line, 0, 0));
        Ok(true)
    }

    fn value(&mut self, cell: &str) -> Option<f64> {
        let decimal = match self.decimal {
            Some(decimal) => decimal,
            None if cell.contains(',') => *self.decimal.insert(','),
            None if cell.contains('.') => *self.decimal.insert('.'),
            None => '.',
        };
        number(cell, decimal)
    }

    fn time(&mut self, line: u64, cell: &str) -> Result<f64, LogError> {
        let value = self.value(cell);
        match value {
            Some(count) if count >= LEAST_FILETIME => {
                // Whole counts: a f64 has no tenth of a microsecond left at this size.
                let count = cell.parse::<u64>().unwrap_or(count as u64);
                let origin = *self.origin.get_or_insert(count);
                let since = if count >= origin {
                    (count - origin) as f64
                } else {
                    -((origin - count) as f64)
                };
                Ok(since * 1e-7)
            }
            Some(milliseconds) => Ok(milliseconds * 1e-3),
            None => {
                let (what, hint) = no_number(cell, self.decimal.unwrap_or('.'));
                Err(LogError::cell(
                    self.lines.name(),
                    line,
                    "time",
                    cell,
                    what,
                    hint,
                ))
            }
        }
    }
}

impl<R: BufRead> Source for Twincat<R> {
    fn next_row(&mut self, row: &mut Row) -> Result<bool, LogError> {
        loop {
            let Some((line, column, group)) = self.current else {
                if !self.next_line()? {
                    return Ok(false);
                }
                continue;
            };
            if column >= self.cells.len() {
                self.current = None;
                continue;
            }
            let width = self
                .places
                .iter()
                .skip(column + 1)
                .take_while(|place| **place == Place::Value)
                .count();
            let cells: Vec<String> = self
                .cells
                .iter()
                .skip(column)
                .take(width + 1)
                .cloned()
                .collect();
            self.current = Some((line, column + width + 1, group + 1));
            // A group that has ended leaves its cells blank.
            if cells.iter().all(String::is_empty) {
                continue;
            }
            row.values.clear();
            row.time_s = self.time(line, cells.first().map_or("", String::as_str))?;
            // Channels are numbered without the columns of times, of which this is number `group`.
            let before = column - group;
            for (index, cell) in cells.iter().skip(1).enumerate() {
                let channel = before + index;
                match self.value(cell) {
                    Some(value) => row.values.push(value),
                    None if self.wanted.get(channel) == Some(&false) => row.values.push(f64::NAN),
                    None => {
                        let (what, hint) = no_number(cell, self.decimal.unwrap_or('.'));
                        let name = self.names.get(channel).map_or("", String::as_str);
                        return Err(LogError::cell(
                            self.lines.name(),
                            line,
                            name,
                            cell,
                            what,
                            hint,
                        ));
                    }
                }
            }
            row.line = line;
            row.group = group;
            row.part = 0;
            return Ok(true);
        }
    }

    fn select(&mut self, wanted: &[bool]) {
        self.wanted = wanted.to_vec();
    }

    fn remarks(&mut self) -> Vec<String> {
        std::mem::take(&mut self.remarks)
    }
}
