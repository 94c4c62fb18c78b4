//! Clarabel, an interior-point solver with a homogeneous embedding (Goulart and Chen, 2024).

use clarabel::{
    algebra::CscMatrix,
    solver::{
        DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus as Status,
        ZeroConeT,
    },
};

use super::{QpSolution, QpSolver, QuadraticProgram, SolveOptions, SolverStatus, SparseColumns};
use crate::error::FitError;

/// Clarabel on one thread with its own sparse factorisation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clarabel;

impl QpSolver for Clarabel {
    fn name(&self) -> &'static str {
        "clarabel"
    }

    fn solve(
        &self,
        problem: &QuadraticProgram,
        options: &SolveOptions,
    ) -> Result<QpSolution, FitError> {
        // One thread and its own factorisation: the same bits on every run.
        let settings = DefaultSettings {
            verbose: false,
            max_threads: 1,
            direct_solve_method: "qdldl".to_owned(),
            max_iter: options.iterations,
            tol_gap_abs: options.tolerance,
            tol_gap_rel: options.tolerance,
            tol_feas: options.tolerance,
            ..DefaultSettings::default()
        };
        let rows = problem.constraints.rows;
        let inequalities = rows
            .checked_sub(problem.equations)
            .ok_or_else(|| refused("more equations than constraints"))?;
        // Equations first, then inequalities: the order of the rows.
        let cones = [ZeroConeT(problem.equations), NonnegativeConeT(inequalities)];
        let (quadratic, constraints) = (matrix(&problem.quadratic)?, matrix(&problem.constraints)?);
        let mut solver = DefaultSolver::new(
            &quadratic,
            &problem.linear,
            &constraints,
            &problem.bounds,
            &cones,
            settings,
        )
        .map_err(|error| refused(&error.to_string()))?;
        solver.solve();
        let solution = solver.solution;
        // Certificates of reduced accuracy count as what they certify.
        let status = match solution.status {
            Status::Solved => SolverStatus::Solved,
            Status::AlmostSolved => SolverStatus::AlmostSolved,
            Status::PrimalInfeasible | Status::AlmostPrimalInfeasible => SolverStatus::Infeasible,
            Status::DualInfeasible | Status::AlmostDualInfeasible => SolverStatus::Unbounded,
            Status::MaxIterations | Status::MaxTime => SolverStatus::IterationLimit,
            _ => SolverStatus::NumericalFailure,
        };
        Ok(QpSolution {
            x: solution.x,
            objective: solution.obj_val,
            status,
            iterations: solution.iterations,
        })
    }
}

fn matrix(columns: &SparseColumns) -> Result<CscMatrix<f64>, FitError> {
    let matrix = CscMatrix {
        m: columns.rows,
        n: columns.columns(),
        colptr: columns.starts.clone(),
        rowval: columns.indices.clone(),
        nzval: columns.values.clone(),
    };
    matrix
        .check_format()
        .map_err(|error| refused(&error.to_string()))?;
    Ok(matrix)
}

fn refused(reason: &str) -> FitError {
    FitError::SolverRefused {
        reason: reason.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (x - 1)^2 + (y - 2)^2 over y = x, x <= 1/2, whose minimum lies in the corner.
    fn corner() -> QuadraticProgram {
        let mut quadratic = SparseColumns::new(2);
        quadratic.push_column([(0, 2.0)]);
        quadratic.push_column([(1, 2.0)]);
        let mut constraints = SparseColumns::new(2);
        constraints.push_column([(0, 1.0), (1, 1.0)]);
        constraints.push_column([(0, -1.0)]);
        QuadraticProgram {
            quadratic,
            linear: vec![-2.0, -4.0],
            constraints,
            bounds: vec![0.0, 0.5],
            equations: 1,
        }
    }

    const OPTIONS: SolveOptions = SolveOptions {
        tolerance: 1e-10,
        iterations: 50,
    };

    #[test]
    fn equations_and_inequalities_are_kept() {
        let solution = Clarabel.solve(&corner(), &OPTIONS).unwrap();
        assert_eq!(solution.status, SolverStatus::Solved);
        assert!(
            solution.x.iter().all(|x| (x - 0.5).abs() < 1e-8),
            "{:?}",
            solution.x
        );
    }

    #[test]
    fn the_status_tells_how_it_ended() {
        let mut infeasible = corner();
        infeasible.constraints.rows = 3;
        infeasible.bounds = vec![0.0, 0.5, -1.0];
        infeasible.constraints = SparseColumns::new(3);
        infeasible
            .constraints
            .push_column([(0, 1.0), (1, 1.0), (2, -1.0)]);
        infeasible.constraints.push_column([(0, -1.0)]);
        assert_eq!(
            Clarabel.solve(&infeasible, &OPTIONS).unwrap().status,
            SolverStatus::Infeasible
        );
        assert_eq!(
            Clarabel
                .solve(
                    &corner(),
                    &SolveOptions {
                        iterations: 1,
                        ..OPTIONS
                    }
                )
                .unwrap()
                .status,
            SolverStatus::IterationLimit
        );
    }

    #[test]
    fn a_malformed_problem_is_refused() {
        let mut wrong = corner();
        wrong.constraints.indices[0] = 7;
        assert!(matches!(
            Clarabel.solve(&wrong, &OPTIONS),
            Err(FitError::SolverRefused { .. })
        ));
        assert!(matches!(
            Clarabel.solve(
                &QuadraticProgram {
                    equations: 3,
                    ..corner()
                },
                &OPTIONS
            ),
            Err(FitError::SolverRefused { .. })
        ));
        assert!(matches!(
            Clarabel.solve(
                &QuadraticProgram {
                    linear: vec![1.0],
                    ..corner()
                },
                &OPTIONS
            ),
            Err(FitError::SolverRefused { .. })
        ));
    }
}
