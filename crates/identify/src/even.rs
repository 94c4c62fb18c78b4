//! From rows at uneven times to samples at even ones.

use crate::error::FitError;
use lostmotion_base::math::quantile;

/// How far a time between two rows may be off before the rows count as uneven, in parts of the
/// period. A choice: times written with few decimals pass.
const EVEN_TOLERANCE_SHARE: f64 = 0.01;
/// Time between two rows, in periods, from which on a row is missing between them. A choice: rows
/// that jitter by a quarter of the period, one late and one early, are less than that apart.
const MISSING_FROM: f64 = 1.75;

/// Even times over a log, and between which rows each lies.
pub(crate) struct EvenGrid {
    /// Time between two samples, s.
    pub(crate) period_s: f64,
    /// Whether the rows are even already.
    pub(crate) even: bool,
    /// Samples that lie in the place of missing rows.
    pub(crate) lost: Vec<bool>,
    /// Time of each sample, s.
    times_s: Vec<f64>,
    /// The row at or before each sample.
    rows: Vec<usize>,
}

impl EvenGrid {
    /// The grid for rows at these times.
    pub(crate) fn new(time_s: &[f64]) -> Result<Self, FitError> {
        let (Some(&first), Some(&last)) = (time_s.first(), time_s.last()) else {
            return Err(FitError::Empty);
        };
        let steps = || time_s.windows(2).map(|pair| pair[1] - pair[0]);
        if let Some(index) = steps().position(|step| !(step.is_finite() && step > 0.0)) {
            return Err(FitError::TimeOrder {
                index: index + 1,
                before_s: time_s[index],
                time_s: time_s[index + 1],
            });
        }
        // The median step is the recorder's period, whatever is missing. Counted in it, the whole
        // log gives the mean, free of jitter and of the rounding of single times.
        let median = quantile(steps().collect(), 0.5);
        let periods: f64 = steps()
            .map(|step| step / median)
            .map(|step| {
                if step < MISSING_FROM {
                    1.0
                } else {
                    step.round()
                }
            })
            .sum();
        let period_s = (last - first) / periods.max(1.0);
        let even = steps().all(|step| (step - period_s).abs() <= EVEN_TOLERANCE_SHARE * period_s);
        if even {
            return Ok(Self {
                period_s,
                even,
                lost: Vec::new(),
                times_s: Vec::new(),
                rows: Vec::new(),
            });
        }
        let samples = ((last - first) / period_s + 1e-6).floor();
        // More places than twice the rows: most of the log is missing, or a time is wrong.
        if samples > 2.0 * time_s.len() as f64 {
            return Err(FitError::RowsMissing {
                rows: time_s.len(),
                places: samples,
            });
        }
        let mut grid = Self {
            period_s,
            even,
            lost: Vec::new(),
            times_s: Vec::new(),
            rows: Vec::new(),
        };
        let mut row = 0;
        for sample in 0..=samples as usize {
            let time = first + sample as f64 * period_s;
            while row + 2 < time_s.len() && time_s[row + 1] <= time {
                row += 1;
            }
            grid.times_s.push(time);
            grid.rows.push(row);
            // A sample near a row is as good as the row, however wide the gap on its other side.
            let nearest = (time - time_s[row])
                .abs()
                .min((time_s[row + 1] - time).abs());
            let wide = time_s[row + 1] - time_s[row] > MISSING_FROM * period_s;
            grid.lost
                .push(wide && nearest > EVEN_TOLERANCE_SHARE * period_s);
        }
        Ok(grid)
    }

    /// A smooth column at the even times: Lagrange's cubic through the four nearest rows.
    pub(crate) fn cubic(&self, time_s: &[f64], values: &[f64]) -> Vec<f64> {
        let at = |(&time, &row): (&f64, &usize)| {
            let first = row.saturating_sub(1).min(values.len().saturating_sub(4));
            let last = (first + 4).min(values.len());
            lagrange(
                &time_s[first..last],
                &values[first..last],
                row - first,
                time,
            )
        };
        self.times_s.iter().zip(&self.rows).map(at).collect()
    }

    /// A noisy column at the even times: straight lines between rows.
    pub(crate) fn straight(&self, time_s: &[f64], values: &[f64]) -> Vec<f64> {
        let at = |(&time, &row): (&f64, &usize)| {
            let share = (time - time_s[row]) / (time_s[row + 1] - time_s[row]);
            values[row] + share * (values[row + 1] - values[row])
        };
        self.times_s.iter().zip(&self.rows).map(at).collect()
    }
}

/// The polynomial through some rows at a time, summed from one of them, since positions are large beside
/// what they change by.
pub(crate) fn lagrange(times: &[f64], values: &[f64], base: usize, time: f64) -> f64 {
    let weight = |i: usize| -> f64 {
        (0..times.len())
            .filter(|j| *j != i)
            .map(|j| (time - times[j]) / (times[i] - times[j]))
            .product()
    };
    let base = values[base];
    let from_base = |i: usize| weight(i) * (values[i] - base);
    (0..times.len()).map(from_base).sum::<f64>() + base
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uneven_rows_of_a_cubic_come_out_even() {
        let times = [0.0, 0.9e-3, 2.1e-3, 3.0e-3, 4.05e-3, 4.95e-3, 6.0e-3];
        let cubic = |t: f64| 1.0 + 3.0 * t - 2e3 * t * t + 5e5 * t * t * t;
        let values: Vec<f64> = times.iter().map(|&t| cubic(t)).collect();
        let grid = EvenGrid::new(&times).unwrap();
        assert!(!grid.even && (grid.period_s - 1e-3).abs() < 1e-12);
        for (time, value) in grid.times_s.iter().zip(grid.cubic(&times, &values)) {
            assert!((value - cubic(*time)).abs() < 1e-12, "{time}: {value}");
        }
        assert!(!grid.lost.contains(&true));
    }

    #[test]
    fn jitter_does_not_change_the_period() {
        // rows early and late by a quarter: steps of half a period to one and a half
        let times: Vec<f64> = (0..400)
            .map(|k| f64::from(k) * 1e-3 + [0.0, 2.5e-4, -2.5e-4, 0.0][k as usize % 4])
            .collect();
        let grid = EvenGrid::new(&times).unwrap();
        assert!((grid.period_s - 1e-3).abs() < 1e-12, "{}", grid.period_s);
        assert!(!grid.lost.contains(&true));
    }

    #[test]
    fn a_missing_row_is_a_lost_sample() {
        let times = [0.0, 1e-3, 2e-3, 4e-3, 5e-3, 6e-3];
        let grid = EvenGrid::new(&times).unwrap();
        assert_eq!(grid.lost, [false, false, false, true, false, false, false]);
        assert_eq!(
            grid.straight(&times, &[0.0, 1.0, 2.0, 4.0, 5.0, 6.0]).len(),
            7
        );
    }

    #[test]
    fn times_out_of_order_and_hollow_logs_are_refused() {
        assert!(matches!(
            EvenGrid::new(&[0.0, 1e-3, 1e-3]),
            Err(FitError::TimeOrder { index: 2, .. })
        ));
        assert!(matches!(
            EvenGrid::new(&[0.0, 1e-3, 2e-3, 1.0]),
            Err(FitError::RowsMissing { rows: 4, .. })
        ));
    }
}
