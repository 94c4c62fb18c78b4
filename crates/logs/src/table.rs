//! Tables of any kind: separator, decimal mark, header and units are found from the first lines.

use crate::error::LogError;
use crate::roles::{period_s, time_among, time_unit};
use crate::source::{
    Channel, FileColumns, Format, Head, Header, MAX_CHANNELS, ReadOptions, Row, Source,
};
use crate::text::{Lines, Separator, Splitter, no_number, number};
use crate::time::{between_s, clock_s, stamp};
use crate::unit::Unit;
use std::borrow::Cow;
use std::io::BufRead;

/// Lines that the layout is found from. A choice.
const MAX_LAYOUT_LINES: usize = 200;
/// Seconds in half a day: a time of day that falls by more went past midnight.
const HALF_DAY_S: f64 = 43_200.0;

/// How a table is written.
struct Layout {
    separator: Separator,
    decimal: char,
    columns: usize,
    /// Line of the first row of data, from 0.
    first: usize,
    /// Share of cells that are numbers.
    quality: f64,
}

/// The separator and decimal mark under which most lines have the same number of cells, most of
/// them numbers.
fn layout(head: &Head) -> Option<Layout> {
    let separators = [
        Separator::Char('\t'),
        Separator::Char(';'),
        Separator::Char(','),
        Separator::Blanks,
    ];
    let mut best: Option<Layout> = None;
    for separator in separators {
        for decimal in ['.', ','] {
            if separator == Separator::Char(',') && decimal == ',' {
                continue;
            }
            if let Some(found) = layout_with(head, separator, decimal)
                && best
                    .as_ref()
                    .is_none_or(|best| found.quality > best.quality)
            {
                best = Some(found);
            }
        }
    }
    best
}

fn layout_with(head: &Head, separator: Separator, decimal: char) -> Option<Layout> {
    // Cells and numbers of each line that is no comment.
    let mut counts: Vec<(usize, usize, usize)> = Vec::new();
    let mut cells = Vec::new();
    let mut splitter = separator.splitter();
    for (index, line) in head.lines.iter().enumerate().take(MAX_LAYOUT_LINES) {
        if line.trim().is_empty() || line.starts_with('#') {
            continue;
        }
        splitter.split(line, &mut cells);
        let numbers = cells.iter().filter(|cell| is_value(cell, decimal)).count();
        counts.push((index, cells.len(), numbers));
    }
    let mut widths: Vec<usize> = counts.iter().map(|(_, cells, _)| *cells).collect();
    widths.sort_unstable();
    // The most frequent number of cells; the larger of two that are alike.
    let columns = widths
        .chunk_by(|a, b| a == b)
        .max_by_key(|chunk| chunk.len())
        .and_then(|chunk| chunk.first())
        .copied()?;
    if columns < 2 {
        return None;
    }
    let is_data = |cells: usize, numbers: usize| cells == columns && 2 * numbers >= columns;
    let first = counts
        .iter()
        .find(|(_, cells, numbers)| is_data(*cells, *numbers))?
        .0;
    let (mut alike, mut values) = (0, 0);
    for (_, cells, numbers) in counts.iter().filter(|(index, ..)| *index >= first) {
        if *cells == columns {
            alike += columns;
            values += numbers;
        }
    }
    let all: usize = counts.iter().map(|(_, cells, _)| *cells).sum();
    Some(Layout {
        separator,
        decimal,
        columns,
        first,
        quality: values as f64 / alike.max(1) as f64 + 0.5 * (alike as f64 / all.max(1) as f64),
    })
}

/// A number or a point in time.
fn is_value(cell: &str, decimal: char) -> bool {
    number(cell, decimal).is_some() || clock_s(cell).is_some() || stamp(cell).is_some()
}

/// How the times of rows are written.
#[derive(Clone, Copy)]
enum TimeKind {
    /// A number, with this worth in s.
    Number(f64),
    /// A time of day.
    Clock,
    /// A date and a time of day.
    Stamp,
    /// None: rows of this period, s.
    Rows(f64),
}

