//! Least squares with errors from the scatter between blocks of the log.

use super::Figure;
use crate::huber::solve_small;
use crate::spread::student_975;

/// Blocks that the log is cut into. A choice: with nineteen degrees of freedom Student's t is 7 %
/// above the normal quantile, and a block of an ordinary log holds more than one stroke.
pub(crate) const BLOCKS: usize = 20;

/// Part of a column's square that is taken for noise at most. A choice: a column that is noise for the most
/// part tells nothing.
const MOST_NOISE: f64 = 0.8;

/// Sums of one block.
#[derive(Clone, Copy)]
struct Sums<const P: usize> {
    matrix: [[f64; P]; P],
    right: [f64; P],
    square: f64,
    rows: f64,
}

impl<const P: usize> Sums<P> {
    const ZERO: Sums<P> = Sums {
        matrix: [[0.0; P]; P],
        right: [0.0; P],
        square: 0.0,
        rows: 0.0,
    };

    fn add(&mut self, other: &Sums<P>, sign: f64) {
        for i in 0..P {
            for j in 0..P {
                self.matrix[i][j] += sign * other.matrix[i][j];
            }
            self.right[i] += sign * other.right[i];
        }
        self.square += sign * other.square;
        self.rows += sign * other.rows;
    }

    /// The minimiser over the columns that are used; the others stay zero.
    fn solve(&self, used: &[bool; P]) -> Option<[f64; P]> {
        // Columns of different units are brought to one size first.
        let size: [f64; P] = std::array::from_fn(|i| self.matrix[i][i].sqrt());
        if (0..P).any(|i| used[i] && (size[i] <= 0.0 || size[i].is_nan())) {
            return None;
        }
        let scale = |i: usize| if used[i] { 1.0 / size[i] } else { 0.0 };
        let mut matrix = [[0.0; P]; P];
        for (i, row) in matrix.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = self.matrix[i][j] * scale(i) * scale(j);
            }
            if !used[i] {
                row[i] = 1.0;
            }
        }
        let right = std::array::from_fn(|i| self.right[i] * scale(i));
        let found = solve_small(&matrix, &right)?;
        Some(std::array::from_fn(|i| found[i] * scale(i)))
    }

    /// Sum of squared residuals.
    fn residual(&self, x: &[f64; P]) -> f64 {
        let mut sum = self.square;
        for i in 0..P {
            sum -= 2.0 * x[i] * self.right[i];
            for j in 0..P {
                sum += x[i] * self.matrix[i][j] * x[j];
            }
        }
        sum.max(0.0)
    }
}

/// What the other columns leave of one's square.
pub(crate) fn left_alone<const P: usize>(
    sums: &[[f64; P]; P],
    column: usize,
    used: &[bool; P],
) -> f64 {
    let own = sums[column][column];
    let is_other = |i: usize| i != column && used[i];
    let matrix: [[f64; P]; P] = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            if is_other(i) && is_other(j) {
                sums[i][j]
            } else {
                f64::from(u8::from(i == j))
            }
        })
    });
    let with: [f64; P] = std::array::from_fn(|i| if is_other(i) { sums[i][column] } else { 0.0 });
    // None where the others are one another.
    solve_small(&matrix, &with).map_or(0.0, |parts| {
        let explained: f64 = parts.iter().zip(&with).map(|(p, w)| p * w).sum();
        own - explained
    })
}

/// Rows of a linear problem, summed by blocks.
#[derive(Clone)]
pub(crate) struct Squares<const P: usize> {
    blocks: Vec<Sums<P>>,
    per_block: usize,
}

/// What least squares found.
pub(crate) struct SquaresFit<const P: usize> {
    pub(crate) x: [f64; P],
    pub(crate) figures: [Figure; P],
    /// Coefficients without each block.
    pub(crate) without: Vec<[f64; P]>,
    /// Root mean square of the residuals.
    pub(crate) rms: f64,
    /// The same of the target.
    pub(crate) target_rms: f64,
    pub(crate) rows: usize,
}

impl<const P: usize> Squares<P> {
    /// For about this many places in the log.
    pub(crate) fn new(places: usize) -> Squares<P> {
        Squares {
            blocks: vec![Sums::ZERO; BLOCKS],
            per_block: places.div_ceil(BLOCKS).max(1),
        }
    }

    /// The part of a column's square that the others which are used leave.
    pub(crate) fn left_of(&self, column: usize, used: &[bool; P]) -> f64 {
        let mut all = Sums::ZERO;
        self.blocks.iter().for_each(|block| all.add(block, 1.0));
        let own = all.matrix[column][column];
        if own > 0.0 {
            left_alone(&all.matrix, column, used) / own
        } else {
            0.0
        }
    }

