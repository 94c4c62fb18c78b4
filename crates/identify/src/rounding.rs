//! Rounding of positions that does not average out.
//!
//! A position is read in steps. At most speeds its rows fall on all parts of a step, and the error of a mean is
//! far below one. At speeds of a whole step per row all rows fall on the same part, and the mean is off by up to
//! half a step whatever the log's length; at a half step per row by up to a quarter, and so on.
//!
//! Which parts of a step the rows fall on is told by the smoothed position of the motor, since the load is a
//! constant behind it in a stretch of one speed: with the phase `p` of each row in the step, the mean of
//! `exp(2 pi i m p)` is near zero for all `m` where they are spread, and of size 1 at `m = n` where they fall on `n`
//! parts.

use crate::averages::Averages;
use lostmotion_base::math::{exp, sin_cos};
use std::f64::consts::{PI, TAU};

/// Most parts of a step that are looked for. A choice: of more the mean is off by less than an eighth.
const MOST_PARTS: usize = 4;
/// Part of all rows' weight, from which on what falls on the same parts of a step counts. A choice: what chance
/// leaves of some dozens of stretches is in the scatter between them.
const SPREAD_SHARE: f64 = 0.2;
/// The same within one stretch, whose rows then tell how much noise there is beside rounding. A choice.
const SAME_SHARE: f64 = 0.5;
/// Variance of rounding that noise has spread, in squared steps.
const OF_ROUNDING: f64 = 1.0 / 12.0;

/// A row that a figure is told by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    /// Its sample in the log.
    pub(crate) at: usize,
    /// Number of the stretch of one flank that it belongs to.
    pub(crate) stretch: usize,
    /// 1 or -1: the flank.
    pub(crate) side: f64,
    /// What the figure changes by for a unit of the difference of motor and load in this row.
    pub(crate) weight: f64,
}

/// Columns as they were read.
pub(crate) struct Rounded<'a> {
    pub(crate) motor: &'a [f64],
    pub(crate) load: &'a [f64],
    /// Steps of motor and load.
    pub(crate) steps: [f64; 2],
    /// Samples in half a window over which the motor's position is smoothed.
    pub(crate) half: usize,
    /// How much longer than the motor the load reads, in parts of the travel.
    pub(crate) scale: f64,
}

impl Rounded<'_> {
    /// How far a figure may be off for the steps of the positions, in the unit of its weights times theirs; zero
    /// where rows are spread over the steps. Rows are in order of stretches.
    pub(crate) fn unspread(&self, rows: &[Row]) -> f64 {
        let half = self.half;
        if self.motor.len() <= 2 * half || rows.is_empty() {
            return 0.0;
        }
        let smooth = Averages::new(self.motor, half);
        let last = self.motor.len() - 1 - half;
        let places: Vec<f64> = rows
            .iter()
            .map(|row| smooth.mean(row.at.clamp(half, last)))
            .collect();
        let of = |column: &[f64], step: f64, scale: f64| {
            let parts = 1..=MOST_PARTS;
            parts
                .map(|parts| at_parts(rows, &places, column, (step, scale), parts))
                .fold(0.0, f64::max)
        };
        let [motor, load] = self.steps;
        of(self.motor, motor, 0.0) + of(self.load, load, self.scale)
    }
}

