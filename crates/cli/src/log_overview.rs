//! `axis log`: what is in a log, its clocks and channels.

use crate::logs::{LogRows, open};
use crate::output::{self, DONE, Failure};
use clap::Args;
use lostmotion::logs::{Channel, Format, LogReader, Row};
use std::path::PathBuf;

/// From this multiple of the usual time between two rows on a row is missing between them.
const MISSING_FROM: f64 = 1.75;

/// `axis log`.
#[derive(Debug, Args)]
pub(crate) struct LogOverview {
    /// Log in any format that is known
    pub(crate) log: PathBuf,
    #[command(flatten)]
    pub(crate) rows: LogRows,
}

/// Says what is in a log, in constant memory.
pub(crate) fn overview(args: &LogOverview) -> Result<u8, Failure> {
    let name = args.log.display().to_string();
    let mut reader = LogReader::new(open(&args.log)?, &name, &args.rows.read_options())?;
    let clocks = add_up(&mut reader, &args.rows)?;
    let header = reader.header().clone();
    let mut text = format!("format: {}\n", header.format);
    for said in header.said.iter().chain(&reader.remarks()) {
        text += &format!("  {said}\n");
    }
    for (number, clock) in (1..).zip(&clocks) {
        text += &clock.told(number, reader.time_scale_s(), header.format);
        for (place, extent) in &clock.channels {
            if let Some(channel) = header.channels.get(*place) {
                text += &extent.told(place + 1, channel);
            }
        }
    }
    output::print(&text)?;
    Ok(DONE)
}

/// Goes through the rows that were asked for.
fn add_up(reader: &mut LogReader<'_>, rows: &LogRows) -> Result<Vec<Pace>, Failure> {
    let header = reader.header();
    let mut clocks: Vec<Pace> = (0..header.groups)
        .map(|group| Pace::of(header.group(group)))
        .collect();
    let (from, to) = (
        rows.from.unwrap_or(f64::NEG_INFINITY),
        rows.to.unwrap_or(f64::INFINITY),
    );
    let most = rows.rows.map_or(u64::MAX, |rows| rows as u64);
    // Texts in a table's columns are no reason to refuse the whole log here.
    reader.select(&[]);
    let mut row = Row::default();
    while reader.next_row(&mut row)? {
        let Some(clock) = clocks.get_mut(row.group) else {
            continue;
        };
        if row.time_s < from || row.time_s > to {
            continue;
        }
        if clock.rows == most {
            break;
        }
        clock.take(&row);
    }
    Ok(clocks)
}

/// What is added up of one clock.
struct Pace {
    rows: u64,
    first_s: f64,
    last_s: f64,
    shortest_s: f64,
    longest_s: f64,
    /// Its channels, each with its place in the log, in the order of a row's values.
    channels: Vec<(usize, Extent)>,
}

impl Pace {
    fn of(places: impl Iterator<Item = usize>) -> Pace {
        Pace {
            rows: 0,
            first_s: f64::NAN,
            last_s: f64::NAN,
            shortest_s: f64::INFINITY,
            longest_s: 0.0,
            channels: places.map(|place| (place, Extent::EMPTY)).collect(),
        }
    }

    fn take(&mut self, row: &Row) {
        if self.rows == 0 {
            self.first_s = row.time_s;
        } else {
            let step_s = row.time_s - self.last_s;
            self.shortest_s = self.shortest_s.min(step_s);
            self.longest_s = self.longest_s.max(step_s);
        }
        self.last_s = row.time_s;
        self.rows += 1;
        for ((_, extent), &value) in self.channels.iter_mut().zip(&row.values) {
            extent.take(value, row.line);
        }
    }

    /// Its lines, where a unit of its times is as many seconds as `scale`.
    fn told(&self, number: usize, scale: f64, format: Format) -> String {
        let mean_s = scale * (self.last_s - self.first_s) / self.rows.saturating_sub(1) as f64;
        let mut text = format!(
            "clock {number}: {} rows, {:.6} to {:.6} s, every {:.6} ms ({:.6} to {:.6})\n",
            self.rows,
            scale * self.first_s,
            scale * self.last_s,
            1e3 * mean_s,
            1e3 * scale * self.shortest_s,
            1e3 * scale * self.longest_s,
        );
        if scale * self.shortest_s <= 0.0 {
            text += "  rows are not in order of time, or stand twice\n";
        } else if scale * self.longest_s > MISSING_FROM * mean_s {
            // camonitor is silent while a value stays.
            text += if format == Format::Camonitor {
                "  nothing changed for a while\n"
            } else {
                "  rows are missing\n"
            };
        }
        text
    }
}

/// What is added up of one channel.
struct Extent {
    least: f64,
    most: f64,
    changes: u64,
    last: f64,
    /// Rows without a number, and the line of the first of them.
    missing: u64,
    missing_line: u64,
}

impl Extent {
    const EMPTY: Extent = Extent {
        least: f64::INFINITY,
        most: f64::NEG_INFINITY,
        changes: 0,
        last: f64::NAN,
        missing: 0,
        missing_line: 0,
    };

    fn take(&mut self, value: f64, line: u64) {
        if !value.is_finite() {
            if self.missing == 0 {
                self.missing_line = line;
            }
            self.missing += 1;
            return;
        }
        self.least = self.least.min(value);
        self.most = self.most.max(value);
        self.changes += u64::from(value != self.last);
        self.last = value;
    }

    /// Its lines.
    fn told(&self, number: usize, channel: &Channel) -> String {
        let name = &channel.name;
        // Of a column of texts, or a channel that was never written.
        if self.least > self.most {
            return format!("  {number:>3} {name} holds no numbers\n");
        }
        let unit = channel
            .unit
            .map_or("unit not told".to_owned(), |unit| unit.to_string());
        // The first value is no change.
        let changes = self.changes.saturating_sub(1);
        let mut text = format!(
            "  {number:>3} {name} ({unit}): {} to {}, {changes} changes\n",
            self.least, self.most
        );
        if self.missing > 0 {
            text += &format!(
                "      {} of its rows hold no finite number, the first in line {}\n",
                self.missing, self.missing_line
            );
        }
        text
    }
}
