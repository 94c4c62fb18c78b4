//! The quadratic program around a centre.

use super::Regression;
use super::normal::{Normal, Piece};
use crate::solver::{QuadraticProgram, SparseColumns};

/// Variables: step `d` (P), then for each explicit sample its square part `u`, its excess above
/// `v >= 0` and below `w >= 0` with `a d + u + v - w = r`, `r` the residual at the centre; loss
/// `u^2/2 + v + w`. The other samples add `d'Hd/2 - h'd`. A coefficient that is `bounded` keeps
/// centre plus step from falling below zero.
///
/// The step is in units of `1/sqrt(samples)`, the size that steps have, so that `H` does not
/// outgrow the explicit samples. Returns the program and the unit of its first variables.
pub(super) fn build<const P: usize>(
    data: &Regression<P>,
    pieces: &[Piece],
    centre: &[f64; P],
    bounded: &[bool; P],
) -> (QuadraticProgram, f64) {
    let explicit: Vec<usize> = (0..pieces.len())
        .filter(|&k| pieces[k] == Piece::Explicit)
        .collect();
    let count = explicit.len();
    let unit = 1.0 / (data.rows.len().max(1) as f64).sqrt();
    // Samples that are summed up: a quadratic form and a linear one in the step.
    let summed = Normal::of_pieces(data, pieces, centre);
    let bounded: Vec<usize> = (0..P).filter(|&j| bounded[j]).collect();
    // Rows: one equation per explicit sample, then the bounds, then v >= 0 and w >= 0.
    let (variables, rows) = (P + 3 * count, count + bounded.len() + 2 * count);
    let first_excess_row = count + bounded.len();

    let mut quadratic = SparseColumns::new(variables);
    // Objective: H of the summed samples on d, 1 on each u, nothing on v and w.
    for j in 0..P {
        quadratic.push_column((0..=j).map(|i| (i, unit * unit * summed.matrix[i][j])));
    }
    (0..count).for_each(|n| quadratic.push_column([(P + n, 1.0)]));
    (0..2 * count).for_each(|_| quadratic.push_column([]));

    let mut constraints = SparseColumns::new(rows);
    // Columns of d: its part of each residual, and minus one in the row of its bound.
    for j in 0..P {
        let slopes = explicit
            .iter()
            .enumerate()
            .map(|(row, &k)| (row, unit * data.rows[k][j]));
        let bound = bounded
            .iter()
            .position(|&b| b == j)
            .map(|n| (count + n, -1.0));
        constraints.push_column(slopes.chain(bound));
    }
    // Columns of u, v and w: u + v - w in the sample's equation, -v <= 0 and -w <= 0.
    (0..count).for_each(|n| constraints.push_column([(n, 1.0)]));
    (0..count).for_each(|n| constraints.push_column([(n, 1.0), (first_excess_row + n, -1.0)]));
    (0..count)
        .for_each(|n| constraints.push_column([(n, -1.0), (first_excess_row + count + n, -1.0)]));

    // Linear costs: -h on d, none on u, one on v and w.
    let mut linear: Vec<f64> = summed.gradient.iter().map(|h| -unit * h).collect();
    linear.resize(P + count, 0.0);
    linear.resize(variables, 1.0);
    // Right sides: residuals at the centre, then what each bounded coefficient has to spare.
    let mut bounds: Vec<f64> = explicit.iter().map(|&k| data.residual(k, centre)).collect();
    bounds.extend(bounded.iter().map(|&j| centre[j] / unit));
    bounds.resize(rows, 0.0);
    (
        QuadraticProgram {
            quadratic,
            linear,
            constraints,
            bounds,
            equations: count,
        },
        unit,
    )
}