/// How far a figure may be off where the rows of a column fall on so many parts of its step.
fn at_parts(
    rows: &[Row],
    places: &[f64],
    column: &[f64],
    (step, scale): (f64, f64),
    parts: usize,
) -> f64 {
    if step <= 0.0 {
        return 0.0;
    }
    let turns = parts as f64 * (1.0 + scale) / step;
    // Sums of both flanks, squares of the stretches' own sums, weight of all.
    let (mut sums, mut squares, mut all) = ([[0.0; 2]; 2], [0.0; 2], [0.0; 2]);
    let (mut noise, mut noisy) = (0.0, 0.0);
    let mut first = 0;
    for stretch in rows.chunk_by(|a, b| a.stretch == b.stretch) {
        let own = &places[first..first + stretch.len()];
        first += stretch.len();
        let flank = usize::from(stretch[0].side > 0.0);
        let (mut sum, mut weight) = ([0.0; 2], 0.0);
        for (row, place) in stretch.iter().zip(own) {
            let (sin, cos) = sin_cos(TAU * (turns * place).fract());
            sum = [sum[0] + row.weight * cos, sum[1] + row.weight * sin];
            weight += row.weight.abs();
        }
        let square = sum[0] * sum[0] + sum[1] * sum[1];
        sums[flank] = [sums[flank][0] + sum[0], sums[flank][1] + sum[1]];
        squares[flank] += square;
        all[flank] += weight;
        if square > SAME_SHARE * SAME_SHARE * weight * weight {
            // Rows of the same part of a step read the same but for noise.
            let off = |at: usize| (column[stretch[at].at] - (1.0 + scale) * own[at]) / step;
            for at in parts..stretch.len() {
                if stretch[at].at == stretch[at - parts].at + parts {
                    let change = off(at) - off(at - parts);
                    noise += 0.5 * change * change;
                    noisy += 1.0;
                }
            }
        }
    }
    // Noise spreads rounding by itself.
    let variance = (noise / f64::max(noisy, 1.0) - OF_ROUNDING).max(0.0);
    let left = exp(-2.0 * PI * PI * (parts * parts) as f64 * variance);
    let most = (0..2).map(|flank| {
        let together = (sums[flank][0] * sums[flank][0] + sums[flank][1] * sums[flank][1]).sqrt();
        let size = together.max(squares[flank].sqrt());
        if size > SPREAD_SHARE * all[flank] {
            size
        } else {
            0.0
        }
    });
    0.5 * step / parts as f64 * left * most.sum::<f64>()
}

/// Changes from row to row of more than one step that show that a column is read in steps. A choice: one of one
/// steady speed changes by the same in all rows but those of its reversals.
const LEAST_MULTIPLES: usize = 20;
/// How far such a change may be off a multiple, in steps. A choice: numbers have so many digits.
const OFF_MULTIPLE: f64 = 0.02;

/// The step that a column is read in: its smallest one, where larger changes are multiples of it; else zero.
pub(crate) fn rounding_step(column: &[f64]) -> f64 {
    let step = smallest_step(column);
    if step <= 0.0 {
        return 0.0;
    }
    let (mut multiples, mut larger) = (0, 0);
    for pair in column.windows(2) {
        let steps = (pair[1] - pair[0]).abs() / step;
        if steps > 1.0 + OFF_MULTIPLE {
            larger += 1;
            multiples += usize::from((steps - steps.round()).abs() < OFF_MULTIPLE);
        }
    }
    // By chance one in twenty-five would be.
    if multiples >= LEAST_MULTIPLES && 2 * multiples > larger {
        step
    } else {
        0.0
    }
}

/// The smallest step that a column makes, taken for one count; zero where it is constant.
pub(crate) fn smallest_step(column: &[f64]) -> f64 {
    let step = column
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|step| *step > 0.0)
        .fold(f64::INFINITY, f64::min);
    if step.is_finite() { step } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_base::Random;

    /// Strokes of one speed, read in steps of 1; what the mean of each flank's difference may be off by, together.
    fn unspread(speed: f64, noise: f64) -> f64 {
        let mut random = Random::new(4_110);
        let (mut motor, mut load, mut rows) = (Vec::new(), Vec::new(), Vec::new());
        for at in 0..8000_usize {
            let (stretch, within) = (at / 400, at % 400);
            let forward = stretch % 2 == 0;
            let side = if forward { 1.0 } else { -1.0 };
            let travel = if forward { within } else { 400 - within };
            let place = 0.3 + speed * travel as f64;
            motor.push(place);
            load.push((place - side * 5.2 + noise * random.normal()).round());
            if within > 20 && within < 380 {
                rows.push(Row {
                    at,
                    stretch,
                    side,
                    weight: 1.0 / 3590.0,
                });
            }
        }
        let log = Rounded {
            motor: &motor,
            load: &load,
            steps: [0.0, 1.0],
            half: 5,
            scale: 0.0,
        };
        log.unspread(&rows)
    }

    #[test]
    fn what_does_not_average_out_is_told() {
        // Half a step on either flank, a quarter, a sixth.
        for (speed, most) in [(3.0, 1.0), (2.5, 0.5), (1.0 / 3.0, 1.0 / 3.0)] {
            let found = unspread(speed, 0.0);
            assert!((found / most - 1.0).abs() < 0.02, "{speed}: {found}");
        }
        for (speed, noise) in [(3.1717, 0.0), (0.618, 0.0), (3.0, 0.5), (2.5, 0.4)] {
            let found = unspread(speed, noise);
            assert!(found < 0.02, "{speed}, {noise}: {found}");
        }
    }
}
