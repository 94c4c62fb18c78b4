//! Flaws of a recorded position: counters that wrap, places that jump, values that are off for a few rows,
//! values that are held.

use crate::clocks::Track;
use lostmotion_base::math::quantile;

/// Neighbours on either side that a step is held against.
const NEIGHBOURS: usize = 4;
/// How many times larger than its neighbours a step is that no motion makes. A choice: an axis that
/// starts from rest takes several rows to its speed.
const STEP_RATIO: f64 = 8.0;
/// The same against the usual change of a step from row to row.
const CHANGE_RATIO: f64 = 50.0;
/// Counts of a position that a step has to exceed, for the same reason: an encoder that creeps stands for
/// many rows and then steps.
const COUNTS: f64 = 8.0;
/// Fewest steps that the count of a position is told from.
const MIN_STEPS: usize = 20;
/// Share of runs of equal values that have to be as long as the clock says.
const HELD_SHARE: f64 = 0.95;
/// Fewest runs that a clock is told from.
const MIN_RUNS: usize = 20;
/// Most rows that a value is held. A choice.
const MAX_HELD: usize = 1000;
/// How far the step over a wrap may be off its neighbours', in parts of the wrap.
const WRAP_TOLERANCE: f64 = 0.02;
/// How far the mean step over many wraps may be off a power of two of counts to be one. A choice: counters
/// of 1000 and 1024 are five times that apart.
const POWER_TOLERANCE: f64 = 0.005;
/// Bits of the counters that are known.
const BITS: std::ops::RangeInclusive<u32> = 8..=32;
/// Most rows that a position may be off for to come back where it was. A choice: a flaw of the recording is one
/// row, or a few of them.
const SPIKE_ROWS: usize = 3;
/// How far the steps to a place that is off and back may differ, in parts of them.
const SPIKE_TOLERANCE: f64 = 0.1;

/// A step that no motion makes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jump {
    /// The row behind the step.
    pub(crate) row: usize,
    /// The step less what its neighbours do.
    pub(crate) size: f64,
}

/// Steps that are far larger than their neighbours and than all that usually changes from row to
/// row.
pub(crate) fn jumps(time_s: &[f64], values: &[f64]) -> Vec<Jump> {
    let rows = values.len().min(time_s.len());
    if rows < 2 * NEIGHBOURS {
        return Vec::new();
    }
    // Speeds, so that a missing row is no jump.
    let speed: Vec<f64> = (1..rows)
        .map(|row| (values[row] - values[row - 1]) / (time_s[row] - time_s[row - 1]))
        .collect();
    let Some(usual) = usual_change(&speed) else {
        return Vec::new();
    };
    let count = count_of(values);
    let mut found = Vec::new();
    for (step, &here) in speed.iter().enumerate() {
        let around = step.saturating_sub(NEIGHBOURS)..(step + NEIGHBOURS + 1).min(speed.len());
        let others: Vec<f64> = around
            .filter(|&other| other != step)
            .map(|other| speed[other])
            .collect();
        let largest = others
            .iter()
            .fold(0.0, |largest: f64, other| largest.max(other.abs()));
        let size = (values[step + 1] - values[step]).abs();
        if here.abs() > STEP_RATIO * largest
            && here.abs() > CHANGE_RATIO * usual
            && size > COUNTS * count
        {
            let expected = quantile(others, 0.5);
            found.push(Jump {
                row: step + 1,
                size: (here - expected) * (time_s[step + 1] - time_s[step]),
            });
        }
    }
    found
}

/// The count of a position: what its smallest steps are, or 0 where too few tell it.
fn count_of(values: &[f64]) -> f64 {
    let steps: Vec<f64> = values
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|step| *step > 0.0)
        .collect();
    if steps.len() < MIN_STEPS {
        return 0.0;
    }
    quantile(steps, 0.05)
}

/// A few rows that are off, as a fault of a line makes them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spike {
    /// The first of its rows.
    pub(crate) row: usize,
    pub(crate) rows: usize,
    /// How far they are off.
    pub(crate) size: f64,
}

/// Median change from one value to the next, of those that change at all.
fn usual_change(values: &[f64]) -> Option<f64> {
    let changes: Vec<f64> = values
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|change| *change > 0.0)
        .collect();
    (!changes.is_empty()).then(|| quantile(changes, 0.5))
}

