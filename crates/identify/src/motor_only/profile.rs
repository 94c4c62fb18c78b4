//! Uncertainty of a coefficient once the crossings' own constants are eliminated and the priors are
//! accounted for.

use lostmotion_base::vec::dot;

use crate::huber::{NormalEquations, Piece, Regression};

use super::program::{LOCAL, Projected, Solved};
use super::uncertainty::Prior;

/// Added to the diagonal of normal equations of orthonormal columns, so that an empty column has
/// the solution zero. A choice: far below 1, far above rounding.
const RIDGE: f64 = 1e-9;

impl<const P: usize> Projected<P> {
    /// Standard deviation of the coefficient `which` due to the uncertainty of the priors; `None`
    /// where the equations do not determine it.
    pub(super) fn prior_deviation(
        &self,
        profiled: &Regression<P>,
        solved: &Solved<P>,
        delta: f64,
        priors: &[Prior],
        which: usize,
    ) -> Option<f64> {
        // Curvature of the loss at the solution; its inverse tells how each equation moves it.
        let mut normal = NormalEquations::<P>::default();
        for (k, row) in profiled.rows.iter().enumerate() {
            let residual = profiled.residual(k, &solved.x) / delta;
            normal.add(row, residual, Piece::of(residual));
        }
        let influence = crate::huber::solve_small(
            &normal.matrix,
            &std::array::from_fn(|j| f64::from(u8::from(j == which))),
        )?;
        let rows = self.regression.rows.iter().skip(self.equations);
        // Shift where a prior is wrong by its own standard deviation; independent, so
        // their squares add up.
        let shifts = rows.zip(priors).map(|(row, prior)| {
            influence[prior.column] * row[prior.column] * row[prior.column] * prior.deviation
        });
        Some(shifts.map(|shift| shift * shift).sum::<f64>().sqrt())
    }

    /// The regression with the crossings' own constants taken out as the loss weighs them, its
    /// residuals those of the solve: what [`crate::spread`] needs.
    pub(super) fn profiled(&self, solved: &Solved<P>, delta: f64) -> Regression<P> {
        let mut rows = self.regression.rows.clone();
        let mut first = 0;
        // Crossing by crossing: equations in the square part determine its constants.
        for run in self.segment.chunk_by(|a, b| a == b) {
            let range = first..first + run.len();
            let inner: Vec<bool> = solved.residuals[range.clone()]
                .iter()
                .map(|r| r.abs() <= delta)
                .collect();
            profile(&mut rows[range.clone()], &self.local[range], &inner);
            first += run.len();
        }
        // a prior that the log contradicts is still what holds its coefficient
        let shown = |k: usize| {
            if k < self.equations {
                solved.residuals[k]
            } else {
                solved.residuals[k].clamp(-delta, delta)
            }
        };
        // Targets that give these residuals at the solution.
        let targets = rows
            .iter()
            .enumerate()
            .map(|(k, row)| shown(k) + dot(*row, solved.x))
            .collect();
        Regression {
            rows,
            targets,
            nonnegative: self.regression.nonnegative,
        }
    }
}

/// Takes local columns out of rows by least squares over the inner equations.
fn profile<const P: usize>(rows: &mut [[f64; P]], local: &[[f64; LOCAL]], inner: &[bool]) {
    // Normal equations of the local columns, regularised where a crossing has fewer constants.
    let mut normal = [[0.0; LOCAL]; LOCAL];
    for (l, _) in local.iter().zip(inner).filter(|(_, inner)| **inner) {
        for (i, line) in normal.iter_mut().enumerate() {
            line.iter_mut()
                .zip(l)
                .for_each(|(entry, b)| *entry += l[i] * b);
        }
    }
    for (i, line) in normal.iter_mut().enumerate() {
        line[i] += RIDGE;
    }
    for j in 0..P {
        // What a common column has of the local ones is taken out of it.
        let right: [f64; LOCAL] = std::array::from_fn(|i| {
            rows.iter()
                .zip(local)
                .zip(inner)
                .filter(|(_, inner)| **inner)
                .map(|((row, l), _)| l[i] * row[j])
                .sum()
        });
        if let Some(shares) = crate::huber::solve_small(&normal, &right) {
            rows.iter_mut()
                .zip(local)
                .for_each(|(row, l)| row[j] -= dot(shares, *l));
        }
    }
}
