//! Heidenhain's TNCscope data files, text of version 2.0.

use crate::error::LogError;
use crate::source::{Channel, FileColumns, Format, Header, MAX_CHANNELS, Row, Source};
use crate::text::{Lines, no_number, number};
use crate::unit::Unit;
use std::io::BufRead;

/// One `%[CURVEn]` of the header.
#[derive(Default)]
struct Curve {
    name: String,
    unit: Option<Unit>,
    unknown_unit: Option<String>,
    count: Option<u64>,
    column: Option<usize>,
}

pub(crate) fn open<'a, R: BufRead + 'a>(
    mut lines: Lines<R>,
) -> Result<(Header, Box<dyn Source + 'a>), LogError> {
    let mut curves: Vec<Curve> = Vec::new();
    let mut said = Vec::new();
    loop {
        if !lines.advance()? {
            let (what, hint) = (
                "there is no `%[DATA]`",
                "the file is cut, or of another version",
            );
            return Err(LogError::file(lines.name(), what, hint));
        }
        let text = lines.text().trim();
        let Some(text) = text.strip_prefix('%') else {
            let what = "a row stands before `%[DATA]`";
            return Err(LogError::line(lines.name(), lines.line(), what, ""));
        };
        if text == "[DATA]" {
            break;
        }
        if text.starts_with("[CURVE") {
            curves.push(Curve::default());
            if curves.len() > MAX_CHANNELS {
                return Err(LogError::line(
                    lines.name(),
                    lines.line(),
                    "too many curves",
                    "",
                ));
            }
        }
        let Some((key, value)) = text.split_once('=') else {
            continue;
        };
        let value = value.trim();
        match (key, curves.last_mut()) {
            ("VERSION", None) if value != "2.0" => {
                said.push(format!("version {value} is read as 2.0"));
            }
            ("CONTROL", None) => said.push(format!("control {value}")),
            ("NAME", Some(curve)) => value.clone_into(&mut curve.name),
            ("DIMENSION", Some(curve)) => match value.parse() {
                Ok(unit) => curve.unit = Some(unit),
                Err(_) => curve.unknown_unit = Some(value.to_owned()),
            },
            ("COUNT", Some(curve)) => curve.count = value.parse().ok(),
            ("COLUMN", Some(curve)) => curve.column = value.parse().ok(),
            _ => {}
        }
    }
    if curves.is_empty() {
        return Err(LogError::file(lines.name(), "there is no `%[CURVE1]`", ""));
    }
    // Curves in the order of their columns; the first column is the time.
    for (index, curve) in curves.iter_mut().enumerate() {
        curve.column.get_or_insert(index + 1);
        if let Some(unknown) = &curve.unknown_unit {
            let name = &curve.name;
            said.push(format!(
                "the unit of `{name}` is a code, `{unknown}`: give it with the column"
            ));
        }
    }
    curves.sort_by_key(|curve| curve.column);
    for (index, curve) in curves.iter().enumerate() {
        if curve.column != Some(index + 1) {
            let what = format!("the columns of the curves are not 1 to {}", curves.len());
            return Err(LogError::file(lines.name(), what, ""));
        }
    }
    let count = curves.iter().filter_map(|curve| curve.count).max();
    let header = Header {
        columns: Some(FileColumns::behind(1, curves.len())),
        format: Format::Tncscope,
        channels: curves
            .iter()
            .map(|curve| Channel {
                name: curve.name.clone(),
                unit: curve.unit,
                group: 0,
            })
            .collect(),
        groups: 1,
        said,
        guessed_time: None,
    };
    let source = Tncscope {
        names: curves.into_iter().map(|curve| curve.name).collect(),
        wanted: vec![true; header.channels.len()],
        lines,
        count,
        rows: 0,
        remarks: Vec::new(),
    };
    Ok((header, Box::new(source)))
}

struct Tncscope<R> {
    lines: Lines<R>,
    names: Vec<String>,
    wanted: Vec<bool>,
    count: Option<u64>,
    rows: u64,
    remarks: Vec<String>,
}

impl<R: BufRead> Source for Tncscope<R> {
    fn next_row(&mut self, row: &mut Row) -> Result<bool, LogError> {
        loop {
            if !self.lines.advance()? {
                if let Some(count) = self.count.take()
                    && count != self.rows
                {
                    let rows = self.rows;
                    self.remarks.push(format!(
                        "the header promises {count} rows; there are {rows}"
                    ));
                }
                return Ok(false);
            }
            if !self.lines.text().trim().is_empty() {
                break;
            }
        }
        let (line, name) = (self.lines.line(), self.lines.name());
        let text = self.lines.text().trim();
        // Every value has a semicolon behind it, the last one, too.
        let text = text.strip_suffix(';').unwrap_or(text);
        let found = text.split(';').count();
        if found != self.names.len() + 1 {
            if !self.lines.ended() {
                self.remarks
                    .push(format!("line {line} is cut and was left out"));
                return Ok(false);
            }
            let what = format!(
                "{found} values where there are {} curves and the time",
                self.names.len()
            );
            return Err(LogError::line(name, line, what, ""));
        }
        row.values.clear();
        for (index, cell) in text.split(';').map(str::trim).enumerate() {
            let value = number(cell, '.');
            let column = index.checked_sub(1);
            let wanted = column.is_none_or(|column| self.wanted.get(column) == Some(&true));
            let value = match value {
                Some(value) => value,
                None if !wanted => f64::NAN,
                None => {
                    let (what, hint) = no_number(cell, '.');
                    let curve = column.and_then(|column| self.names.get(column));
                    let curve = curve.map_or("time", String::as_str);
                    return Err(LogError::cell(name, line, curve, cell, what, hint));
                }
            };
            match column {
                None => row.time_s = value * 1e-6,
                Some(_) => row.values.push(value),
            }
        }
        self.rows += 1;
        row.line = line;
        row.group = 0;
        row.part = 0;
        Ok(true)
    }

    fn select(&mut self, wanted: &[bool]) {
        self.wanted = wanted.to_vec();
    }

    fn remarks(&mut self) -> Vec<String> {
        std::mem::take(&mut self.remarks)
    }
}