/// Rows between two steps that no motion makes, there and back.
pub(crate) fn spikes(values: &[f64]) -> Vec<Spike> {
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let Some(usual) = usual_change(&steps) else {
        return Vec::new();
    };
    let least = (CHANGE_RATIO * usual).max(COUNTS * count_of(values));
    let mut found: Vec<Spike> = Vec::new();
    for (at, &there) in steps.iter().enumerate() {
        let behind = found.last().map_or(0, |last| last.row + last.rows);
        if there.abs() <= least || at + 1 < behind {
            continue;
        }
        for rows in 1..=SPIKE_ROWS {
            let Some(back) = steps.get(at + rows) else {
                break;
            };
            let around =
                at.saturating_sub(NEIGHBOURS)..(at + rows + NEIGHBOURS + 1).min(steps.len());
            let usual = around
                .filter(|&other| other != at && other != at + rows)
                .fold(0.0, |most: f64, other| most.max(steps[other].abs()));
            // Rows within it may move on as all others do.
            let off = (there + back).abs() <= SPIKE_TOLERANCE * there.abs() + 2.0 * usual;
            if off && there * back < 0.0 && there.abs().min(back.abs()) > STEP_RATIO * usual {
                found.push(Spike {
                    row: at + 1,
                    rows,
                    size: 0.5 * (there - back),
                });
                break;
            }
        }
    }
    found
}

/// Says which rows are off, and returns them.
pub(crate) fn say_spikes(
    found: &[Spike],
    track: &Track,
    what: &str,
    said: &mut Vec<String>,
) -> Vec<usize> {
    let first = found.first().map(|spike| {
        format!(
            "{} {}: {what}'s position is off by {:.4} and comes back",
            track.counted,
            track.line.get(spike.row).copied().unwrap_or_default(),
            spike.size
        )
    });
    let rows: Vec<usize> = found
        .iter()
        .flat_map(|spike| spike.row..spike.row + spike.rows)
        .collect();
    let more = match found.len() {
        1 => String::new(),
        several => format!(", and {} times more", several - 1),
    };
    let left = match rows.len() {
        1 => "1 row is left out".to_owned(),
        several => format!("{several} rows are left out"),
    };
    said.extend(first.map(|first| format!("{first}{more}: {left}")));
    rows
}

/// The period of a counter that wraps: all jumps have its size, there are some of either sign or it
/// is a turn or a power of two, and the values lie within it. `turns` are what may be a full turn in the column's
/// unit, and `count` what one of the values in the log is in it.
pub(crate) fn wrap(values: &[f64], jumps: &[Jump], turns: &[f64], count: f64) -> Option<f64> {
    let first = jumps.first()?.size.abs();
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let alike = |period: f64| {
        jumps
            .iter()
            .all(|jump| (jump.size.abs() - period).abs() <= WRAP_TOLERANCE * period)
            && most - least <= (1.0 + WRAP_TOLERANCE) * period
    };
    // Counters of 8 to 32 bits.
    let of_two = [256.0, 65_536.0, 16_777_216.0, 4_294_967_296.0];
    let of_counts = of_two.map(|period| period * count);
    let known = turns
        .iter()
        .copied()
        .chain(of_two)
        .chain(of_counts)
        .find(|&period| alike(period));
    known.or_else(|| {
        let mean = jumps.iter().map(|jump| jump.size.abs()).sum::<f64>() / jumps.len() as f64;
        // Jumps tell it to within the speed's changes, whole bits exactly.
        let whole = BITS
            .map(|bits| count * (1_u64 << bits) as f64)
            .find(|period| (mean - period).abs() <= POWER_TOLERANCE * period);
        (jumps.len() > 2 && alike(first)).then_some(whole.unwrap_or(mean))
    })
}

/// Adds up the wraps: each step is the one that is nearest to what the speed before makes of it. A counter
/// that wraps every few rows shows no jumps beside its neighbours. Returns how often it wraps.
pub(crate) fn unwrap(time_s: &[f64], values: &mut [f64], period: f64) -> usize {
    let (mut speed, mut added, mut wraps) = (0.0, 0.0, 0);
    let mut before = values.first().copied().unwrap_or(0.0);
    for row in 1..values.len().min(time_s.len()) {
        let over_s = time_s[row] - time_s[row - 1];
        let step = values[row] - before;
        let turns = ((speed * over_s - step) / period).round();
        before = values[row];
        added += turns * period;
        wraps += usize::from(turns != 0.0);
        values[row] += added;
        speed = (step + turns * period) / over_s;
    }
    wraps
}

