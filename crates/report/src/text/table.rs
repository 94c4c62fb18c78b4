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

/// A table with a header line, two blanks between columns and no rules.
#[derive(Clone, Debug, Default)]
pub struct Table {
    header: Vec<(String, Align)>,
    rows: Vec<Vec<Cell>>,
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
        }
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

    /// Every line ends in a newline and has no trailing blanks.
    pub fn render(&self) -> String {
        let decimals: Vec<usize> = (0..self.header.len())
            .map(|column| self.decimals(column))
            .collect();
        let mut lines = vec![
            self.header
                .iter()
                .map(|(name, _)| name.clone())
                .collect::<Vec<_>>(),
        ];
        lines.extend(self.rows.iter().map(|row| {
            row.iter()
                .zip(&decimals)
                .map(|(cell, d)| cell.render(*d))
                .collect()
        }));
        let widths: Vec<usize> = (0..self.header.len())
            .map(|column| {
                lines
                    .iter()
                    .map(|line| line[column].chars().count())
                    .max()
                    .unwrap_or(0)
            })
            .collect();
        let mut out = String::new();
        for line in lines {
            let mut text = String::new();
            for ((cell, width), (_, align)) in line.iter().zip(&widths).zip(&self.header) {
                let pad = width - cell.chars().count();
                let (before, after) = if *align == Align::Right {
                    (pad, 0)
                } else {
                    (0, pad)
                };
                // Writing to a String cannot fail.
                let _ = write!(text, "{:before$}{cell}{:after$}  ", "", "");
            }
            out.push_str(text.trim_end());
            out.push('\n');
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
