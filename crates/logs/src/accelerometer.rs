//! Accelerometers of printer firmware: Klipper's raw data and RepRapFirmware's M956.

use crate::error::LogError;
use crate::source::{Channel, FileColumns, Format, Header, Row, Source};
use crate::text::{Lines, no_number, number};
use crate::unit::Unit;
use std::io::BufRead;

/// Klipper: `#time,accel_x,accel_y,accel_z`, s of the print's clock and mm/s^2.
pub(crate) fn klipper<'a, R: BufRead + 'a>(
    lines: Lines<R>,
) -> Result<(Header, Box<dyn Source + 'a>), LogError> {
    open(lines, Format::KlipperAccelerometer, "mm/s^2")
}

/// RepRapFirmware: `Sample,X,Y,Z`, the number of the sample and g; the rate is in the last line.
pub(crate) fn duet<'a, R: BufRead + 'a>(
    lines: Lines<R>,
) -> Result<(Header, Box<dyn Source + 'a>), LogError> {
    open(lines, Format::DuetAccelerometer, "g")
}

fn open<'a, R: BufRead + 'a>(
    mut lines: Lines<R>,
    format: Format,
    unit: &str,
) -> Result<(Header, Box<dyn Source + 'a>), LogError> {
    lines.advance()?;
    if !lines.text().contains(',') {
        let what = format!("the firmware says: {}", lines.text().trim());
        return Err(LogError::line(lines.name(), 1, what, ""));
    }
    let unit: Option<Unit> = unit.parse().ok();
    let names: Vec<String> = lines
        .text()
        .split(',')
        .skip(1)
        .map(|name| name.trim().to_owned())
        .collect();
    let channels = names.iter().map(|name| Channel {
        name: name.clone(),
        unit,
        group: 0,
    });
    let header = Header {
        columns: Some(FileColumns::behind(1, names.len())),
        format,
        channels: channels.collect(),
        groups: 1,
        said: vec!["accelerations alone: no position of motor or load".to_owned()],
        guessed_time: None,
    };
    let source = Accelerometer {
        lines,
        names,
        counted: format == Format::DuetAccelerometer,
        next: 0,
        rate_hz: None,
        remarks: Vec::new(),
    };
    Ok((header, Box::new(source)))
}

struct Accelerometer<R> {
    lines: Lines<R>,
    names: Vec<String>,
    /// Whether rows have numbers instead of times.
    counted: bool,
    next: u64,
    rate_hz: Option<f64>,
    remarks: Vec<String>,
}

impl<R: BufRead> Accelerometer<R> {
    /// `Rate 1344, overflows 0`.
    fn last_line(&mut self) -> Result<(), LogError> {
        let text = self.lines.text().trim();
        let words: Vec<&str> = text
            .split([' ', ','])
            .filter(|word| !word.is_empty())
            .collect();
        let rate = words.get(1).and_then(|word| number(word, '.'));
        let Some(rate_hz) = rate.filter(|&rate| rate > 0.0) else {
            let what = format!("`{text}` tells no rate");
            return Err(LogError::line(
                self.lines.name(),
                self.lines.line(),
                what,
                "",
            ));
        };
        self.rate_hz = Some(rate_hz);
        match words.get(3) {
            Some(&"0") | None => {}
            Some(count) => self.remarks.push(format!(
                "the firmware tells of {count} overflows: samples were lost at unknown places"
            )),
        }
        Ok(())
    }
}

impl<R: BufRead> Source for Accelerometer<R> {
    fn next_row(&mut self, row: &mut Row) -> Result<bool, LogError> {
        loop {
            if !self.lines.advance()? {
                if self.counted && self.rate_hz.is_none() {
                    return Err(LogError::file(
                        self.lines.name(),
                        "the last line with the rate is missing",
                        "the file is cut: it ends with `Rate R, overflows N`",
                    ));
                }
                return Ok(false);
            }
            let text = self.lines.text().trim();
            if self.counted && text.starts_with("Rate ") {
                self.last_line()?;
            } else if !text.is_empty() {
                break;
            }
        }
        let (line, name) = (self.lines.line(), self.lines.name());
        let text = self.lines.text().trim();
        let found = text.split(',').count();
        if found != self.names.len() + 1 {
            if !self.lines.ended() && !self.counted {
                self.remarks
                    .push(format!("line {line} is cut and was left out"));
                return Ok(false);
            }
            let what = format!(
                "{found} values where the header has {}",
                self.names.len() + 1
            );
            return Err(LogError::line(name, line, what, ""));
        }
        row.values.clear();
        for (index, cell) in text.split(',').enumerate() {
            let Some(value) = number(cell, '.') else {
                let (what, hint) = no_number(cell, '.');
                let column = index.checked_sub(1).and_then(|index| self.names.get(index));
                let column = column.map_or("time", String::as_str);
                return Err(LogError::cell(name, line, column, cell, what, hint));
            };
            if index == 0 {
                row.time_s = value;
            } else {
                row.values.push(value);
            }
        }
        if self.counted {
            if row.time_s != self.next as f64 {
                let what = format!(
                    "sample {} stands where {} was expected",
                    row.time_s, self.next
                );
                return Err(LogError::line(name, line, what, "rows are missing"));
            }
            self.next += 1;
        }
        row.line = line;
        row.group = 0;
        row.part = 0;
        Ok(true)
    }

    fn remarks(&mut self) -> Vec<String> {
        std::mem::take(&mut self.remarks)
    }

    fn time_scale_s(&self) -> f64 {
        self.rate_hz.map_or(1.0, |rate| 1.0 / rate)
    }
}