    /// Adds the row of one place.
    pub(crate) fn add(&mut self, place: usize, row: [f64; P], target: f64) {
        let block = (place / self.per_block).min(BLOCKS - 1);
        let sums = &mut self.blocks[block];
        for i in 0..P {
            for j in 0..P {
                sums.matrix[i][j] += row[i] * row[j];
            }
            sums.right[i] += row[i] * target;
        }
        sums.square += target * target;
        sums.rows += 1.0;
    }

    /// Takes the noise of columns out of the sums, by its variance in a row: noise in a measured column makes
    /// its coefficient too small (errors in variables). No column loses more than a part of its square.
    pub(crate) fn without_noise(&mut self, columns: &[(usize, f64)]) {
        let sum = |of: &dyn Fn(&Sums<P>) -> f64| self.blocks.iter().map(of).sum::<f64>();
        let rows = sum(&|block| block.rows);
        let part = columns
            .iter()
            .filter(|(_, variance)| *variance > 0.0)
            .map(|&(at, variance)| {
                MOST_NOISE * sum(&|block| block.matrix[at][at]) / (rows * variance)
            })
            .fold(1.0, f64::min);
        for block in &mut self.blocks {
            for &(at, variance) in columns {
                block.matrix[at][at] -= part * variance * block.rows;
            }
        }
    }

    /// Root mean squares of the columns.
    pub(crate) fn sizes(&self) -> [f64; P] {
        let sum = |of: &dyn Fn(&Sums<P>) -> f64| self.blocks.iter().map(of).sum::<f64>();
        let rows = sum(&|block| block.rows);
        std::array::from_fn(|at| (sum(&|block| block.matrix[at][at]) / rows).sqrt())
    }

    /// Solves for the columns that are used; `None` where the rows do not tell them.
    pub(crate) fn solve(&self, used: &[bool; P]) -> Option<SquaresFit<P>> {
        let mut whole = Sums::ZERO;
        self.blocks.iter().for_each(|block| whole.add(block, 1.0));
        let x = whole.solve(used)?;
        let mut without = Vec::new();
        for block in self.blocks.iter().filter(|block| block.rows > 0.0) {
            let mut rest = whole;
            rest.add(block, -1.0);
            without.push(rest.solve(used)?);
        }
        if without.len() < 3 {
            return None;
        }
        let figures =
            std::array::from_fn(|i| jackknife(x[i], without.iter().map(|other| other[i])));
        Some(SquaresFit {
            x,
            figures,
            rms: (whole.residual(&x) / whole.rows).sqrt(),
            target_rms: (whole.square / whole.rows).sqrt(),
            rows: whole.rows as usize,
            without,
        })
    }
}

impl<const P: usize> SquaresFit<P> {
    /// Widens the intervals by as much as what other choices find is off.
    pub(crate) fn widen_to(&mut self, others: &[[f64; P]]) {
        for (at, figure) in self.figures.iter_mut().enumerate() {
            let off = others.iter().map(|other| (figure.value - other[at]).abs());
            *figure = figure.widened(off.fold(0.0, f64::max));
        }
    }
}

/// A figure from its values without each block in turn.
///
/// Where few blocks hold most of what tells a figure, as few slow strokes do of friction at small
/// speeds, the scatter has as few degrees of freedom. How many is told by how unevenly the blocks
/// pull: the fourth powers of normal deviations are three times the square of their variance.
pub(crate) fn jackknife(value: f64, without: impl Iterator<Item = f64> + Clone) -> Figure {
    let count = without.clone().count() as f64;
    let mean = without.clone().sum::<f64>() / count;
    let squares = without.map(|other| (other - mean) * (other - mean));
    let scatter: f64 = squares.clone().sum();
    let fourths: f64 = squares.map(|square| square * square).sum();
    let error = ((count - 1.0) / count * scatter).sqrt();
    let even = 3.0 * scatter * scatter / fourths;
    let freedom = if even.is_finite() {
        (even - 1.0).clamp(1.0, count - 1.0)
    } else {
        count - 1.0
    };
    let half = student_975(freedom) * error;
    Figure {
        value,
        error,
        interval: [value - half, value + half],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_base::random::Random;

    /// The interval holds the truth in 90 to 99 of 100 draws.
    #[test]
    fn intervals_cover() {
        let mut random = Random::new(7_180_001);
        let mut held = 0;
        for _ in 0..400 {
            let mut squares = Squares::<2>::new(400);
            for place in 0..400 {
                let x = random.normal();
                squares.add(place, [x, 1.0], 3.0 * x + 1.0 + 0.5 * random.normal());
            }
            let found = squares.solve(&[true, true]).unwrap();
            let [low, high] = found.figures[0].interval;
            held += i32::from((low..high).contains(&3.0));
        }
        assert!((360..=396).contains(&held), "{held} of 400");
    }

    #[test]
    fn columns_that_are_not_told_are_refused() {
        let mut squares = Squares::<2>::new(100);
        (0..100).for_each(|place| squares.add(place, [2.0, 2.0], 1.0));
        assert!(squares.solve(&[true, true]).is_none());
        assert!(squares.solve(&[true, false]).is_some());
    }
}
