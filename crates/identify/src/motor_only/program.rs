//! The fit over all crossings as one convex program.
//!
//! Every crossing's own constants are first taken out of its equations by an orthogonal projection,
//! so that the rest is of the size of the gap; the changes of these constants that a Huber loss
//! still makes stay in the program as variables `e` of that crossing:
//! ```text
//! minimise sum (u^2/2 + v + w)   s.t.   a d + q e + u + v - w = r,   v, w >= 0,   b >= 0, c >= 0, p >= 0
//! ```
//! `d` is the step of the common coefficients from least squares, `r` the residual there, `q` the
//! orthonormal local columns, all in units of delta.

use crate::{
    error::FitError,
    huber::Regression,
    result::SolverReport,
    solver::{QpSolver, QuadraticProgram, SolveOptions, SolverStatus, SparseColumns},
};

use faer::Mat;

use super::segments::{COMMON, COMPLIANCE, Equation, HALF_GAP, INVERSE_INERTIA, Segment};
use super::uncertainty::{Drift, Prior, whiten};

/// Constants of a crossing at most: position, speed, acceleration of the load.
pub(super) const LOCAL: usize = 3;

/// Equations of all crossings with their own constants projected out, then the priors.
pub(super) struct Projected<const P: usize> {
    pub(super) regression: Regression<P>,
    /// Orthonormal local columns, zero where a crossing has fewer constants.
    pub(super) local: Vec<[f64; LOCAL]>,
    /// Crossing of each equation; each prior counts as one.
    pub(super) segment: Vec<usize>,
    /// Equations before the priors.
    pub(super) equations: usize,
    segments: usize,
}

/// Coefficients and residuals of a solve.
pub(super) struct Solved<const P: usize> {
    pub(super) x: [f64; P],
    /// rad.
    pub(super) residuals: Vec<f64>,
    pub(super) report: SolverReport,
}

/// Orthonormal columns for the constants of one crossing.
fn basis(equations: &[Equation], slides: bool, lower: Option<&Mat<f64>>) -> Vec<[f64; LOCAL]> {
    let count = equations.len() as f64;
    // Powers of the time about the middle are nearly orthogonal already.
    let middle = equations.iter().map(|equation| equation.time).sum::<f64>() / count;
    let powers = |time: f64| [1.0, time - middle, (time - middle) * (time - middle)];
    let mut columns: Vec<[f64; LOCAL]> = equations
        .iter()
        .map(|equation| powers(equation.time))
        .collect();
    // Constants are whitened like the equations that they belong to.
    if let Some(lower) = lower {
        for j in 0..LOCAL {
            let mut column: Vec<f64> = columns.iter().map(|row| row[j]).collect();
            whiten(lower, &mut column);
            columns
                .iter_mut()
                .zip(column)
                .for_each(|(row, value)| row[j] = value);
        }
    }
    // Gram and Schmidt; a load that rests has a place, and no speed or acceleration.
    for j in 0..LOCAL {
        for i in 0..j {
            let overlap: f64 = columns.iter().map(|row| row[i] * row[j]).sum();
            columns
                .iter_mut()
                .for_each(|row| row[j] -= overlap * row[i]);
        }
        let norm = columns
            .iter()
            .map(|row| row[j] * row[j])
            .sum::<f64>()
            .sqrt();
        let used = norm > 0.0 && (j == 0 || slides);
        columns
            .iter_mut()
            .for_each(|row| row[j] = if used { row[j] / norm } else { 0.0 });
    }
    columns
}

fn project(values: &mut [f64], columns: &[[f64; LOCAL]]) {
    for j in 0..LOCAL {
        let overlap: f64 = values
            .iter()
            .zip(columns)
            .map(|(value, row)| value * row[j])
            .sum();
        values
            .iter_mut()
            .zip(columns)
            .for_each(|(value, row)| *value -= overlap * row[j]);
    }
}

