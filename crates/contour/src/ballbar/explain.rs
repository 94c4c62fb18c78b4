//! Which errors of two axes explain the deviations of a circle, by least squares.
//!
//! ```text
//! deviation(a) = mean + cx cos a + cy sin a                      radius and centre
//!              + R/2 scale cos 2a + R/2 square sin 2a            geometry: the same in both senses
//!              + sense/2 mismatch sin 2a                         one axis behind the other: turns over
//!              + lost_x/2 sense sign(sin a) cos a                each axis behind by half of what it
//!              - lost_y/2 sense sign(cos a) sin a                  loses, against its velocity
//! ```
//!
//! That is so to first order. What the second order, the way along the circle squared over twice the
//! radius, does to each value widens its interval.
//!
//! Spikes are left out: 15 degrees behind each reversal. Intervals come from leaving out each stretch
//! of 15 degrees in turn (jackknife): what the model does not have, such as bent guides, is then no
//! more certain than it repeats.

use super::reversal::SPIKE_DEG;
use lostmotion_base::linalg::{Matrix, cholesky, cholesky_solve};
use lostmotion_base::math;
use std::f64::consts::TAU;

/// Unknowns: mean, centre, scale, squareness, mismatch, lost motion of both axes.
pub(super) const UNKNOWNS: usize = 8;
/// Places of those that are explained.
pub(super) const SCALE: usize = 3;
pub(super) const SQUARE: usize = 4;
pub(super) const MISMATCH: usize = 5;
pub(super) const LOST: [usize; 2] = [6, 7];
/// Stretches of a turn that are left out in turn.
const STRETCHES: usize = 24;
/// Smallest pivot of the normalised equations with which an unknown is told. A choice: its error is
/// then thirty times what it would be if it stood alone.
const LEAST_PIVOT: f64 = 1e-3;
/// Student's t of 95 % with as many stretches as one turn has.
const STUDENT: f64 = 2.07;

/// One sense of rotation: angles, rad, and deviations; whether it is counter-clockwise.
pub(super) type Sense<'a> = (&'a [(f64, f64)], bool);

/// A value with the ends of its 95 % interval.
pub(super) type Told = (f64, [f64; 2]);

/// The row of an angle for a circle in one sense.
fn row(angle: f64, sense: f64, radius: f64) -> [f64; UNKNOWNS] {
    let (sin, cos) = math::sin_cos(angle);
    let (sin2, cos2) = (2.0 * sin * cos, cos * cos - sin * sin);
    [
        1.0,
        cos,
        sin,
        0.5 * radius * cos2,
        0.5 * radius * sin2,
        0.5 * sense * sin2,
        0.5 * sense * sin.signum() * cos,
        -0.5 * sense * cos.signum() * sin,
    ]
}

/// The deviation that the first order leaves out: the tip goes along the circle, too, which is no
/// straight line. Radius in m, deviations in um.
fn second_order(row: &[f64; UNKNOWNS], found: &[f64; UNKNOWNS], radius: f64) -> f64 {
    let [_, cos, sin, ..] = *row;
    let part = |i: usize| row[i] * found[i];
    // What moves the tip outwards along X (Y) by e cos (e sin) moves it along the circle by -e sin
    // (e cos).
    let x = found[1] + radius * (found[SCALE] * cos + found[SQUARE] * sin);
    let lag = 2.0 * part(MISMATCH);
    let along = found[2] * cos
        - x * sin
        - if cos == 0.0 {
            0.0
        } else {
            (lag + part(LOST[0])) * sin / cos
        }
        + if sin == 0.0 {
            0.0
        } else {
            part(LOST[1]) * cos / sin
        };
    along * along / (2e6 * radius)
}

/// Whether an angle lies next to the reversal of an axis, behind it as it is travelled.
fn is_spike(angle: f64, sense: f64) -> bool {
    let quarter = (sense * angle).rem_euclid(0.25 * TAU);
    quarter < SPIKE_DEG.to_radians()
}

/// Normal equations of a stretch.
#[derive(Clone, Copy)]
struct Sums {
    matrix: Matrix<UNKNOWNS>,
    right: [f64; UNKNOWNS],
    count: f64,
}

impl Sums {
    const NONE: Sums = Sums {
        matrix: [[0.0; UNKNOWNS]; UNKNOWNS],
        right: [0.0; UNKNOWNS],
        count: 0.0,
    };

    fn add(&mut self, row: &[f64; UNKNOWNS], value: f64, sign: f64) {
        for (i, one) in row.iter().enumerate() {
            self.right[i] += sign * one * value;
            for (j, other) in row.iter().enumerate() {
                self.matrix[i][j] += sign * one * other;
            }
        }
        self.count += sign;
    }

    fn without(&self, other: &Sums) -> Sums {
        let mut left = *self;
        for i in 0..UNKNOWNS {
            left.right[i] -= other.right[i];
            for j in 0..UNKNOWNS {
                left.matrix[i][j] -= other.matrix[i][j];
            }
        }
        left.count -= other.count;
        left
    }

    /// The solution, with those that are not told at zero.
    fn solve(&self, told: &[bool; UNKNOWNS]) -> [f64; UNKNOWNS] {
        let mut matrix = self.matrix;
        let mut right = self.right;
        for i in 0..UNKNOWNS {
            if !told[i] {
                matrix[i].fill(0.0);
                for row in &mut matrix {
                    row[i] = 0.0;
                }
                (matrix[i][i], right[i]) = (1.0, 0.0);
            }
        }
        cholesky_solve(&cholesky(&matrix, f64::MIN_POSITIVE), &right)
    }

