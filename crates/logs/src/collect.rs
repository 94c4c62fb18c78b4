//! The rows of the channels that are asked for, on one clock.

use crate::clocks::{Track, on_one_clock};
use crate::error::LogError;
use crate::reader::LogReader;
use crate::roles::Assigned;
use crate::source::{Format, Row};

/// Which rows of a log are taken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    /// First and last time, s of the log.
    pub(crate) from_s: f64,
    pub(crate) to_s: f64,
    /// Most rows, from the first time on.
    pub(crate) max_rows: usize,
}

/// All rows of the channels, on one clock.
pub(crate) fn collect(
    reader: &mut LogReader<'_>,
    assigned: &[Assigned],
    factors: &[f64],
    part: &Part,
    said: &mut Vec<String>,
) -> Result<Track, LogError> {
    let mut collector = Collector::new(reader, assigned);
    let track = collector.part(reader, factors, part, said)?;
    if collector.has_more {
        said.push(format!(
            "the first {} rows are taken; more with --rows, others with --from and --to",
            part.max_rows
        ));
    }
    Ok(track)
}

/// Collects rows part by part.
pub(crate) struct Collector {
    /// Groups that are asked for, each with the places of its channels among the roles.
    groups: Vec<(usize, Vec<(usize, usize)>)>,
    /// A row that was read and not taken yet.
    waiting: Option<Row>,
    recording: u32,
    /// Time of the last row that was taken of the only clock, s of the log.
    last_s: f64,
    /// Whether there are rows behind the last part.
    pub(crate) has_more: bool,
}

impl Collector {
    pub(crate) fn new(reader: &LogReader<'_>, assigned: &[Assigned]) -> Collector {
        let header = reader.header();
        let mut groups: Vec<(usize, Vec<(usize, usize)>)> = Vec::new();
        for (role, other) in assigned.iter().enumerate() {
            let Some(channel) = header.channels.get(other.channel) else {
                continue;
            };
            let within = header
                .group(channel.group)
                .position(|place| place == other.channel);
            let entry = (role, within.unwrap_or_default());
            match groups.iter_mut().find(|(group, _)| *group == channel.group) {
                Some((_, members)) => members.push(entry),
                None => groups.push((channel.group, vec![entry])),
            }
        }
        Collector {
            groups,
            waiting: None,
            recording: 0,
            last_s: f64::NEG_INFINITY,
            has_more: false,
        }
    }

    /// Whether parts can follow the first one: channels of several clocks are not cut at one place.
    pub(crate) fn has_one_clock(&self) -> bool {
        self.groups.len() == 1
    }

    /// The next rows, at most as many as the part says.
    pub(crate) fn part(
        &mut self,
        reader: &mut LogReader<'_>,
        factors: &[f64],
        part: &Part,
        said: &mut Vec<String>,
    ) -> Result<Track, LogError> {
        let format = reader.header().format;
        let mut tracks = self.rows(reader, factors, part, said)?;
        if format == Format::Camonitor {
            hold(&mut tracks, part.max_rows, said);
        }
        let mut merged = self.merged(tracks, reader.name(), said)?;
        merged.counted = format.counted();
        let scale = reader.time_scale_s();
        if scale != 1.0 {
            merged.time_s.iter_mut().for_each(|time| *time *= scale);
        }
        // Columns in the order of the roles.
        let members = self.groups.iter().flat_map(|(_, members)| members);
        let order = members.map(|(role, _)| *role);
        let mut columns: Vec<(usize, Vec<f64>)> = order.zip(merged.columns).collect();
        columns.sort_by_key(|(role, _)| *role);
        merged.columns = columns.into_iter().map(|(_, column)| column).collect();
        Ok(merged)
    }

