//! Linear algebra of the sizes that the project needs: banded and small dense systems, and the
//! exponential of a small matrix.
//!
//! ```
//! use lostmotion_base::linalg::{cholesky, cholesky_solve};
//!
//! // The lower half is read: [[4, 2], [2, 5]] x = [10, 9]
//! let factor = cholesky(&[[4.0, 0.0], [2.0, 5.0]], 0.0);
//! assert_eq!(cholesky_solve(&factor, &[10.0, 9.0]), [2.0, 1.0]);
//! ```

/// A square matrix, row by row.
pub type Matrix<const N: usize> = [[f64; N]; N];

/// Solves a symmetric positive definite banded system by LDL', for `N` right sides at once.
///
/// Row `i` holds the entries `(i, i)`, `(i, i + 1)` up to `(i, i + W - 1)`; entries beyond the last
/// column are not read. The factors are left in `rows` and the solutions in `x`. One right side is
/// divided by the pivots; several are multiplied by one reciprocal.
#[inline]
pub fn solve_banded<const W: usize, const N: usize>(rows: &mut [[f64; W]], x: &mut [[f64; N]]) {
    // Rows and right sides come in pairs; a surplus of either stays as it is.
    let n = rows.len().min(x.len());
    let (rows, x) = (&mut rows[..n], &mut x[..n]);
    // Elimination: each row takes its multiples from the W - 1 rows below it.
    for i in 0..n {
        if let (Some(rows), Some(x)) = (
            rows[i..].first_chunk_mut::<W>(),
            x[i..].first_chunk_mut::<W>(),
        ) {
            // The same with lengths that are known, which takes half of the time.
            eliminate(rows, x);
        } else {
            eliminate(&mut rows[i..], &mut x[i..]);
        }
    }
    // Substitution from the last row to the first.
    for i in (0..n).rev() {
        let row = rows[i];
        // The diagonal D: the unknown but for what L' brings in from below.
        let mut value = if N == 1 {
            x[i].map(|x| x / row[0])
        } else {
            let pivot = 1.0 / row[0];
            x[i].map(|x| x * pivot)
        };
        for (k, factor) in row.iter().enumerate().skip(1) {
            if let Some(below) = x.get(i + k) {
                subtract(&mut value, below, *factor);
            }
        }
        x[i] = value;
    }
}

/// Takes the multiples of the first row from those below it.
#[inline(always)]
fn eliminate<const W: usize, const N: usize>(rows: &mut [[f64; W]], x: &mut [[f64; N]]) {
    let (row, above) = (rows[0], x[0]);
    for k in 1..W.min(rows.len()) {
        // The multiplier L(i + k, i); the row below is left with its entries of the Schur
        // complement.
        let factor = row[k] / row[0];
        rows[0][k] = factor;
        for (entry, right) in rows[k].iter_mut().zip(&row[k..]) {
            *entry -= factor * right;
        }
        // The forward substitution of the right sides goes along.
        subtract(&mut x[k], &above, factor);
    }
}

#[inline]
fn subtract<const N: usize>(from: &mut [f64; N], what: &[f64; N], factor: f64) {
    for (from, what) in from.iter_mut().zip(what) {
        *from -= factor * what;
    }
}

/// Cholesky factor L of a symmetric matrix given by its lower half: `a = L L'`.
///
/// Pivots below `least_pivot` are raised to it, so that a direction that is not determined gets a
/// finite solution. With 0 the factor of an indefinite matrix has entries that are not finite.
#[inline]
pub fn cholesky<const N: usize>(a: &Matrix<N>, least_pivot: f64) -> Matrix<N> {
    let mut l = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..i {
            // Off the diagonal: the part of a(i, j) that the columns to the left leave, over their
            // pivot.
            let sum: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            l[i][j] = (a[i][j] - sum) / l[j][j];
        }
        // The pivot: rounding, or a direction that is not determined, can take it to zero or below.
        let sum: f64 = (0..i).map(|k| l[i][k] * l[i][k]).sum();
        l[i][i] = (a[i][i] - sum).max(least_pivot).sqrt();
    }
    l
}

/// Solves `L L' x = right` with a factor of [`cholesky`].
#[inline]
pub fn cholesky_solve<const N: usize>(l: &Matrix<N>, right: &[f64; N]) -> [f64; N] {
    let mut x = [0.0; N];
    // Forward with L, then backward with its transpose.
    for i in 0..N {
        let sum: f64 = (0..i).map(|k| l[i][k] * x[k]).sum();
        x[i] = (right[i] - sum) / l[i][i];
    }
    for i in (0..N).rev() {
        let sum: f64 = (i + 1..N).map(|k| l[k][i] * x[k]).sum();
        x[i] = (x[i] - sum) / l[i][i];
    }
    x
}

/// Product of two matrices; entries of `a` that are 0 are skipped.
#[inline]
pub fn product<const N: usize>(a: &Matrix<N>, b: &Matrix<N>) -> Matrix<N> {
    let mut out = [[0.0; N]; N];
    for (row, a_row) in out.iter_mut().zip(a) {
        for (b_row, &factor) in b.iter().zip(a_row) {
            if factor == 0.0 {
                continue;
            }
            for (entry, &b_entry) in row.iter_mut().zip(b_row) {
                *entry += factor * b_entry;
            }
        }
    }
    out
}

