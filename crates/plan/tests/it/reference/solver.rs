//! The convex solver behind the reference optimiser.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT, SolverStatus,
};

/// A linear objective over rows `bounds - matrix x` that lie in cones: first so many that are not
/// negative, then second-order cones of three rows each.
pub(crate) struct ConeProgram {
    pub(crate) linear: Vec<f64>,
    /// Entries by row, column, value.
    pub(crate) entries: Vec<(usize, usize, f64)>,
    pub(crate) bounds: Vec<f64>,
    pub(crate) inequalities: usize,
}

/// The best x, its objective, and a lower bound of the objective.
pub(crate) struct Certified {
    pub(crate) x: Vec<f64>,
    pub(crate) value: f64,
    pub(crate) bound: f64,
}

pub(crate) trait ConeSolver {
    fn solve(&self, program: &ConeProgram) -> Certified;
}

pub(crate) struct Clarabel;

impl ConeSolver for Clarabel {
    fn solve(&self, program: &ConeProgram) -> Certified {
        let (rows, columns) = (program.bounds.len(), program.linear.len());
        let (mut i, mut j, mut v) = (Vec::new(), Vec::new(), Vec::new());
        for (row, column, value) in &program.entries {
            i.push(*row);
            j.push(*column);
            v.push(*value);
        }
        let matrix = CscMatrix::new_from_triplets(rows, columns, i, j, v);
        let mut cones = vec![NonnegativeConeT(program.inequalities)];
        cones.extend((0..(rows - program.inequalities) / 3).map(|_| SecondOrderConeT(3)));
        let settings = DefaultSettings {
            verbose: false,
            max_threads: 1,
            ..DefaultSettings::default()
        };
        let none = CscMatrix::zeros((columns, columns));
        let mut solver = DefaultSolver::new(
            &none,
            &program.linear,
            &matrix,
            &program.bounds,
            &cones,
            settings,
        )
        .unwrap();
        solver.solve();
        let solution = solver.solution;
        assert!(
            matches!(
                solution.status,
                SolverStatus::Solved | SolverStatus::AlmostSolved
            ),
            "{:?}",
            solution.status
        );
        Certified {
            x: solution.x,
            value: solution.obj_val,
            bound: solution.obj_val_dual,
        }
    }
}