/// Rows that a column holds each value for while it changes, and the first row of such a run; 1
/// where it changes freely.
pub(crate) fn held(values: &[f64]) -> (usize, usize) {
    let changes: Vec<usize> = (1..values.len())
        .filter(|&row| values[row] != values[row - 1])
        .collect();
    let runs: Vec<usize> = changes.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if runs.len() < MIN_RUNS {
        return (1, 0);
    }
    // The shortest run that is common; longer ones are whole multiples, where the value stayed.
    let mut sorted = runs.clone();
    sorted.sort_unstable();
    let step = sorted[sorted.len() / 20];
    if !(2..=MAX_HELD).contains(&step) {
        return (1, 0);
    }
    let whole = runs.iter().filter(|&&run| run % step == 0).count();
    if (whole as f64) < HELD_SHARE * runs.len() as f64 {
        return (1, 0);
    }
    // The phase that most changes have.
    let mut phases = vec![0usize; step];
    for change in &changes {
        phases[change % step] += 1;
    }
    let phase = (0..step)
        .max_by_key(|&phase| phases[phase])
        .unwrap_or_default();
    (step, phase)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(rows: usize) -> Vec<f64> {
        (0..rows).map(|row| row as f64 * 1e-3).collect()
    }

    #[test]
    fn a_motion_has_no_jumps() {
        // from rest, with an acceleration that sets in at once, in steps of an encoder
        let values: Vec<f64> = (0..2000)
            .map(|row| {
                let t = f64::from(row.max(500) - 500) * 1e-3;
                (200.0 * t * t / 2.0 / 1e-4).round() * 1e-4
            })
            .collect();
        assert_eq!(jumps(&times(2000), &values), []);
    }

    #[test]
    fn a_scale_that_creeps_by_counts_has_no_jumps() {
        // 1 um a count, 0.4 to 0.01 counts a row, forth and back, with a row of two counts at once
        let mut values: Vec<f64> = (0..4000)
            .map(|row| {
                let t = f64::from(row - 2000) * 1e-3;
                (50.0 * t * t * t.abs()).round() * 1e-3
            })
            .collect();
        for value in &mut values[2600..] {
            *value += 1e-3;
        }
        assert_eq!(jumps(&times(4000), &values), []);
    }

    #[test]
    fn lost_rows_are_a_jump() {
        let values: Vec<f64> = (0..200)
            .map(|row| {
                0.005 * f64::from(row + if row > 99 { 31 } else { 0 }) + 1e-5 * f64::from(row % 3)
            })
            .collect();
        let found = jumps(&times(200), &values);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].row, 100);
        assert!((found[0].size - 0.155).abs() < 1e-3);
        assert_eq!(wrap(&values, &found, &[], 1.0), None);
    }

    #[test]
    fn a_rotary_axis_wraps_at_a_turn() {
        let whole: Vec<f64> = (0..3000).map(|row| 0.37 * f64::from(row)).collect();
        let mut values: Vec<f64> = whole.iter().map(|angle| angle.rem_euclid(360.0)).collect();
        let found = jumps(&times(3000), &values);
        assert_eq!(found.len(), 3);
        assert_eq!(wrap(&values, &found, &[360.0], 1.0), Some(360.0));
        assert_eq!(unwrap(&times(3000), &mut values, 360.0), 3);
        for (found, whole) in values.iter().zip(&whole) {
            assert!((found - whole).abs() < 1e-9);
        }
    }

    #[test]
    fn a_counter_that_wraps_every_few_rows_is_added_up() {
        // 16 bits of 0.1 um, forth and back with up to 1.3 mm a row
        let whole: Vec<f64> = (0..4000)
            .map(|row| 400.0 * lostmotion_base::math::sin(f64::from(row) * 3.2e-3))
            .map(|mm| (mm / 1e-4).round())
            .collect();
        let mut values: Vec<f64> = whole
            .iter()
            .map(|count| 1e-4 * ((count + 32_768.0).rem_euclid(65_536.0) - 32_768.0))
            .collect();
        let found = jumps(&times(4000), &values);
        let period = wrap(&values, &found, &[], 1e-4).unwrap();
        assert!((period - 6.5536).abs() < 1e-12, "{period}");
        assert!(unwrap(&times(4000), &mut values, period) > found.len());
        for (found, whole) in values.iter().zip(&whole) {
            assert!((found - 1e-4 * whole).abs() < 1e-6, "{found} {whole}");
        }
    }

    #[test]
    fn rows_that_are_off_are_seen_and_motion_is_not() {
        let motion = |row: i32| 20.0 * lostmotion_base::math::sin(f64::from(row) * 6e-3);
        let mut values: Vec<f64> = (0..3000).map(motion).collect();
        assert_eq!(spikes(&values), []);
        values[700] += 70.0;
        values[1500] -= 5.0;
        values[1501] -= 5.0;
        let found = spikes(&values);
        let places: Vec<(usize, usize)> =
            found.iter().map(|spike| (spike.row, spike.rows)).collect();
        assert_eq!(places, [(700, 1), (1500, 2)]);
        assert!((found[0].size - 70.0).abs() < 0.1 && (found[1].size + 5.0).abs() < 0.2);
        // a place that stays where it jumped to is no such row
        let moved: Vec<f64> = (0..3000)
            .map(|row| motion(row) + if row < 1000 { 0.0 } else { 5.0 })
            .collect();
        assert_eq!(spikes(&moved), []);
    }

    #[test]
    fn a_slow_clock_is_seen_in_a_fast_log() {
        let values: Vec<f64> = (0..3000)
            .map(|row: i32| lostmotion_base::math::sin(f64::from((row - 7).div_euclid(10)) * 0.01))
            .collect();
        assert_eq!(held(&values), (10, 7));
        let free: Vec<f64> = (0..300)
            .map(|row| lostmotion_base::math::sin(f64::from(row) * 0.01))
            .collect();
        assert_eq!(held(&free), (1, 0));
    }
}
