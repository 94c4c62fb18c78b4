//! Quadratic programs, and the solvers for them.
//!
//! The fits see this trait only, so that another solver is one file and no type of a solver's
//! library leaks out.

mod clarabel;

pub use self::clarabel::Clarabel;
use crate::error::FitError;
pub use crate::error::SolverStatus;

/// A sparse matrix, column by column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SparseColumns {
    /// Number of rows.
    pub rows: usize,
    /// Where each column starts in `indices`, and one more entry for the end.
    pub starts: Vec<usize>,
    /// Row of each entry, ascending within a column.
    pub indices: Vec<usize>,
    /// Value of each entry.
    pub values: Vec<f64>,
}

impl SparseColumns {
    /// An empty matrix with this number of rows, to be filled by [`SparseColumns::push_column`].
    pub fn new(rows: usize) -> Self {
        Self {
            rows,
            starts: vec![0],
            indices: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Appends a column, given as (row, value) with ascending rows.
    pub fn push_column(&mut self, entries: impl IntoIterator<Item = (usize, f64)>) {
        for (row, value) in entries {
            self.indices.push(row);
            self.values.push(value);
        }
        self.starts.push(self.indices.len());
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }
}

/// Minimise `x'Px/2 + q'x` subject to `Ax = r` in the first rows and `Ax <= r` in the others.
#[derive(Clone, Debug, PartialEq)]
pub struct QuadraticProgram {
    /// `P`, positive semidefinite, upper triangle only.
    pub quadratic: SparseColumns,
    /// `q`.
    pub linear: Vec<f64>,
    /// `A`.
    pub constraints: SparseColumns,
    /// `r`.
    pub bounds: Vec<f64>,
    /// How many of the rows are equations.
    pub equations: usize,
}

/// Result of one solve.
#[derive(Clone, Debug, PartialEq)]
pub struct QpSolution {
    /// The minimiser.
    pub x: Vec<f64>,
    /// Objective there.
    pub objective: f64,
    /// How the solver ended.
    pub status: SolverStatus,
    /// Iterations it made.
    pub iterations: u32,
}

/// Stop conditions of one solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveOptions {
    /// Tolerance on duality gap and feasibility, absolute and relative.
    pub tolerance: f64,
    /// Most iterations.
    pub iterations: u32,
}

/// A solver of quadratic programs.
pub trait QpSolver {
    /// Name for reports.
    fn name(&self) -> &'static str;

    /// Solves one problem. A solve that ends without a solution is not an error here: its status
    /// says so.
    ///
    /// # Errors
    /// [`FitError::SolverRefused`] for a problem that the solver does not accept, such as matrices
    /// of the wrong size.
    fn solve(
        &self,
        problem: &QuadraticProgram,
        options: &SolveOptions,
    ) -> Result<QpSolution, FitError>;
}