impl Projected<COMMON> {
    /// With errors that drift so, and with priors in units of a window's standard deviation, rad.
    pub(super) fn new(
        segments: &[Segment],
        drift: Drift,
        priors: &[Prior],
        deviation: f64,
    ) -> Self {
        let nonnegative =
            std::array::from_fn(|column| matches!(column, HALF_GAP | COMPLIANCE | INVERSE_INERTIA));
        let regression = Regression {
            rows: vec![],
            targets: vec![],
            nonnegative,
        };
        let mut whole = Projected {
            regression,
            local: vec![],
            segment: vec![],
            equations: 0,
            segments: segments.len() + priors.len(),
        };
        for (index, segment) in segments.iter().enumerate() {
            whole.add(index, segment, drift);
        }
        whole.equations = whole.segment.len();
        // A prior is one more equation, weighed by a window's deviation over its own.
        for (index, prior) in priors.iter().enumerate() {
            let weight = deviation / prior.deviation;
            whole.regression.rows.push(std::array::from_fn(|column| {
                if column == prior.column { weight } else { 0.0 }
            }));
            whole.regression.targets.push(weight * prior.value);
            whole.local.push([0.0; LOCAL]);
            whole.segment.push(segments.len() + index);
        }
        whole
    }

    fn add(&mut self, index: usize, segment: &Segment, drift: Drift) {
        let equations = &segment.equations;
        let lower = drift.whitener(
            &equations
                .iter()
                .map(|equation| equation.under_way)
                .collect::<Vec<_>>(),
        );
        let local = basis(equations, segment.slides, lower.as_ref());
        let whitened = |mut values: Vec<f64>, times: u32| {
            if let Some(lower) = &lower {
                whiten(lower, &mut values);
            }
            (0..times).for_each(|_| project(&mut values, &local));
            values
        };
        // In the order of the coefficients' places.
        let pick = |e: &Equation, column: usize| {
            [
                e.side,
                e.torque,
                -e.sliding_rate,
                e.travel,
                e.friction,
                e.impulse,
                -e.slip,
                e.resting_rate,
                -e.drag,
            ][column]
        };
        let columns: [Vec<f64>; COMMON] = std::array::from_fn(|column| {
            whitened(equations.iter().map(|e| pick(e, column)).collect(), 1)
        });
        // twice: the motor goes a thousand gaps while it crosses one
        let targets = whitened(equations.iter().map(|equation| equation.motor).collect(), 2);
        let count = targets.len();
        self.regression
            .rows
            .extend((0..count).map(|k| std::array::from_fn(|j| columns[j][k])));
        self.regression.targets.extend(targets);
        self.local.extend(local);
        self.segment.extend(std::iter::repeat_n(index, count));
    }
}

