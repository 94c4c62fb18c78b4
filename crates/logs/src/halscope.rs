//! Logs that LinuxCNC's HALscope saves, of all three generations.

use crate::error::LogError;
use crate::source::{Channel, FileColumns, Format, Header, MAX_CHANNELS, Row, Source};
use crate::text::{Lines, no_number, number};
use std::io::BufRead;

/// Reads line 1 and the names.
pub(crate) fn open<'a, R: BufRead + 'a>(
    mut lines: Lines<R>,
) -> Result<(Header, Box<dyn Source + 'a>), LogError> {
    lines.advance()?;
    let named = !lines.text().starts_with('#');
    let period_s = period(&lines)?;
    let mut said = vec![format!("sampling period {} ms", 1e3 * period_s)];
    let told = if named {
        names_of_rows(&mut lines, &mut said)?
    } else {
        names_of_header(&mut lines)?
    };
    if told.names.is_empty() || told.names.len() > MAX_CHANNELS {
        return Err(LogError::line(
            lines.name(),
            lines.line(),
            "there are no channels",
            "",
        ));
    }
    let channels = channels(told.names, &mut said);
    let mut source = Halscope {
        names: channels
            .iter()
            .map(|channel| channel.name.clone())
            .collect(),
        wanted: vec![true; channels.len()],
        lines,
        named,
        decimal: told.decimal,
        period_s,
        row: 0,
        held: told.held,
        remarks: Vec::new(),
    };
    let format = if named {
        Format::HalscopeNamed
    } else if source.skip_display()? {
        Format::HalscopeDisplay
    } else {
        Format::Halscope
    };
    let header = Header {
        columns: Some(FileColumns::behind(0, channels.len())),
        format,
        channels,
        groups: 1,
        said,
        guessed_time: None,
    };
    Ok((header, Box::new(source)))
}

/// The channels' names, and how values are written.
struct ToldNames {
    names: Vec<String>,
    /// The decimal sign.
    decimal: char,
    /// The first row, where it was read for its names.
    held: Option<(u64, String)>,
}

/// Names of the oldest generation: they stand in every row; the first one tells them.
fn names_of_rows<R: BufRead>(
    lines: &mut Lines<R>,
    said: &mut Vec<String>,
) -> Result<ToldNames, LogError> {
    loop {
        if !lines.advance()? {
            return Err(no_rows(lines));
        }
        if !lines.text().trim().is_empty() {
            break;
        }
    }
    let words: Vec<&str> = lines.text().split_whitespace().collect();
    let names: Vec<String> = words
        .iter()
        .step_by(2)
        .map(|&word| word.to_owned())
        .collect();
    let comma = words
        .iter()
        .skip(1)
        .step_by(2)
        .any(|value| value.contains(','));
    said.push(format!(
        "decimal {}",
        if comma { "commas" } else { "points" }
    ));
    said.push(
        "labels of channels that were switched off may be shifted in this generation; its last \
         row is one too many and is left out"
            .to_owned(),
    );
    Ok(ToldNames {
        names,
        decimal: if comma { ',' } else { '.' },
        held: Some((lines.line(), lines.text().to_owned())),
    })
}

/// Names of the later generations: they stand in line 2.
fn names_of_header<R: BufRead>(lines: &mut Lines<R>) -> Result<ToldNames, LogError> {
    if !lines.advance()? {
        return Err(no_rows(lines));
    }
    let names = lines.text().split(';').map(|name| name.trim().to_owned());
    // A log that was opened and saved again marks names that no longer exist.
    let names = names
        .map(|name| {
            name.strip_prefix("[CSV] ")
                .map_or(name.clone(), str::to_owned)
        })
        .collect();
    Ok(ToldNames {
        names,
        decimal: '.',
        held: None,
    })
}

/// The channels, each with a name of its own.
fn channels(names: Vec<String>, said: &mut Vec<String>) -> Vec<Channel> {
    let mut channels = Vec::with_capacity(names.len());
    for name in names {
        let same = |other: &&Channel| other.name == name;
        let repeated = channels.iter().filter(same).count();
        channels.push(Channel {
            name: if repeated > 0 {
                said.push(format!(
                    "`{name}` is there more than once; the later one is called `{name}#{}`",
                    repeated + 1
                ));
                format!("{name}#{}", repeated + 1)
            } else {
                name
            },
            unit: None,
            group: 0,
        });
    }
    channels
}

fn no_rows<R: BufRead>(lines: &Lines<R>) -> LogError {
    LogError::file(lines.name(), "there are no rows behind the header", "")
}