pub(crate) fn open<'a, R: BufRead + 'a>(
    lines: Lines<R>,
    head: &Head,
    options: &ReadOptions,
) -> Result<(Header, Box<dyn Source + 'a>), LogError> {
    let Some(layout) = layout(head) else {
        if head.lines.iter().any(|line| line.contains('\r')) {
            return Err(LogError::file(
                lines.name(),
                "its lines end with a carriage return (CR) alone",
                "write line feeds in their place: tr '\\r' '\\n' <OLD >NEW",
            ));
        }
        return Err(LogError::file(
            lines.name(),
            "this is no table of numbers and no log that is known",
            "a table has a header line and rows of numbers with tabs, semicolons, commas or blanks between",
        ));
    };
    let decimal = if layout.decimal == ',' {
        "commas"
    } else {
        "points"
    };
    let separator = match layout.separator.shown() {
        "blank" => "blanks".to_owned(),
        other => format!("{other}s"),
    };
    let mut said = vec![format!(
        "a table with {separator} between cells and decimal {decimal}"
    )];
    let mut splitter = layout.separator.splitter();
    let (names, units, header_line) = names(head, &layout, &mut splitter, &mut said);
    let mut cells = Vec::new();
    let first = head.lines.get(layout.first).map_or("", String::as_str);
    splitter.split(first, &mut cells);
    let (time, kind, guessed_time) = time_column(
        &lines,
        &names,
        &units,
        &cells,
        &layout,
        options,
        header_line,
        &mut said,
    )?;
    let mut channels = Vec::new();
    let mut places = Vec::new();
    for (column, name) in names.iter().enumerate() {
        // An empty last column is that of a separator at the end of each row.
        if Some(column) == time
            || (name.is_empty() && cells.get(column).is_none_or(|cell| cell.is_empty()))
        {
            continue;
        }
        channels.push(Channel {
            name: name.clone(),
            unit: units
                .get(column)
                .copied()
                .flatten()
                .or_else(|| Unit::in_name(name)),
            group: 0,
        });
        places.push(column);
    }
    if channels.is_empty() || channels.len() > MAX_CHANNELS {
        let what = format!("{} columns besides the time", channels.len());
        return Err(LogError::file(lines.name(), what, ""));
    }
    let header = Header {
        columns: Some(FileColumns {
            of_channels: places.iter().map(|column| column + 1).collect(),
            count: layout.columns,
        }),
        format: Format::Table,
        groups: 1,
        channels,
        said,
        guessed_time,
    };
    let source = Table {
        wanted: vec![true; header.channels.len()],
        skip: layout.first as u64,
        layout,
        splitter,
        names,
        places,
        time,
        kind,
        lines,
        rows: 0,
        origin: None,
        days_s: 0.0,
        last_s: f64::NEG_INFINITY,
    };
    Ok((header, Box::new(source)))
}

type Units = Vec<Option<Unit>>;

/// Names and units of the columns, and the line of the names.
fn names(
    head: &Head,
    layout: &Layout,
    splitter: &mut Splitter,
    said: &mut Vec<String>,
) -> (Vec<String>, Units, u64) {
    let mut above: Vec<(usize, Vec<String>)> = Vec::new();
    for (index, line) in head.lines.iter().enumerate().take(layout.first) {
        let mut cells = Vec::new();
        // Some writers mark the header as a comment.
        let text = line.strip_prefix('#').unwrap_or(line);
        splitter.split(text, &mut cells);
        if cells.len() == layout.columns {
            above.push((index, cells.into_iter().map(Cow::into_owned).collect()));
        }
    }
    let unit = |cell: &String| -> Option<Unit> {
        cell.trim_matches(['[', ']', '(', ')', ' ']).parse().ok()
    };
    let is_units = |cells: &[String]| {
        let blank = |cell: &String| cell.is_empty() || cell == "-";
        cells.iter().all(|cell| blank(cell) || unit(cell).is_some()) && !cells.iter().all(blank)
    };
    let last = above.pop();
    let no_units = vec![None; layout.columns];
    match (above.pop(), last) {
        (Some((line, names)), Some((_, units))) if is_units(&units) => {
            said.push(format!(
                "names in line {}, units in line {}",
                line + 1,
                line + 2
            ));
            (names, units.iter().map(unit).collect(), line as u64 + 1)
        }
        (_, Some((line, names))) => {
            if line > 0 {
                said.push(format!("names in line {}", line + 1));
            }
            (names, no_units, line as u64 + 1)
        }
        _ => {
            said.push(
                "there is no header: columns are called column1, column2 and so on".to_owned(),
            );
            let names = (1..=layout.columns).map(|column| format!("column{column}"));
            (names.collect(), no_units, 1)
        }
    }
}

