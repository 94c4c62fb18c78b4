//! Channels of different clocks on one of them.

/// Time between two changes, in usual ones, from which on nothing changed in between. A choice: a recorder's
/// stamps jitter by a quarter of its period, one late and one early.
const SILENT_FROM: f64 = 1.5;

/// Change across a silence, in the largest of a step while nothing is silent, up to which nothing was missed. A
/// choice: an axis starts from rest no faster than it moves.
const LARGEST_STEP: f64 = 1.5;

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

    /// Puts rows with the value before them where a recorder that writes changes alone was silent, at its
    /// usual pace, up to so many rows in all; returns how many. A change across the silence that is larger
    /// than any of one step was not seen: there rows are missing.
    pub(crate) fn hold(&mut self, max_rows: usize) -> usize {
        let mut steps: Vec<f64> = self.time_s.windows(2).map(|two| two[1] - two[0]).collect();
        if steps.is_empty() {
            return 0;
        }
        let middle = steps.len() / 2;
        let (_, &mut period_s, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
        let is_silent = |two: &[f64]| two[1] - two[0] > SILENT_FROM * period_s;
        // The largest change of a step.
        let largest: Vec<f64> = self
            .columns
            .iter()
            .map(|column| {
                let pairs = column.windows(2).zip(self.time_s.windows(2));
                let usual = pairs.filter(|(_, time)| !is_silent(time));
                usual.fold(0.0, |most: f64, (two, _)| most.max((two[1] - two[0]).abs()))
            })
            .collect();
        let mut held = Track {
            counted: self.counted,
            ..Track::new(self.columns.len())
        };
        let mut room = max_rows.saturating_sub(self.len());
        for row in 0..self.len() {
            let push = |held: &mut Track, time_s: f64| {
                held.time_s.push(time_s);
                held.line.push(self.line[row]);
                for (to, from) in held.columns.iter_mut().zip(&self.columns) {
                    to.push(from[row]);
                }
            };
            push(&mut held, self.time_s[row]);
            let Some(&next_s) = self.time_s.get(row + 1) else {
                break;
            };
            let rests = self.columns.iter().zip(&largest).all(|(column, most)| {
                (column[row + 1] - column[row]).abs() <= LARGEST_STEP * *most
            });
            if !is_silent(&[self.time_s[row], next_s]) || !rests {
                continue;
            }
            // As many steps as fit, each as long as the usual one: the next row is one behind the last.
            let steps = ((next_s - self.time_s[row]) / period_s).round();
            let step_s = (next_s - self.time_s[row]) / steps;
            // A float-to-int cast saturates.
            let more = (steps as usize).saturating_sub(1);
            if more > room {
                continue;
            }
            room -= more;
            for place in 1..=more {
                push(&mut held, self.time_s[row] + place as f64 * step_s);
            }
        }
        let more = held.len() - self.len();
        *self = held;
        more
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
    fn a_silent_recorder_holds_its_value() {
        let mut rests = track(0.1, 40, |t| t);
        // From 1.0 to 2.0 s nothing changed: the value of then goes on by a step.
        rests.leave_out(&(11..20).collect::<Vec<_>>());
        for value in &mut rests.columns[0][11..] {
            *value -= 0.9;
        }
        let mut lost = rests.clone();
        assert_eq!(rests.hold(1000), 9);
        assert_eq!(rests.len(), 40);
        for (row, (time, value)) in rests.time_s.iter().zip(&rests.columns[0]).enumerate() {
            assert!((time - 0.1 * row as f64).abs() < 1e-9, "{row}: {time}");
            let held = time.min(1.0).max(time - 0.9);
            assert!((value - held).abs() < 1e-9, "{row}: {value}");
        }
        // No more than was asked for.
        assert_eq!(lost.clone().hold(35), 0);
        // Half a second of motion that was not written is missing, not held.
        lost.columns[0][11..]
            .iter_mut()
            .for_each(|value| *value += 0.5);
        assert_eq!(lost.hold(1000), 0);
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
