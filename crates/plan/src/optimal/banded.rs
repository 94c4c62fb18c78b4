//! A symmetric positive definite matrix with two diagonals beside the main one.

/// The matrix by its diagonals, factored in place as L D L'.
#[derive(Clone, Debug, Default)]
pub(super) struct Banded {
    /// Main diagonal, first and second diagonal below it: row `i` has the entries at `i`, `i - 1`
    /// and `i - 2`.
    rows: Vec<[f64; 3]>,
}

impl Banded {
    /// A matrix of zeros.
    pub(super) fn reset(&mut self, size: usize) {
        self.rows.clear();
        self.rows.resize(size, [0.0; 3]);
    }

    /// Adds to the main diagonal.
    pub(super) fn add_diagonal(&mut self, row: usize, value: f64) {
        self.rows[row][0] += value;
    }

    /// Adds a symmetric block over three consecutive unknowns from `first`: entries 00, 10, 11, 20,
    /// 21, 22.
    pub(super) fn add_block(&mut self, first: usize, block: &[f64; 6]) {
        let [a, b, c] = &mut self.rows[first..first + 3] else {
            return;
        };
        a[0] += block[0];
        b[0] += block[2];
        b[1] += block[1];
        c[0] += block[5];
        c[1] += block[4];
        c[2] += block[3];
    }

    /// Makes an unknown equal to the one after it, whose row takes over all of its couplings.
    pub(super) fn tie_up(&mut self, row: usize) {
        // With x[row] = x[row + 1] both rows add up, and their coupling counts twice on the
        // diagonal.
        let [diagonal, ..] = self.rows[row];
        let first = self.rows[row + 1][1];
        let second = self.rows.get(row + 2).map_or(0.0, |next| next[2]);
        self.rows[row + 1][0] += diagonal + 2.0 * first;
        if let Some(next) = self.rows.get_mut(row + 2) {
            next[1] += second;
        }
        self.isolate(row);
    }

    /// Makes an unknown equal to the one before it.
    pub(super) fn tie_down(&mut self, row: usize) {
        let [diagonal, first, second] = self.rows[row];
        self.rows[row - 1][0] += diagonal + 2.0 * first;
        self.rows[row - 1][1] += second;
        self.isolate(row);
    }

    /// Makes an unknown independent of all others.
    pub(super) fn isolate(&mut self, row: usize) {
        self.rows[row] = [1.0, 0.0, 0.0];
        if let Some(next) = self.rows.get_mut(row + 1) {
            next[1] = 0.0;
        }
        if let Some(next) = self.rows.get_mut(row + 2) {
            next[2] = 0.0;
        }
    }

    /// Solves for `x` in place of the right side and leaves the factors behind.
    pub(super) fn solve(&mut self, x: &mut [f64]) {
        // L has ones on its diagonal; the two rows before are kept as (pivot, first subdiagonal of
        // L).
        let (mut before, mut last) = ([1.0, 0.0], [1.0, 0.0]);
        let (mut x_before, mut x_last) = (0.0, 0.0);
        for (row, x) in self.rows.iter_mut().zip(x.iter_mut()) {
            let l2 = row[2] / before[0];
            let l1 = (row[1] - l2 * before[0] * last[1]) / last[0];
            let pivot = row[0] - l1 * l1 * last[0] - l2 * l2 * before[0];
            *row = [pivot, l1, l2];
            *x -= l1 * x_last + l2 * x_before;
            (before, last) = (last, [pivot, l1]);
            (x_before, x_last) = (x_last, *x);
        }
        // Back substitution with the two unknowns below.
        let [mut next, mut after] = [(0.0, [0.0; 3]); 2];
        for (row, x) in self.rows.iter().zip(x.iter_mut()).rev() {
            let ((x1, [_, l1, _]), (x2, [_, _, l2])) = (next, after);
            *x = *x / row[0] - l1 * x1 - l2 * x2;
            (next, after) = ((*x, *row), next);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The product of a random matrix with a known vector gives the vector back.
    #[test]
    fn it_solves() {
        let mut generator = lostmotion_base::Random::new(1);
        let mut random = || generator.between(-0.5, 0.5);
        for size in [3, 4, 7, 60] {
            let mut matrix = Banded::default();
            matrix.reset(size);
            for first in 0..size - 2 {
                let a = [random(), random(), random()];
                matrix.add_block(
                    first,
                    &[
                        a[0] * a[0],
                        a[1] * a[0],
                        a[1] * a[1],
                        a[2] * a[0],
                        a[2] * a[1],
                        a[2] * a[2],
                    ],
                );
            }
            (0..size).for_each(|i| matrix.add_diagonal(i, 0.1));
            matrix.isolate(1);
            let known: Vec<f64> = (0..size).map(|_| random()).collect();
            let mut product = vec![0.0; size];
            for i in 0..size {
                for (k, entry) in matrix.rows[i].iter().enumerate().filter(|(k, _)| *k <= i) {
                    product[i] += entry * known[i - k];
                    if k > 0 {
                        product[i - k] += entry * known[i];
                    }
                }
            }
            matrix.solve(&mut product);
            let worst = product
                .iter()
                .zip(&known)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(worst < 1e-12, "{size}: {worst}");
        }
    }
}
