//! Square matrices whose size is known at run time: product, exponential, spectral radius.
//!
//! For a handful of states; [`crate::linalg`] has the solvers of fixed size.
//!
//! ```
//! use lostmotion_base::matrix::SquareMatrix;
//!
//! let mut decay = SquareMatrix::zero(2);
//! decay.set(0, 0, -1.0);
//! decay.set(1, 1, -2.0);
//! let step = decay.exponential();
//! assert!((step.get(0, 0) - 0.36787944117144233).abs() < 1e-15);
//! assert!((step.spectral_radius() - step.get(0, 0)).abs() < 1e-10);
//! ```

use crate::math;

/// A square matrix, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct SquareMatrix {
    size: usize,
    entries: Vec<f64>,
}

impl SquareMatrix {
    /// All entries 0.
    pub fn zero(size: usize) -> SquareMatrix {
        SquareMatrix {
            size,
            entries: vec![0.0; size * size],
        }
    }

    /// 1 on the diagonal, 0 elsewhere.
    pub fn identity(size: usize) -> SquareMatrix {
        let mut out = SquareMatrix::zero(size);
        for i in 0..size {
            out.set(i, i, 1.0);
        }
        out
    }

    /// Rows, which are as many as columns.
    pub fn size(&self) -> usize {
        self.size
    }

    /// An entry; both places are below [`SquareMatrix::size`].
    pub fn get(&self, row: usize, column: usize) -> f64 {
        self.entries[row * self.size + column]
    }

    /// Sets an entry; both places are below [`SquareMatrix::size`].
    pub fn set(&mut self, row: usize, column: usize, value: f64) {
        self.entries[row * self.size + column] = value;
    }

    /// The entries of a row, which is below [`SquareMatrix::size`].
    pub fn row(&self, row: usize) -> &[f64] {
        &self.entries[row * self.size..(row + 1) * self.size]
    }

    /// Every entry times a factor.
    pub fn scaled(mut self, factor: f64) -> SquareMatrix {
        self.entries.iter_mut().for_each(|entry| *entry *= factor);
        self
    }

    /// `self` times `other`, which is of the same size.
    pub fn product(&self, other: &SquareMatrix) -> SquareMatrix {
        let mut out = SquareMatrix::zero(self.size);
        for (target, row) in out
            .entries
            .chunks_mut(self.size.max(1))
            .zip(self.entries.chunks(self.size.max(1)))
        {
            for (factor, other_row) in row.iter().zip(other.entries.chunks(self.size.max(1))) {
                for (sum, entry) in target.iter_mut().zip(other_row) {
                    *sum += factor * entry;
                }
            }
        }
        out
    }

    /// Largest sum of magnitudes in a row; not a number if an entry is not.
    fn norm(&self) -> f64 {
        let rows = self
            .entries
            .chunks(self.size.max(1))
            .map(|row| row.iter().map(|entry| entry.abs()).sum());
        rows.fold(0.0, |largest: f64, sum: f64| {
            if sum > largest || sum.is_nan() {
                sum
            } else {
                largest
            }
        })
    }

    /// `exp(self)` by scaling, 20 Taylor terms and squaring.
    pub fn exponential(&self) -> SquareMatrix {
        let mut squarings = 0;
        let mut scale = 1.0;
        // Scaling: a small norm makes the series converge fast.
        while self.norm() * scale > 0.5 && squarings < 60 {
            scale *= 0.5;
            squarings += 1;
        }
        let step = self.clone().scaled(scale);
        let mut term = SquareMatrix::identity(self.size);
        let mut sum = term.clone();
        // Taylor: the term is step^n / n!.
        for n in 1..=20_u32 {
            term = term.product(&step).scaled(1.0 / f64::from(n));
            for (total, entry) in sum.entries.iter_mut().zip(&term.entries) {
                *total += entry;
            }
        }
        // Squaring takes the scale back: exp(2 A) = exp(A)^2.
        (0..squarings).fold(sum, |power, _| power.product(&power))
    }

    /// Largest magnitude of an eigenvalue: `|A^m|^(1/m)` for m = 2^36, by squaring. What is not a
    /// number counts as infinite.
    pub fn spectral_radius(&self) -> f64 {
        let mut power = self.clone().balanced();
        let (mut log, mut weight) = (0.0, 1.0);
        for _ in 0..=36 {
            let norm = power.norm();
            if norm == 0.0 {
                return 0.0;
            }
            if !norm.is_finite() {
                return f64::INFINITY;
            }
            // log |A^m| / m, summed up from the norms that are divided out before each squaring.
            log += weight * math::log(norm);
            weight *= 0.5;
            power = power.scaled(1.0 / norm);
            power = power.product(&power);
        }
        math::exp(log)
    }

    /// A similar matrix whose rows and columns are alike in size (Osborne's iteration, powers of
    /// two): states in A, V and rad side by side would otherwise cost digits.
    fn balanced(mut self) -> SquareMatrix {
        for _ in 0..20 {
            let mut changed = false;
            for i in 0..self.size {
                // Row and column off the diagonal are brought to the same sum; powers of two do not
                // round.
                let others = || (0..self.size).filter(|j| *j != i);
                let row: f64 = others().map(|j| self.get(i, j).abs()).sum();
                let column: f64 = others().map(|j| self.get(j, i).abs()).sum();
                if row > 0.0 && column > 0.0 {
                    let factor = math::exp2((0.5 * math::log2(row / column)).round());
                    changed |= factor != 1.0;
                    for j in 0..self.size {
                        self.set(j, i, self.get(j, i) * factor);
                        self.set(i, j, self.get(i, j) / factor);
                    }
                }
            }
            if !changed {
                break;
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of<const N: usize>(rows: [[f64; N]; N]) -> SquareMatrix {
        SquareMatrix {
            size: N,
            entries: rows.concat(),
        }
    }

    #[test]
    fn spectral_radius_of_known_matrices() {
        let rotation = of([[0.6, -0.8], [0.8, 0.6]]);
        assert!((rotation.spectral_radius() - 1.0).abs() < 1e-10);
        // defective, and in very different units
        assert!((of([[0.9, 1e9], [0.0, 0.9]]).spectral_radius() - 0.9).abs() < 1e-8);
        // companion matrix of (z - 0.5)(z + 1.25)(z - 0.2)
        let companion = of([[-0.55, 0.775, -0.125], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert!((companion.spectral_radius() - 1.25).abs() < 1e-10);
        assert_eq!(of([[0.0, 1.0], [0.0, 0.0]]).spectral_radius(), 0.0);
        assert_eq!(of([[f64::NAN]]).spectral_radius(), f64::INFINITY);
    }

    #[test]
    fn exponential_of_a_damped_rotation() {
        let e = of([[-0.3, 7.0], [-7.0, -0.3]]).exponential();
        let scale = math::exp(-0.3);
        assert!((e.get(0, 0) - scale * math::cos(7.0)).abs() < 1e-13);
        assert!((e.get(0, 1) - scale * math::sin(7.0)).abs() < 1e-13);
    }
}