/// The period of line 1, s.
fn period<R: BufRead>(lines: &Lines<R>) -> Result<f64, LogError> {
    let text = lines.text().trim_start_matches("# ");
    let mut words = text
        .trim_start_matches("Sampling period is ")
        .split_whitespace();
    let value = words.next().unwrap_or_default();
    let unit = words.next().unwrap_or_default();
    let nanoseconds = value.parse::<u64>().ok().filter(|&period| period > 0);
    match nanoseconds {
        Some(nanoseconds) if matches!(unit, "ns" | "nSec") => Ok(nanoseconds as f64 * 1e-9),
        _ => Err(LogError::line(
            lines.name(),
            1,
            format!("`{value} {unit}` is not a sampling period"),
            "HALscope writes whole nanoseconds, such as `1000000 ns`",
        )),
    }
}

struct Halscope<R> {
    lines: Lines<R>,
    names: Vec<String>,
    wanted: Vec<bool>,
    named: bool,
    decimal: char,
    period_s: f64,
    row: u64,
    /// A line that was read and not given: the last one of the oldest generation is never given.
    held: Option<(u64, String)>,
    remarks: Vec<String>,
}

impl<R: BufRead> Halscope<R> {
    /// Steps over the lines of display settings; holds the first row.
    fn skip_display(&mut self) -> Result<bool, LogError> {
        let mut display = false;
        while self.lines.advance()? {
            if self.lines.text().starts_with("# ") {
                display = true;
                continue;
            }
            self.held = Some((self.lines.line(), self.lines.text().to_owned()));
            break;
        }
        Ok(display)
    }

    /// The next line with something in it, and whether it had its end.
    fn next_line(&mut self) -> Result<Option<(u64, String, bool)>, LogError> {
        while self.lines.advance()? {
            if !self.lines.text().trim().is_empty() {
                let text = self.lines.text().to_owned();
                return Ok(Some((self.lines.line(), text, self.lines.ended())));
            }
        }
        Ok(None)
    }

    fn cell(&self, line: u64, index: usize, cell: &str) -> Result<f64, LogError> {
        number(cell, self.decimal).map_or_else(
            || {
                if self.wanted.get(index) == Some(&false) {
                    return Ok(f64::NAN);
                }
                let (what, hint) = no_number(cell, self.decimal);
                let column = self.names.get(index).map_or("", String::as_str);
                Err(LogError::cell(
                    self.lines.name(),
                    line,
                    column,
                    cell,
                    what,
                    hint,
                ))
            },
            Ok,
        )
    }

    fn parse(&self, line: u64, text: &str, row: &mut Row) -> Result<(), LogError> {
        row.values.clear();
        let wrong = |found: usize| {
            let what = format!(
                "{found} values where there are {} channels",
                self.names.len()
            );
            LogError::line(self.lines.name(), line, what, "")
        };
        if self.named {
            let mut words = text.split_whitespace();
            while let Some(name) = words.next() {
                let index = row.values.len();
                let Some(expected) = self.names.get(index) else {
                    return Err(wrong(index + 1));
                };
                if name != expected.split('#').next().unwrap_or_default() && name != expected {
                    let what = format!("channel `{name}` stands where `{expected}` was");
                    return Err(LogError::line(self.lines.name(), line, what, ""));
                }
                let value = self.cell(line, index, words.next().unwrap_or_default())?;
                row.values.push(value);
            }
        } else {
            for (index, cell) in text.split(';').enumerate() {
                if index >= self.names.len() {
                    return Err(wrong(text.split(';').count()));
                }
                let value = self.cell(line, index, cell.trim())?;
                row.values.push(value);
            }
        }
        if row.values.len() != self.names.len() {
            return Err(wrong(row.values.len()));
        }
        Ok(())
    }
}

impl<R: BufRead> Source for Halscope<R> {
    fn next_row(&mut self, row: &mut Row) -> Result<bool, LogError> {
        let Some((line, text)) = self.held.take() else {
            return Ok(false);
        };
        match self.next_line()? {
            Some((next, following, true)) => self.held = Some((next, following)),
            // HALscope ends every line: what has no end was cut, perhaps within a number.
            Some((next, _, false)) if !self.named => {
                self.remarks
                    .push(format!("line {next} is cut and was left out"));
            }
            Some(_) => {}
            // The oldest generation writes one row too many.
            None if self.named => return Ok(false),
            None => {}
        }
        self.parse(line, &text, row)?;
        row.line = line;
        row.group = 0;
        row.part = 0;
        row.time_s = self.row as f64 * self.period_s;
        self.row += 1;
        Ok(true)
    }

    fn select(&mut self, wanted: &[bool]) {
        self.wanted = wanted.to_vec();
    }

    fn remarks(&mut self) -> Vec<String> {
        std::mem::take(&mut self.remarks)
    }
}
