//! Column-aligned text.

use crate::number::{compact, error_decimals};
use std::fmt::Write;

/// Side on which a column's cells line up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// Text.
    Left,
    /// Numbers.
    Right,
}

/// A cell of a [`Table`].
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Text as it is.
    Text(String),
    /// A magnitude in um or mdeg; the column's smallest decides the decimals of all of them.
    Error(f64),
    /// The same with its sign always shown.
    Signed(f64),
}

impl From<&str> for Cell {
    fn from(text: &str) -> Cell {
        Cell::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Cell {
        Cell::Text(text)
    }
}

impl Cell {
    fn render(&self, decimals: usize) -> String {
        match self {
            Cell::Text(text) => text.clone(),
            Cell::Error(value) => compact(*value, decimals),
            Cell::Signed(value) => {
                let text = compact(*value, decimals);
                // A sign on what rounds to zero would claim a side.
                let is_zero = !text.bytes().any(|b| (b'1'..=b'9').contains(&b));
                if *value > 0.0 && !is_zero {
                    format!("+{text}")
                } else {
                    text
                }
            }
        }
    }

    fn magnitude(&self) -> Option<f64> {
        match self {
            Cell::Error(value) | Cell::Signed(value) if value.is_finite() => Some(value.abs()),
            _ => None,
        }
    }
}

/// Blanks between two columns.
const BETWEEN_COLUMNS: usize = 2;
/// A text column is not shortened below this many characters. A choice: a word or two stay legible.
const SHORTEST_TEXT: usize = 12;

/// A text that is folded is not put beside the others in fewer characters than these, but below them.
/// A choice: some words a line.
const SHORTEST_FOLDED: usize = 28;
/// Blanks before a text below its row.
const INDENT: usize = 4;

/// A table with a header line, two blanks between columns and no rules.
#[derive(Clone, Debug, Default)]
pub struct Table {
    header: Vec<(String, Align)>,
    rows: Vec<Vec<Cell>>,
    /// Columns that a narrow terminal does without, the first to go first.
    optional: Vec<usize>,
    /// Whether texts of the last column go on in further lines instead of being shortened.
    is_folded: bool,
}

impl Table {
    /// A table with these columns.
    pub fn new(columns: &[(&str, Align)]) -> Table {
        Table {
            header: columns
                .iter()
                .map(|(name, align)| ((*name).to_owned(), *align))
                .collect(),
            rows: Vec::new(),
            optional: Vec::new(),
            is_folded: false,
        }
    }

    /// Texts of the last column are broken at blanks where [`Table::render_within`] would shorten
    /// them: for lists whose sentences matter more than their height.
    #[must_use]
    pub fn folded(mut self) -> Table {
        self.is_folded = true;
        self
    }

    /// Columns, counted from 0, that [`Table::render_within`] leaves out where a line would be too
    /// long, the first to go first.
    #[must_use]
    pub fn optional(mut self, columns: &[usize]) -> Table {
        self.optional = columns.to_vec();
        self
    }

    /// Appends a row; cells beyond the columns are dropped, missing ones are empty.
    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        let mut row: Vec<Cell> = cells.into_iter().take(self.header.len()).collect();
        row.resize(self.header.len(), Cell::Text(String::new()));
        self.rows.push(row);
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Decimals that the smallest number of a column calls for, so that one method gone wild does
    /// not hide the others' figures.
    fn decimals(&self, column: usize) -> usize {
        error_decimals(
            self.rows
                .iter()
                .filter_map(|row| row[column].magnitude())
                .fold(f64::INFINITY, f64::min),
        )
    }

    /// The whole table. Every line ends in a newline and has no trailing blanks.
    pub fn render(&self) -> String {
        self.render_within(usize::MAX)
    }