impl<const P: usize> Projected<P> {
    /// The minimiser for a delta in rad.
    pub(super) fn solve(
        &self,
        delta: f64,
        solver: &dyn QpSolver,
        options: &SolveOptions,
    ) -> Result<Solved<P>, FitError> {
        let (count, rms) = (self.regression.targets.len(), self.column_rms());
        // The program's step is counted from least squares, in units of delta over a column's RMS.
        let start = self.regression.least_squares();
        let program = self.program(&start, &rms, delta);
        let solution = solver.solve(&program, options)?;
        match solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => {}
            status => {
                return Err(FitError::Solver {
                    status,
                    iterations: solution.iterations,
                });
            }
        }
        let at = |index: usize| solution.x.get(index).copied().unwrap_or(0.0);
        let x: [f64; P] = std::array::from_fn(|j| {
            let value = start[j] + at(j) * delta / rms[j];
            if self.regression.nonnegative[j] {
                value.max(0.0)
            } else {
                value
            }
        });
        // What the loss still moves of the crossing's own constants.
        let moved = |k: usize| -> f64 {
            (0..LOCAL)
                .map(|l| self.local[k][l] * at(P + LOCAL * self.segment[k] + l))
                .sum()
        };
        let residuals: Vec<f64> = (0..count)
            .map(|k| self.regression.residual(k, &x) - delta * moved(k))
            .collect();
        let optimality = self.optimality(&residuals, delta, &x);
        let report = SolverReport {
            name: solver.name().to_owned(),
            status: solution.status,
            iterations: solution.iterations,
            solves: 1,
            explicit_samples: count,
            optimality,
        };
        Ok(Solved {
            x,
            residuals,
            report,
        })
    }

    /// RMS of each column, 1 for an empty one.
    fn column_rms(&self) -> [f64; P] {
        let count = self.regression.rows.len().max(1) as f64;
        std::array::from_fn(|j| {
            let square: f64 = self.regression.rows.iter().map(|row| row[j] * row[j]).sum();
            if square > 0.0 {
                (square / count).sqrt()
            } else {
                1.0
            }
        })
    }

    fn program(&self, start: &[f64; P], rms: &[f64; P], delta: f64) -> QuadraticProgram {
        let count = self.regression.targets.len();
        // Bounds far from the start are left out: badly scaled rows keep a solver from converging.
        let bounded: Vec<usize> = (0..P)
            .filter(|&j| self.regression.nonnegative[j] && start[j] * rms[j] < 10.0 * delta)
            .collect();
        // Variables d, e, u, v, w; rows: equations, bounds, v >= 0, w >= 0.
        let variables = P + LOCAL * self.segments + 3 * count;
        let rows = count + bounded.len() + 2 * count;
        let first_excess_row = count + bounded.len();
        let mut quadratic = SparseColumns::new(variables);
        let free = P + LOCAL * self.segments;
        for j in 0..free {
            // a column that no equation has would leave its variable undetermined
            quadratic.push_column([(j, 1e-9)]);
        }
        (0..count).for_each(|n| quadratic.push_column([(free + n, 1.0)]));
        (0..2 * count).for_each(|_| quadratic.push_column([]));
        let mut constraints = SparseColumns::new(rows);
        // Columns of d with their bounds, of e, then of u, v and w.
        for (j, unit) in rms.iter().enumerate() {
            let slopes = (0..count).map(|k| (k, self.regression.rows[k][j] / unit));
            let bound = bounded
                .iter()
                .position(|&b| b == j)
                .map(|n| (count + n, -1.0));
            constraints.push_column(slopes.chain(bound));
        }
        self.push_local(&mut constraints);
        (0..count).for_each(|n| constraints.push_column([(n, 1.0)]));
        (0..count).for_each(|n| constraints.push_column([(n, 1.0), (first_excess_row + n, -1.0)]));
        (0..count).for_each(|n| {
            constraints.push_column([(n, -1.0), (first_excess_row + count + n, -1.0)]);
        });
        // Costs: squares of u, excesses v and w linearly.
        let mut linear = vec![0.0; free + count];
        linear.resize(variables, 1.0);
        let mut bounds: Vec<f64> = (0..count)
            .map(|k| self.regression.residual(k, start) / delta)
            .collect();
        bounds.extend(bounded.iter().map(|&j| start[j] * rms[j] / delta));
        bounds.resize(rows, 0.0);
        QuadraticProgram {
            quadratic,
            linear,
            constraints,
            bounds,
            equations: count,
        }
    }

    fn push_local(&self, constraints: &mut SparseColumns) {
        let mut first = 0;
        // Each crossing has variables of its own for its constants.
        for run in self.segment.chunk_by(|a, b| a == b) {
            for l in 0..LOCAL {
                let entries = (first..first + run.len())
                    .map(|k| (k, self.local[k][l]))
                    .filter(|(_, value)| *value != 0.0);
                constraints.push_column(entries);
            }
            first += run.len();
        }
    }

    /// Largest component of the gradient over the common coefficients that no bound excuses, per
    /// sample, scaled.
    fn optimality(&self, residuals: &[f64], delta: f64, x: &[f64; P]) -> f64 {
        let rms = self.column_rms();
        // Component of the gradient: the derivative of the loss, clipped at delta, against the
        // column.
        let pull = |j: usize| -> f64 {
            residuals
                .iter()
                .zip(&self.regression.rows)
                .map(|(r, row)| (r / delta).clamp(-1.0, 1.0) * row[j] / rms[j])
                .sum()
        };
        let excused =
            |j: usize, pull: f64| self.regression.nonnegative[j] && x[j] <= 0.0 && pull <= 0.0;
        let worst = (0..P)
            .map(|j| (j, pull(j)))
            .filter(|&(j, pull)| !excused(j, pull))
            .map(|(_, pull)| pull.abs())
            .fold(0.0, f64::max);
        worst / residuals.len().max(1) as f64
    }
}