/// The column of times and how they are written.
#[allow(
    clippy::too_many_arguments,
    reason = "the parts of one layout, used once"
)]
fn time_column<R: BufRead>(
    lines: &Lines<R>,
    names: &[String],
    units: &Units,
    first: &[Cow<'_, str>],
    layout: &Layout,
    options: &ReadOptions,
    header_line: u64,
    said: &mut Vec<String>,
) -> Result<(Option<usize>, TimeKind, Option<String>), LogError> {
    let refused =
        |(what, hint): (String, &str)| LogError::line(lines.name(), header_line, what, hint);
    let Some(column) = time_among(names, options).map_err(refused)? else {
        let period_s = period_s(names, options).map_err(refused)?;
        said.push(format!("rows are taken to be {} ms apart", 1e3 * period_s));
        return Ok((None, TimeKind::Rows(period_s), None));
    };
    let name = names.get(column).map_or("", String::as_str);
    let cell = first.get(column).map_or("", |cell| cell.as_ref());
    if stamp(cell).is_some() {
        return Ok((Some(column), TimeKind::Stamp, None));
    }
    if clock_s(cell).is_some() && number(cell, layout.decimal).is_none() {
        return Ok((Some(column), TimeKind::Clock, None));
    }
    let told = units.get(column).copied().flatten();
    let (unit, guess) = time_unit(name, told, options).map_err(refused)?;
    said.extend(guess.clone());
    Ok((Some(column), TimeKind::Number(unit.factor), guess))
}

struct Table<R> {
    lines: Lines<R>,
    layout: Layout,
    splitter: Splitter,
    names: Vec<String>,
    /// Column of each channel.
    places: Vec<usize>,
    wanted: Vec<bool>,
    time: Option<usize>,
    kind: TimeKind,
    /// Lines above the data.
    skip: u64,
    rows: u64,
    origin: Option<(i64, f64)>,
    days_s: f64,
    last_s: f64,
}

impl<R: BufRead> Table<R> {
    fn refused(&self, column: usize, cell: &str) -> LogError {
        let (what, hint) = no_number(cell, self.layout.decimal);
        let name = self.names.get(column).map_or("", String::as_str);
        LogError::cell(self.lines.name(), self.lines.line(), name, cell, what, hint)
    }
}

impl<R: BufRead> Source for Table<R> {
    fn next_row(&mut self, row: &mut Row) -> Result<bool, LogError> {
        loop {
            if !self.lines.advance()? {
                return Ok(false);
            }
            let text = self.lines.text();
            let above = self.lines.line() <= self.skip;
            if !above && !text.trim().is_empty() && !text.starts_with('#') {
                break;
            }
        }
        let mut cells = Vec::with_capacity(self.layout.columns);
        self.splitter.split(self.lines.text(), &mut cells);
        if cells.len() != self.layout.columns {
            let what = format!(
                "{} cells where the header has {}",
                cells.len(),
                self.layout.columns
            );
            let hint = if self.layout.separator == Separator::Char(',')
                && cells.len() == 2 * self.layout.columns
            {
                "decimal commas between commas: export with semicolons"
            } else if !self.lines.ended() {
                "the file ends within a line: take out this last line, and what is before it is read"
            } else {
                ""
            };
            return Err(LogError::line(
                self.lines.name(),
                self.lines.line(),
                what,
                hint,
            ));
        }
        let cell = |column: usize| cells.get(column).map_or("", |cell| cell.as_ref());
        row.values.clear();
        for (&column, &wanted) in self.places.iter().zip(&self.wanted) {
            match number(cell(column), self.layout.decimal) {
                Some(value) => row.values.push(value),
                None if !wanted => row.values.push(f64::NAN),
                None => return Err(self.refused(column, cell(column))),
            }
        }
        let time = self.time.unwrap_or_default();
        let text = cell(time);
        let refused = || self.refused(time, text);
        row.time_s = match self.kind {
            TimeKind::Number(factor) => {
                factor * number(text, self.layout.decimal).ok_or_else(refused)?
            }
            TimeKind::Rows(period_s) => self.rows as f64 * period_s,
            TimeKind::Stamp => {
                let stamp = stamp(text).ok_or_else(refused)?;
                between_s(*self.origin.get_or_insert(stamp), stamp)
            }
            TimeKind::Clock => {
                let clock_s = clock_s(text).ok_or_else(refused)?;
                if clock_s + self.days_s < self.last_s - HALF_DAY_S {
                    self.days_s += 2.0 * HALF_DAY_S;
                }
                clock_s + self.days_s
            }
        };
        self.last_s = row.time_s;
        self.rows += 1;
        row.line = self.lines.line();
        row.group = 0;
        row.part = 0;
        Ok(true)
    }

    fn select(&mut self, wanted: &[bool]) {
        self.wanted = wanted.to_vec();
    }
}
