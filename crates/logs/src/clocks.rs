//! Channels of different clocks on one of them.

/// Samples of the channels of one clock.
#[derive(Clone, Debug, Default)]
pub(crate) struct Track {
    pub(crate) time_s: Vec<f64>,
    pub(crate) line: Vec<u64>,
    /// What the lines are called in messages.
    pub(crate) counted: &'static str,
    /// One column for each channel that was asked for.
    pub(crate) columns: Vec<Vec<f64>>,
}

impl Track {
    pub(crate) fn new(columns: usize) -> Track {
        Track {
            columns: vec![Vec::new(); columns],
            ..Track::default()
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.time_s.len()
    }

    pub(crate) fn clear(&mut self) {
        self.time_s.clear();
        self.line.clear();
        self.columns.iter_mut().for_each(Vec::clear);
    }

    /// Puts the rows of another one behind its own.
    pub(crate) fn append(&mut self, mut other: Track) {
        self.time_s.append(&mut other.time_s);
        self.line.append(&mut other.line);
        for (column, more) in self.columns.iter_mut().zip(&mut other.columns) {
            column.append(more);
        }
    }

    /// Mean time between two samples; infinite where there are fewer than two.
    pub(crate) fn period_s(&self) -> f64 {
        match (self.time_s.first(), self.time_s.last()) {
            (Some(first), Some(last)) if self.len() > 1 => (last - first) / (self.len() - 1) as f64,
            _ => f64::INFINITY,
        }
    }

    /// Keeps a range of rows.
    pub(crate) fn keep(&mut self, range: std::ops::Range<usize>) {
        let cut = |values: &mut Vec<f64>| {
            values.truncate(range.end);
            values.drain(..range.start.min(values.len()));
        };
        cut(&mut self.time_s);
        self.columns.iter_mut().for_each(cut);
        self.line.truncate(range.end);
        self.line.drain(..range.start.min(self.line.len()));
    }

    /// Leaves out these rows, which are in order.
    pub(crate) fn leave_out(&mut self, rows: &[usize]) {
        if rows.is_empty() {
            return;
        }
        let keeps: Vec<bool> = (0..self.len())
            .map(|row| rows.binary_search(&row).is_err())
            .collect();
        let keep = |values: &mut Vec<f64>| {
            let mut keeps = keeps.iter();
            values.retain(|_| keeps.next().is_none_or(|keep| *keep));
        };
        keep(&mut self.time_s);
        self.columns.iter_mut().for_each(keep);
        let mut kept = keeps.iter();
        self.line.retain(|_| kept.next().is_none_or(|keep| *keep));
    }

    /// Keeps each `step`th row from `first` on.
    pub(crate) fn thin(&mut self, first: usize, step: usize) {
        let thin = |values: &mut Vec<f64>| {
            *values = values.iter().skip(first).step_by(step).copied().collect();
        };
        thin(&mut self.time_s);
        self.columns.iter_mut().for_each(thin);
        self.line = self
            .line
            .iter()
            .skip(first)
            .step_by(step)
            .copied()
            .collect();
    }
}

/// All columns on the slowest clock, so that nothing is made up: the others are read between their
/// two nearest samples. Rows outside of any clock's time are left out.
pub(crate) fn on_one_clock(tracks: &[Track]) -> Track {
    let slowest = (0..tracks.len())
        .max_by(|&a, &b| tracks[a].period_s().total_cmp(&tracks[b].period_s()))
        .unwrap_or_default();
    let base = &tracks[slowest];
    let begin = tracks
        .iter()
        .filter_map(|track| track.time_s.first())
        .copied()
        .fold(f64::NEG_INFINITY, f64::max);
    let end = tracks
        .iter()
        .filter_map(|track| track.time_s.last())
        .copied()
        .fold(f64::INFINITY, f64::min);
    let rows: Vec<usize> = (0..base.len())
        .filter(|&row| (begin..=end).contains(&base.time_s[row]))
        .collect();
    let mut merged = Track {
        time_s: rows.iter().map(|&row| base.time_s[row]).collect(),
        line: rows.iter().map(|&row| base.line[row]).collect(),
        counted: base.counted,
        columns: Vec::new(),
    };
    for (place, track) in tracks.iter().enumerate() {
        for column in &track.columns {
            merged.columns.push(if place == slowest {
                rows.iter().map(|&row| column[row]).collect()
            } else {
                read_between(&track.time_s, column, &merged.time_s)
            });
        }
    }
    merged
}

/// Values at other times, by straight lines between samples.
fn read_between(time_s: &[f64], values: &[f64], at_s: &[f64]) -> Vec<f64> {
    let mut row = 0;
    at_s.iter()
        .map(|&at| {
            while row + 2 < time_s.len() && time_s[row + 1] <= at {
                row += 1;
            }
            let Some(&next) = time_s.get(row + 1) else {
                return values.first().copied().unwrap_or(f64::NAN);
            };
            let share = (at - time_s[row]) / (next - time_s[row]);
            values[row] + share.clamp(0.0, 1.0) * (values[row + 1] - values[row])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(period: f64, rows: usize, of: impl Fn(f64) -> f64) -> Track {
        let time_s: Vec<f64> = (0..rows).map(|row| row as f64 * period).collect();
        Track {
            line: (0..rows as u64).collect(),
            counted: "line",
            columns: vec![time_s.iter().map(|&t| of(t)).collect()],
            time_s,
        }
    }

    #[test]
    fn the_slowest_clock_carries_the_others() {
        let fast = track(0.2e-3, 1000, |t| 3.0 * t + 1.0);
        let slow = track(1e-3, 300, |t| -t);
        let merged = on_one_clock(&[fast, slow]);
        // the fast one ends after 199.8 ms
        assert_eq!(merged.len(), 200);
        for (row, time) in merged.time_s.iter().enumerate() {
            assert!((merged.columns[0][row] - (3.0 * time + 1.0)).abs() < 1e-12);
            assert_eq!(merged.columns[1][row], -time);
        }
    }
}
