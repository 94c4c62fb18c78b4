//! The text of EPICS' `camonitor`: one line a change of one process variable, with its own stamp.

use crate::error::LogError;
use crate::source::{Channel, Format, Head, Header, MAX_CHANNELS, Row, Source};
use crate::text::{Lines, no_number, number};
use crate::time::{between_s, stamp};
use std::collections::BTreeMap;
use std::io::BufRead;

/// Name, stamp and value of a line; no value where the variable was not connected.
struct Change<'a> {
    name: &'a str,
    stamp: Option<(i64, f64)>,
    value: &'a str,
}

fn change(line: &str) -> Option<Change<'_>> {
    let name = line.split_whitespace().next()?;
    let rest = line.trim_start().strip_prefix(name)?.trim_start();
    // `*** Not connected (PV not found)`, `*** disconnected`, with or without a stamp before.
    if rest.starts_with("***") {
        return Some(Change {
            name,
            stamp: None,
            value: "",
        });
    }
    let mut words = rest.split_whitespace();
    let (date, clock) = (words.next()?, words.next()?);
    let stamp = stamp(&format!("{date} {clock}"))?;
    let value = words.next()?;
    Some(Change {
        name,
        stamp: (!value.starts_with("***")).then_some(stamp),
        value,
    })
}

/// Whether the lines are name, date, time and value.
pub(crate) fn is_one(head: &Head) -> bool {
    let lines: Vec<&str> = head.rows().take(20).collect();
    let known = lines
        .iter()
        .take_while(|line| change(line).is_some())
        .count();
    // The last line of a recording that was killed may be cut.
    let all = known == lines.len() || (known + 1 == lines.len() && lines.len() < 20);
    let stamped = |line: &str| change(line).is_some_and(|change| change.stamp.is_some());
    known > 0 && all && head.rows().any(stamped)
}

pub(crate) fn open<'a, R: BufRead + 'a>(
    lines: Lines<R>,
    head: &Head,
) -> Result<(Header, Box<dyn Source + 'a>), LogError> {
    let mut names: BTreeMap<String, usize> = BTreeMap::new();
    let mut channels = Vec::new();
    for found in head
        .rows()
        .filter_map(change)
        .filter(|change| change.stamp.is_some())
    {
        let group = channels.len();
        if group < MAX_CHANNELS && !names.contains_key(found.name) {
            names.insert(found.name.to_owned(), group);
            channels.push(Channel {
                name: found.name.to_owned(),
                unit: None,
                group,
            });
        }
    }
    let header = Header {
        columns: None,
        format: Format::Camonitor,
        groups: channels.len(),
        channels,
        said: vec![
            "every variable has its own times; a value is written where it changed".to_owned(),
        ],
        guessed_time: None,
    };
    let source = Camonitor {
        wanted: vec![true; header.channels.len()],
        lines,
        names,
        first: None,
        late: 0,
        apart: 0,
        remarks: Vec::new(),
    };
    Ok((header, Box::new(source)))
}

struct Camonitor<R> {
    lines: Lines<R>,
    names: BTreeMap<String, usize>,
    wanted: Vec<bool>,
    first: Option<(i64, f64)>,
    /// Changes of variables that began after the first lines.
    late: u64,
    /// Lines that tell of a lost connection.
    apart: u64,
    remarks: Vec<String>,
}

impl<R> Camonitor<R> {
    /// Says what was left out.
    fn end(&mut self) {
        let (late, apart) = (self.late, self.apart);
        if late > 0 {
            self.remarks.push(format!(
                "{late} changes of variables that begin late in the log were left out"
            ));
        }
        if apart > 0 {
            self.remarks
                .push(format!("{apart} lines tell of a lost connection"));
        }
        (self.late, self.apart) = (0, 0);
    }
}

impl<R: BufRead> Source for Camonitor<R> {
    fn next_row(&mut self, row: &mut Row) -> Result<bool, LogError> {
        loop {
            if !self.lines.advance()? {
                self.end();
                return Ok(false);
            }
            if !self.lines.ended() {
                // camonitor ends every line: what has no end was cut, perhaps within a number.
                let line = self.lines.line();
                self.remarks
                    .push(format!("line {line} is cut and was left out"));
                self.end();
                return Ok(false);
            }
            if self.lines.text().trim().is_empty() {
                continue;
            }
            let line = self.lines.line();
            let Some(found) = change(self.lines.text()) else {
                let what = "the line is not name, date, time and value";
                return Err(LogError::line(
                    self.lines.name(),
                    line,
                    what,
                    "as camonitor writes it",
                ));
            };
            let Some(stamp) = found.stamp else {
                self.apart += 1;
                continue;
            };
            let Some(&group) = self.names.get(found.name) else {
                self.late += 1;
                continue;
            };
            let value = match number(found.value, '.') {
                Some(value) => value,
                None if self.wanted.get(group) == Some(&false) => f64::NAN,
                None => {
                    let (what, hint) = no_number(found.value, '.');
                    let (file, name) = (self.lines.name(), found.name);
                    return Err(LogError::cell(file, line, name, found.value, what, hint));
                }
            };
            row.values.clear();
            row.values.push(value);
            row.time_s = between_s(*self.first.get_or_insert(stamp), stamp);
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