    /// The table in lines of at most `width` characters: optional columns are left out until it
    /// fits, then the widest text column is shortened, or the last one folded; where it would become
    /// narrow, its texts go below their rows. Numbers are never cut.
    ///
    /// # Examples
    /// ```
    /// use lostmotion_report::text::{Align, Table};
    ///
    /// let columns = [("line", Align::Right), ("time s", Align::Right), ("block", Align::Left)];
    /// let mut table = Table::new(&columns).optional(&[1]);
    /// table.row(["12".into(), "0.250".into(), "G1 X10".into()]);
    /// assert_eq!(table.render_within(80), "line  time s  block\n  12   0.250  G1 X10\n");
    /// assert_eq!(table.render_within(12), "line  block\n  12  G1 X10\n");
    /// ```
    pub fn render_within(&self, width: usize) -> String {
        let mut lines = self.lines();
        let mut widths: Vec<usize> = (0..self.header.len())
            .map(|column| widest(&lines, column))
            .collect();
        let mut shown: Vec<usize> = (0..self.header.len()).collect();
        let taken = |shown: &[usize], widths: &[usize]| {
            let columns: usize = shown.iter().map(|column| widths[*column]).sum();
            columns + BETWEEN_COLUMNS * shown.len().saturating_sub(1)
        };
        // Whole columns go first: a number that is cut short would be a wrong number.
        for column in &self.optional {
            if taken(&shown, &widths) > width {
                shown.retain(|kept| kept != column);
            }
        }
        // Still too long: a list breaks its last column into further lines, where no word is lost.
        let excess = taken(&shown, &widths).saturating_sub(width);
        if let Some(&last) = shown.last().filter(|_| self.is_folded && excess > 0) {
            let left = widths[last].saturating_sub(excess);
            if left < SHORTEST_FOLDED && width > SHORTEST_FOLDED && shown.len() > 1 {
                shown.pop();
                let beside = aligned(&lines, &shown, &widths, &self.header);
                return below(&beside, &lines, last, width);
            }
            let room = left.max(SHORTEST_TEXT);
            lines = lines
                .iter()
                .flat_map(|line| folded(line, last, room))
                .collect();
            widths[last] = widest(&lines, last);
            return aligned(&lines, &shown, &widths, &self.header);
        }
        let text = |column: &&usize| self.header[**column].1 == Align::Left;
        // Then the widest text gives what is still missing.
        let longest = shown.iter().filter(text).max_by_key(|c| widths[**c]);
        if let Some(&column) = longest.filter(|_| excess > 0) {
            let room = widths[column].saturating_sub(excess).max(SHORTEST_TEXT);
            for line in &mut lines {
                line[column] = short(&line[column], room);
            }
            widths[column] = widest(&lines, column);
        }
        aligned(&lines, &shown, &widths, &self.header)
    }