    /// Which unknowns are told beside those before them.
    fn told(&self, both: bool) -> [bool; UNKNOWNS] {
        let mut told = [true; UNKNOWNS];
        // With one sense a turn of an axis and a lag look alike: the two together are one unknown.
        told[MISMATCH] = both;
        let scale: [f64; UNKNOWNS] =
            std::array::from_fn(|i| 1.0 / self.matrix[i][i].max(f64::MIN_POSITIVE).sqrt());
        for last in 0..UNKNOWNS {
            let mut matrix = [[0.0; UNKNOWNS]; UNKNOWNS];
            for i in 0..UNKNOWNS {
                matrix[i][i] = 1.0;
                for j in 0..i {
                    if i <= last && told[i] && told[j] {
                        matrix[i][j] = self.matrix[i][j] * scale[i] * scale[j];
                    }
                }
            }
            let pivot = cholesky(&matrix, f64::MIN_POSITIVE)[last][last];
            let is_moved = self.matrix[last][last] > 0.0;
            told[last] &= is_moved && pivot * pivot >= LEAST_PIVOT;
        }
        told
    }
}

/// The deviations without what is explained but lost motion: on what is left a reversal is a step.
pub(super) fn levelled(
    (points, counterclockwise): Sense<'_>,
    values: &[Option<Told>; UNKNOWNS],
    radius: f64,
) -> Vec<(f64, f64)> {
    let sense = if counterclockwise { 1.0 } else { -1.0 };
    let level = |&(angle, off): &(f64, f64)| {
        let row = row(angle, sense, radius);
        let smooth = (0..UNKNOWNS).filter(|place| !LOST.contains(place));
        let made: f64 = smooth
            .filter_map(|place| Some(row[place] * values[place]?.0))
            .sum();
        (angle, off - made)
    };
    points.iter().map(level).collect()
}

/// The solution, and half the intervals of its values by leaving out each stretch in turn.
fn jackknife(
    whole: &Sums,
    stretches: &[Sums],
    told: &[bool; UNKNOWNS],
) -> ([f64; UNKNOWNS], [f64; UNKNOWNS]) {
    let found = whole.solve(told);
    let count = stretches.len() as f64;
    let mut square = [0.0; UNKNOWNS];
    for sums in stretches {
        let other = whole.without(sums).solve(told);
        for (square, (a, b)) in square.iter_mut().zip(other.iter().zip(&found)) {
            *square += (a - b) * (a - b);
        }
    }
    let factor = (count - 1.0).max(0.0) / count.max(1.0);
    (
        found,
        square.map(|square| STUDENT * (factor * square).sqrt()),
    )
}

/// What explains the deviations of one or two senses of a circle; radius in the unit of the
/// deviations. `None` for each unknown that is not told.
pub(super) fn explain(senses: &[Sense<'_>], radius: f64) -> ([Option<Told>; UNKNOWNS], f64) {
    let both = senses.iter().any(|(_, ccw)| *ccw) && senses.iter().any(|(_, ccw)| !*ccw);
    let mut stretches = vec![Sums::NONE; STRETCHES * senses.len()];
    let mut whole = Sums::NONE;
    let each = |visit: &mut dyn FnMut(usize, [f64; UNKNOWNS], f64)| {
        for (index, (points, ccw)) in senses.iter().enumerate() {
            let sense = if *ccw { 1.0 } else { -1.0 };
            for &(angle, off) in *points {
                if !is_spike(angle, sense) {
                    let turn = (angle / TAU).rem_euclid(1.0);
                    let stretch = (turn * STRETCHES as f64) as usize % STRETCHES;
                    visit(index * STRETCHES + stretch, row(angle, sense, radius), off);
                }
            }
        }
    };
    each(&mut |stretch, row, off| {
        whole.add(&row, off, 1.0);
        if let Some(sums) = stretches.get_mut(stretch) {
            sums.add(&row, off, 1.0);
        }
    });
    let told = whole.told(both);
    stretches.retain(|sums| sums.count > 0.0);
    let (found, mut halves) = jackknife(&whole, &stretches, &told);
    // What is not told is not zero for that reason: the others hold their part of it.
    let moved =
        std::array::from_fn(|i| whole.matrix[i][i] > 0.0 && (told[i] || both || i != MISMATCH));
    let (all, all_halves) = jackknife(&whole, &stretches, &moved);
    for untold in (0..UNKNOWNS).filter(|&i| moved[i] && !told[i]) {
        let column = Sums {
            right: whole.matrix.map(|row| row[untold]),
            ..whole
        };
        let size = all[untold].abs() + all_halves[untold];
        for (half, part) in halves.iter_mut().zip(column.solve(&told)) {
            *half += part.abs() * size;
        }
    }
    let (mut left, mut rows) = (0.0, 0.0);
    each(&mut |_, row, off| {
        let made: f64 = row.iter().zip(&found).map(|(a, b)| a * b).sum();
        left += (off - made) * (off - made);
        rows += 1.0;
    });
    let mut bent = Sums {
        right: [0.0; UNKNOWNS],
        ..whole
    };
    each(&mut |_, row, _| {
        let second = second_order(&row, &found, radius);
        for (right, one) in bent.right.iter_mut().zip(row) {
            *right += one * second;
        }
    });
    let bent = bent.solve(&told);
    let values = std::array::from_fn(|i| {
        let half = halves[i] + bent[i].abs();
        (told[i] && half.is_finite()).then(|| (found[i], [found[i] - half, found[i] + half]))
    });
    (values, (left / f64::max(rows, 1.0)).sqrt())
}
