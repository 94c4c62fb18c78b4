//! Flaws of a recorded position: counters that wrap, places that jump, values that are held.

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
    let changes: Vec<f64> = speed
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|change| *change > 0.0)
        .collect();
    if changes.is_empty() {
        return Vec::new();
    }
    let usual = quantile(changes, 0.5);
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

/// The period of a counter that wraps: all jumps have its size, there are some of either sign or it
/// is a turn or a power of two. `turn` is a full turn in the column's unit, where it is an angle.
pub(crate) fn wrap(jumps: &[Jump], turn: Option<f64>) -> Option<f64> {
    let first = jumps.first()?.size.abs();
    let alike = |period: f64| {
        jumps
            .iter()
            .all(|jump| (jump.size.abs() - period).abs() <= WRAP_TOLERANCE * period)
    };
    // Counters of 8 to 32 bits.
    let of_two = [256.0, 65_536.0, 16_777_216.0, 4_294_967_296.0];
    let known = turn.into_iter().chain(of_two).find(|&period| alike(period));
    known.or_else(|| {
        let mean = jumps.iter().map(|jump| jump.size.abs()).sum::<f64>() / jumps.len() as f64;
        (jumps.len() > 2 && alike(first)).then_some(mean)
    })
}

/// Adds up the wraps.
pub(crate) fn unwrap(values: &mut [f64], jumps: &[Jump], period: f64) {
    let mut jumps = jumps.iter().peekable();
    let mut added = 0.0;
    for (row, value) in values.iter_mut().enumerate() {
        if let Some(jump) = jumps.next_if(|jump| jump.row == row) {
            added -= period * jump.size.signum();
        }
        *value += added;
    }
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
        assert_eq!(wrap(&found, None), None);
    }

    #[test]
    fn a_rotary_axis_wraps_at_a_turn() {
        let whole: Vec<f64> = (0..3000).map(|row| 0.37 * f64::from(row)).collect();
        let mut values: Vec<f64> = whole.iter().map(|angle| angle.rem_euclid(360.0)).collect();
        let found = jumps(&times(3000), &values);
        assert_eq!(found.len(), 3);
        assert_eq!(wrap(&found, Some(360.0)), Some(360.0));
        unwrap(&mut values, &found, 360.0);
        for (found, whole) in values.iter().zip(&whole) {
            assert!((found - whole).abs() < 1e-9);
        }
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