    /// The next rows of each group, in whatever time the log counts. Where time was lost, of the longest
    /// recording.
    fn rows(
        &mut self,
        reader: &mut LogReader<'_>,
        factors: &[f64],
        part: &Part,
        said: &mut Vec<String>,
    ) -> Result<Vec<Track>, LogError> {
        let rows_of = |tracks: &[Track]| tracks.iter().map(Track::len).max().unwrap_or_default();
        let (mut tracks, mut best) = (self.no_rows(), self.no_rows());
        let mut recordings = 1u32;
        let is_first = !self.has_more;
        self.has_more = false;
        let mut row = Row::default();
        loop {
            match self.waiting.take() {
                Some(waiting) => row = waiting,
                None if reader.next_row(&mut row)? => {}
                None => break,
            }
            let Some(place) = self
                .groups
                .iter()
                .position(|(group, _)| *group == row.group)
            else {
                continue;
            };
            if row.part != self.recording {
                if !is_first {
                    said.push(format!(
                        "time was lost at {:.6} s: what is behind is not taken; give it with --from",
                        row.time_s * reader.time_scale_s()
                    ));
                    break;
                }
                (self.recording, recordings) = (row.part, recordings + 1);
                // Time was lost: the longest part is kept.
                if rows_of(&tracks) > rows_of(&best) {
                    std::mem::swap(&mut tracks, &mut best);
                }
                tracks.iter_mut().for_each(Track::clear);
                self.last_s = f64::NEG_INFINITY;
            }
            let track = &mut tracks[place];
            let before_s = track.time_s.last().copied().unwrap_or(self.last_s);
            if row.time_s <= before_s {
                return Err(not_after(reader, &row, before_s));
            }
            if row.time_s < part.from_s {
                continue;
            }
            if row.time_s > part.to_s {
                break;
            }
            if track.len() == part.max_rows {
                self.has_more = true;
                self.waiting = Some(row);
                break;
            }
            add(track, &row, &self.groups[place].1, factors);
        }
        if rows_of(&best) > rows_of(&tracks) {
            tracks = best;
            // What follows is of another recording.
            (self.has_more, self.waiting) = (false, None);
        }
        if recordings > 1 {
            said.push(format!(
                "time was lost between {recordings} parts of the log: the longest one is taken, {} rows",
                rows_of(&tracks)
            ));
        }
        Ok(tracks)
    }

    /// A track without rows for each group.
    fn no_rows(&self) -> Vec<Track> {
        let groups = self.groups.iter();
        groups
            .map(|(_, members)| Track::new(members.len()))
            .collect()
    }

    /// The columns of all groups at the times of one.
    fn merged(
        &mut self,
        mut tracks: Vec<Track>,
        name: &str,
        said: &mut Vec<String>,
    ) -> Result<Track, LogError> {
        if tracks.len() == 1 {
            let track = tracks.pop().unwrap_or_default();
            self.last_s = track.time_s.last().copied().unwrap_or(self.last_s);
            return Ok(track);
        }
        if tracks.iter().any(|track| track.len() < 2) {
            return Err(LogError::file(
                name,
                "a column has fewer than two values",
                "",
            ));
        }
        let merged = on_one_clock(&tracks);
        said.push(format!(
            "columns have {} clocks: all are read at the slowest one's, {:.4} ms",
            self.groups.len(),
            1e3 * merged.period_s()
        ));
        Ok(merged)
    }
}

/// A row that is no later than the one before.
fn not_after(reader: &LogReader<'_>, row: &Row, before_s: f64) -> LogError {
    LogError::line(
        reader.name(),
        row.line,
        format!(
            "the time {} s is not after {before_s} s, the time of the row before",
            row.time_s
        ),
        "rows have to be in order of time, none twice",
    )
    .counting(reader.header().format.counted())
}

/// Adds the values of a row to the track of its group, in the units of their roles.
fn add(track: &mut Track, row: &Row, members: &[(usize, usize)], factors: &[f64]) {
    track.time_s.push(row.time_s);
    track.line.push(row.line);
    for (column, (role, within)) in members.iter().enumerate() {
        let value = row.values.get(*within).copied().unwrap_or(f64::NAN);
        track.columns[column].push(value * factors[*role]);
    }
}

/// Fills in what camonitor does not write: it is silent while a value stays.
fn hold(tracks: &mut [Track], max_rows: usize, said: &mut Vec<String>) {
    let held: usize = tracks.iter_mut().map(|track| track.hold(max_rows)).sum();
    if held > 0 {
        said.push(format!(
            "{held} values were held where nothing changed, since camonitor writes changes alone"
        ));
    }
}
