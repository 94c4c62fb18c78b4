//! The system of a step: symmetric, positive definite, banded.
//!
//! A coefficient has a row for each axis, with the columns of its own axes and of those of the three
//! coefficients that follow it. Columns lie where their coefficient's number is modulo four: what one row
//! takes from another lies at the same place in both, so that vectors hold it as it is.

use crate::condition::tube::spline::ORDER;
use pulp::Simd;

/// Columns of a coefficient: of its axes, and as many more as vectors hold.
pub(super) type Columns<const M: usize> = [f64; M];

/// A row.
pub(super) type SystemRow<const M: usize> = [Columns<M>; ORDER];

/// Solves it by LDL', given the number of the first coefficient, all rows and right sides, and three
/// coefficients more of each, in which anything may be. The factors are left in `rows` and the solution in
/// `x`.
#[inline(always)]
pub(super) fn solve<S: Simd, const N: usize, const M: usize>(
    simd: S,
    first: usize,
    rows: &mut [[SystemRow<M>; N]],
    x: &mut [[f64; N]],
) {
    let n = x.len() + 1 - ORDER;
    // Elimination: each coefficient's rows take their multiples from the rows below them.
    for c in 0..n {
        let (Some([own, below @ ..]), Some([right, rights @ ..])) = (
            rows[c..].first_chunk_mut::<ORDER>(),
            x[c..].first_chunk_mut::<ORDER>(),
        ) else {
            return;
        };
        let at = |k: usize| (first + c + k) % ORDER;
        for i in 0..N {
            let pivot = own[i][at(0)][i];
            // The multipliers that the row gives take its place at last.
            let mut lower = [[0.0; M]; ORDER];
            for (lower, columns) in lower.iter_mut().zip(&own[i]) {
                for (factor, entry) in lower.iter_mut().zip(columns) {
                    *factor = entry / pivot;
                }
            }
            for t in i + 1..N {
                let factor = lower[at(0)][t];
                let (done, rest) = own.split_at_mut(t);
                for (from, columns) in rest[0].iter_mut().zip(&done[i]) {
                    subtract(simd, from, factor, columns);
                }
                right[t] -= factor * right[i];
            }
            for k in 1..ORDER {
                for t in 0..N {
                    let factor = lower[at(k)][t];
                    for q in k..ORDER {
                        subtract(simd, &mut below[k - 1][t][at(q)], factor, &own[i][at(q)]);
                    }
                    rights[k - 1][t] -= factor * right[i];
                }
            }
            own[i] = lower;
            own[i][at(0)][i] = pivot;
        }
    }
    // Substitution from the last row to the first; beyond all there is nothing.
    x[n..].fill([0.0; N]);
    for c in (0..n).rev() {
        let at = (first + c) % ORDER;
        for i in (0..N).rev() {
            let row = &rows[c][i];
            // The diagonal D: the unknown but for what L' brings in from below.
            let mut value = x[c][i] / row[at][i];
            for t in i + 1..N {
                value -= row[at][t] * x[c][t];
            }
            for k in 1..ORDER {
                let (row, x) = (&row[(at + k) % ORDER], &x[c + k]);
                for (factor, x) in row.iter().zip(x) {
                    value -= factor * x;
                }
            }
            x[c][i] = value;
        }
    }
}

#[inline(always)]
fn subtract<S: Simd, const M: usize>(
    simd: S,
    from: &mut Columns<M>,
    factor: f64,
    columns: &Columns<M>,
) {
    if M.is_multiple_of(S::F64_LANES) {
        let factor = simd.splat_f64s(factor);
        let entries = S::as_mut_simd_f64s(from).0;
        for (entry, right) in entries.iter_mut().zip(S::as_simd_f64s(columns).0) {
            *entry = simd.sub_f64s(*entry, simd.mul_f64s(factor, *right));
        }
    } else {
        for (entry, right) in from.iter_mut().zip(columns) {
            *entry -= factor * right;
        }
    }
}