    /// Header and rows as text.
    fn lines(&self) -> Vec<Vec<String>> {
        // One number of decimals for a column, so that points stand below each other.
        let decimals: Vec<usize> = (0..self.header.len())
            .map(|column| self.decimals(column))
            .collect();
        let header = self.header.iter().map(|(name, _)| name.clone()).collect();
        let row = |row: &Vec<Cell>| {
            row.iter()
                .zip(&decimals)
                .map(|(cell, decimals)| cell.render(*decimals))
                .collect()
        };
        std::iter::once(header)
            .chain(self.rows.iter().map(row))
            .collect()
    }
}

/// The cells of lines, padded to the widths of the columns shown.
fn aligned(
    lines: &[Vec<String>],
    shown: &[usize],
    widths: &[usize],
    header: &[(String, Align)],
) -> String {
    let mut out = String::new();
    for line in lines {
        let mut text = String::new();
        for &column in shown {
            let cell = &line[column];
            // Characters, not bytes: a degree sign takes one column.
            let pad = widths[column].saturating_sub(cell.chars().count());
            let (before, after) = match header[column].1 {
                Align::Right => (pad, 0),
                Align::Left => (0, pad),
            };
            // Writing to a String cannot fail.
            let _ = write!(
                text,
                "{:before$}{cell}{:after$}{:BETWEEN_COLUMNS$}",
                "", "", ""
            );
        }
        out.push_str(text.trim_end());
        out.push('\n');
    }
    out
}

/// Lines, with a further column's texts in lines of their own below them.
fn below(beside: &str, lines: &[Vec<String>], column: usize, width: usize) -> String {
    let mut out = String::new();
    for (text, line) in beside.lines().zip(lines) {
        out.push_str(text);
        out.push('\n');
        let room = width.saturating_sub(INDENT);
        for part in folded(line, column, room) {
            if !part[column].is_empty() {
                let _ = writeln!(out, "{:INDENT$}{}", "", part[column]);
            }
        }
    }
    out
}

/// A line whose cell in a column is broken at blanks into lines of at most `room` characters; a
/// longer word stands alone.
fn folded(line: &[String], column: usize, room: usize) -> Vec<Vec<String>> {
    let mut parts = vec![String::new()];
    for word in line[column].split_whitespace() {
        let used = parts.last().map_or(0, |part| part.chars().count());
        if used > 0 && used + 1 + word.chars().count() > room {
            parts.push(String::new());
        }
        if let Some(part) = parts.last_mut() {
            part.push_str(if part.is_empty() { "" } else { " " });
            part.push_str(word);
        }
    }
    let mut lines = Vec::with_capacity(parts.len());
    for part in parts {
        // The other columns are written once.
        let mut cells = match lines.first() {
            None => line.to_vec(),
            Some(_) => vec![String::new(); line.len()],
        };
        cells[column] = part;
        lines.push(cells);
    }
    lines
}

/// Characters of the longest cell of a column.
fn widest(lines: &[Vec<String>], column: usize) -> usize {
    let lengths = lines.iter().map(|line| line[column].chars().count());
    lengths.max().unwrap_or(0)
}

/// `text` shortened to `limit` characters, without control characters.
pub(super) fn short(text: &str, limit: usize) -> String {
    let clean = |c: char| if c.is_control() { ' ' } else { c };
    if text.chars().count() <= limit {
        return text.chars().map(clean).collect();
    }
    text.chars()
        .map(clean)
        .take(limit.saturating_sub(3))
        .chain("...".chars())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_column_of_a_list_is_folded() {
        let mut table = Table::new(&[("name", Align::Left), ("", Align::Left)]).folded();
        table.row(["one".into(), "a few plain words".into()]);
        table.row(["two".into(), "more".into()]);
        assert_eq!(
            table.render(),
            "name\none   a few plain words\ntwo   more\n"
        );
        assert_eq!(
            table.render_within(18),
            "name\none   a few plain\n      words\ntwo   more\n"
        );
        // Where it would become narrow it goes below.
        let long = "[JOINT_0] STEPGEN_MAXACCEL";
        table.row([
            long.into(),
            "too little room for what the control adds".into(),
        ]);
        assert_eq!(
            table.render_within(40),
            format!(
                "name\none\n    a few plain words\ntwo\n    more\n{long}\n    too little room for what the control\n    adds\n"
            )
        );
    }

    #[test]
    fn numbers_of_a_column_share_their_decimals() {
        let mut table = Table::new(&[
            ("name", Align::Left),
            ("um", Align::Right),
            ("signed", Align::Right),
        ]);
        table.row(["a".into(), Cell::Error(123.456), Cell::Signed(0.001)]);
        table.row(["longer".into(), Cell::Error(0.04), Cell::Signed(-1.5)]);
        table.row(["b".into(), Cell::Error(f64::NAN), Cell::Signed(1.5)]);
        table.row(["wild".into(), Cell::Error(4.5e7), Cell::Signed(-4.5e7)]);
        assert_eq!(
            table.render(),
            "name        um   signed\na       123.46     0.00\nlonger    0.04    -1.50\nb            -    +1.50\nwild    4.50e7  -4.50e7\n"
        );
    }

    #[test]
    fn narrow_tables_have_fewer_columns_and_whole_numbers() {
        let mut table = Table::new(&[
            ("line", Align::Right),
            ("RMS", Align::Right),
            ("at", Align::Left),
            ("block", Align::Left),
        ])
        .optional(&[2, 1]);
        let block = "G1 X100.000 Y200.000 Z300.000 F2000";
        table.row(["7".into(), Cell::Error(1.25), "1 2 3".into(), block.into()]);
        for (width, header) in [
            (80, "line   RMS  at     block"),
            (50, "line   RMS  block"),
            (41, "line  block"),
            (20, "line  block"),
        ] {
            let text = table.render_within(width);
            assert!(
                text.lines().all(|line| line.chars().count() <= width),
                "{text}"
            );
            assert_eq!(text.lines().next(), Some(header));
            assert!(text.contains("   7") && text.contains("G1 X10"), "{text}");
        }
        assert_eq!(
            table.render_within(20),
            "line  block\n   7  G1 X100.000...\n"
        );
    }
}