/// Terms of the series of [`expm`]. Derived: at a norm of 1 the first one left out is 1/25! =
/// 6e-26, far below the last digit of a sum of about 1.
const EXPM_TERMS: u32 = 24;
/// Most squarings of [`expm`]: a time 2^40 times that of the series. A choice: no plant is that
/// stiff over a period of a loop, and an infinite rate must not loop for ever.
const MAX_EXPM_SQUARINGS: u32 = 40;

/// `exp(a * time)` by Taylor's series with scaling and squaring.
///
/// `rate` bounds the norm of `a` in units in which its entries are balanced. The series converges
/// as in those units whatever units the entries are in, so a shaft in rad and a current in A need
/// no more squarings than their physics asks for.
pub fn expm<const N: usize>(a: &Matrix<N>, time: f64, rate: f64) -> Matrix<N> {
    // Scaling: halve the time until the series converges fast.
    let mut squarings = 0;
    let mut step = time;
    while rate * step > 1.0 && squarings < MAX_EXPM_SQUARINGS {
        step *= 0.5;
        squarings += 1;
    }
    // Taylor: the term is (a step)^n / n!, from the identity on.
    let mut term = [[0.0; N]; N];
    for (i, row) in term.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    let mut sum = term;
    for n in 1..=EXPM_TERMS {
        term = product(&term, a);
        let factor = step / f64::from(n);
        for (term_row, sum_row) in term.iter_mut().zip(&mut sum) {
            for (t, s) in term_row.iter_mut().zip(sum_row) {
                *t *= factor;
                *s += *t;
            }
        }
    }
    // Squaring doubles the time: exp(2 a t) = exp(a t)^2.
    for _ in 0..squarings {
        sum = product(&sum, &sum);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    #[test]
    fn a_banded_solution_solves() {
        let entry = |i: usize, k: usize| match i.abs_diff(k) {
            0 => 5.0 + i as f64,
            1 => -1.0 - 0.1 * i.min(k) as f64,
            2 => 0.7,
            _ => 0.0,
        };
        for n in [1, 2, 3, 7] {
            let rows: Vec<[f64; 3]> = (0..n)
                .map(|i| [entry(i, i), entry(i, i + 1), entry(i, i + 2)])
                .collect();
            let right: Vec<f64> = (0..n).map(|i| 1.0 - 0.3 * i as f64).collect();
            let mut one: Vec<[f64; 1]> = right.iter().map(|x| [*x]).collect();
            let mut two: Vec<[f64; 2]> = right.iter().map(|x| [*x, -2.0 * x]).collect();
            solve_banded(&mut rows.clone(), &mut one);
            solve_banded(&mut rows.clone(), &mut two);
            for (i, right) in right.iter().enumerate() {
                let product: f64 = (0..n).map(|k| entry(i, k) * one[k][0]).sum();
                assert!((product - right).abs() < 1e-12);
                assert!((two[i][0] - one[i][0]).abs() < 1e-15);
                assert!((two[i][1] + 2.0 * one[i][0]).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn a_factor_solves_what_was_multiplied() {
        let a = [
            [4.0, 1.0, 0.0, 0.5],
            [1.0, 3.0, 0.2, 0.0],
            [0.0, 0.2, 2.0, 0.1],
            [0.5, 0.0, 0.1, 1.0],
        ];
        let wanted = [1.0, -2.0, 0.5, 3.0];
        let right = a.map(|row| row.iter().zip(wanted).map(|(a, x)| a * x).sum::<f64>());
        let found = cholesky_solve(&cholesky(&a, 1e-14), &right);
        for (x, wanted) in found.into_iter().zip(wanted) {
            assert!((x - wanted).abs() < 1e-12, "{x} {wanted}");
        }
        // a direction that is not determined stays finite
        let singular = cholesky(&[[1.0, 1.0], [1.0, 1.0]], 1e-14);
        assert!(
            cholesky_solve(&singular, &[1.0, 1.0])
                .iter()
                .all(|x| x.is_finite())
        );
    }

    #[test]
    fn rotation_and_decay_have_their_closed_forms() {
        let (omega, decay, time) = (700.0, 30.0, 0.01);
        let a = [[-decay, omega], [-omega, -decay]];
        let e = expm(&a, time, 800.0);
        let (scale, angle) = (math::exp(-decay * time), omega * time);
        assert!((e[0][0] - scale * math::cos(angle)).abs() < 1e-14);
        assert!((e[0][1] - scale * math::sin(angle)).abs() < 1e-14);
        assert!((e[1][0] + scale * math::sin(angle)).abs() < 1e-14);
    }

    #[test]
    fn a_shift_stays_exact() {
        // coasting: position' = speed; squaring must not disturb the unit entries
        let e = expm(&[[0.0, 1.0], [0.0, 0.0]], 5e-5, 1e6);
        assert_eq!(e, [[1.0, 5e-5], [0.0, 1.0]]);
    }
}
