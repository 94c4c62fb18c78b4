//! The regression against minimisers that share nothing with it.

use std::cell::Cell;

use lostmotion_base::Random;
use lostmotion_identify::{
    FitError,
    huber::Regression,
    solver::{Clarabel, QpSolution, QpSolver, QuadraticProgram, SolveOptions, SolverStatus},
};
use proptest::prelude::*;

const OPTIONS: SolveOptions = SolveOptions {
    tolerance: 1e-9,
    iterations: 100,
};

/// y = 0.5 s + 0.2 + 0.01 T with unit noise times `noise`, and every tenth sample far off to one
/// side.
fn data(samples: usize, noise: f64, seed: u64) -> Regression<3> {
    let mut random = Random::new(seed);
    let rows: Vec<[f64; 3]> = (0..samples)
        .map(|_| {
            let torque = random.between(-5.0, 5.0);
            [torque.signum(), 1.0, torque]
        })
        .collect();
    let targets = rows
        .iter()
        .enumerate()
        .map(|(k, row)| {
            0.5 * row[0]
                + 0.2
                + 0.01 * row[2]
                + noise * random.normal()
                + if k % 10 == 3 { 0.3 } else { 0.0 }
        })
        .collect();
    Regression {
        rows,
        targets,
        nonnegative: [true, false, true],
    }
}

/// Golden section for the minimum of a convex function.
fn golden(mut low: f64, mut high: f64, mut f: impl FnMut(f64) -> f64) -> (f64, f64) {
    let ratio = (5.0_f64.sqrt() - 1.0) / 2.0;
    let (mut a, mut b) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut fa, mut fb) = (f(a), f(b));
    while high - low > 1e-9 {
        if fa < fb {
            (high, b, fb) = (b, a, fa);
            a = high - ratio * (high - low);
            fa = f(a);
        } else {
            (low, a, fa) = (a, b, fb);
            b = low + ratio * (high - low);
            fb = f(b);
        }
    }
    (0.5 * (low + high), fa.min(fb))
}

#[test]
fn brute_force_finds_the_same_minimum() {
    for (seed, delta) in [(1, 0.02), (2, 0.005), (3, 0.1)] {
        let data = data(40, 0.02, seed);
        let found = data.minimise(delta, &Clarabel, &OPTIONS).unwrap();
        let inner = |b: f64, c: f64| golden(-0.5, 1.0, |o| data.objective(&[b, o, c], delta)).1;
        let (gap, best) = golden(0.0, 1.0, |b| golden(0.0, 0.1, |c| inner(b, c)).1);
        assert!((found.x[0] - gap).abs() < 1e-6, "{} {gap}", found.x[0]);
        assert!(data.objective(&found.x, delta) <= best * (1.0 + 1e-12));
        assert_eq!(found.explicit, 40);
    }
}

#[test]
fn a_wide_delta_gives_least_squares() {
    let data = data(300, 0.02, 4);
    let found = data.minimise(1e3, &Clarabel, &OPTIONS).unwrap().x;
    // normal equations by Cramer's rule
    let sum = |f: &dyn Fn(usize) -> f64| (0..300).map(f).sum::<f64>();
    let m = |i: usize, j: usize| sum(&|k| data.rows[k][i] * data.rows[k][j]);
    let r = |i: usize| sum(&|k| data.rows[k][i] * data.targets[k]);
    let matrix: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| m(i, j)));
    let determinant = |m: &[[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    for (column, x) in found.iter().enumerate() {
        let mut replaced = matrix;
        (0..3).for_each(|i| replaced[i][column] = r(i));
        assert!(
            (x - determinant(&replaced) / determinant(&matrix)).abs() < 1e-12,
            "{column}"
        );
    }
}

/// Counts what is asked of the solver.
#[derive(Default)]
struct Counting {
    largest: Cell<usize>,
}

impl QpSolver for Counting {
    fn name(&self) -> &'static str {
        "counting"
    }

    fn solve(
        &self,
        problem: &QuadraticProgram,
        options: &SolveOptions,
    ) -> Result<QpSolution, FitError> {
        self.largest.set(self.largest.get().max(problem.equations));
        Clarabel.solve(problem, options)
    }
}

#[test]
fn summing_up_is_exact() {
    let data = data(20_000, 0.02, 5);
    let counting = Counting::default();
    let found = data.minimise(0.03, &counting, &OPTIONS).unwrap();
    assert!(counting.largest.get() < 4000, "{}", counting.largest.get());
    assert!(found.optimality < 1e-12, "{:e}", found.optimality);
    // the minimum of a convex function: no way leads down, by a finite difference that has no part
    // in the method
    let best = data.objective(&found.x, 0.03);
    for j in 0..3 {
        for step in [1e-6, -1e-6] {
            let mut x = found.x;
            x[j] += step;
            assert!(data.objective(&x, 0.03) > best);
        }
    }
}

/// Wherever it begins: at the minimum for another delta, beside it, far off, where nothing is near a
/// corner of the loss, and where data fit to the last bit.
#[test]
fn the_start_does_not_matter() {
    for seed in 20..24 {
        let data = data(8000, 0.02, seed);
        let cold = data.minimise(0.03, &Clarabel, &OPTIONS).unwrap();
        let other = data.minimise(0.04, &Clarabel, &OPTIONS).unwrap().x;
        let counting = Counting::default();
        let near = data.minimise_from(Some(&other), 0.03, &counting, &OPTIONS);
        assert!(counting.largest.get() < 1500, "{}", counting.largest.get());
        for warm in [
            near,
            data.minimise_from(Some(&cold.x), 0.03, &Clarabel, &OPTIONS),
            data.minimise_from(Some(&[0.9, -0.4, 0.08]), 0.03, &Clarabel, &OPTIONS),
            data.minimise_from(Some(&[0.0; 3]), 0.03, &Clarabel, &OPTIONS),
        ] {
            let warm = warm.unwrap();
            assert!(warm.optimality < 1e-12, "{:e}", warm.optimality);
            for (warm, cold) in warm.x.iter().zip(cold.x) {
                assert!((warm - cold).abs() < 1e-10, "{warm} {cold}");
            }
        }
    }
    let mut exact = data(3000, 0.02, 24);
    for (row, y) in exact.rows.iter().zip(&mut exact.targets) {
        *y = 0.2 * row[0] - 0.1 * row[1] + 0.03 * row[2];
    }
    let found = exact.minimise_from(Some(&[0.2, -0.1, 0.03]), 0.03, &Clarabel, &OPTIONS);
    for (found, truth) in found.unwrap().x.iter().zip([0.2, -0.1, 0.03]) {
        assert!((found - truth).abs() < 1e-12, "{found} {truth}");
    }
}

#[test]
fn a_thinned_start_that_misleads_is_put_right() {
    // every tenth sample, which is what thinning picks, tells another story than all the others
    let mut data = data(20_000, 0.02, 6);
    data.targets.iter_mut().step_by(10).for_each(|y| *y += 0.1);
    let found = data.minimise(0.03, &Clarabel, &OPTIONS).unwrap();
    assert!(found.optimality < 1e-12, "{:e}", found.optimality);
    assert!(found.solves > 2);
}

#[test]
fn bounds_hold_where_data_pull_against_them() {
    let mut data = data(500, 0.001, 7);
    for (row, y) in data.rows.iter().zip(&mut data.targets) {
        *y = -0.5 * row[0] + 0.2 + 0.3 * row[2];
    }
    let found = data.minimise(10.0, &Clarabel, &OPTIONS).unwrap();
    assert_eq!(found.x[0].to_bits(), 0.0_f64.to_bits());
    let (_, best) = golden(0.0, 0.5, |c| {
        golden(-1.0, 1.0, |o| data.objective(&[0.0, o, c], 10.0)).1
    });
    assert!((data.objective(&found.x, 10.0) / best - 1.0).abs() < 1e-9);
    assert!(found.optimality < 1e-12);
}

/// Ends every solve the same way.
struct Failing(SolverStatus);

impl QpSolver for Failing {
    fn name(&self) -> &'static str {
        "failing"
    }

    fn solve(&self, problem: &QuadraticProgram, _: &SolveOptions) -> Result<QpSolution, FitError> {
        Ok(QpSolution {
            x: vec![0.0; problem.linear.len()],
            objective: 0.0,
            status: self.0,
            iterations: 3,
        })
    }
}

#[test]
fn a_solver_that_fails_is_reported() {
    let data = data(50, 0.02, 8);
    for status in [
        SolverStatus::IterationLimit,
        SolverStatus::NumericalFailure,
        SolverStatus::Infeasible,
        SolverStatus::Unbounded,
    ] {
        let error = data.minimise(0.03, &Failing(status), &OPTIONS).unwrap_err();
        assert_eq!(
            error,
            FitError::Solver {
                status,
                iterations: 3
            }
        );
    }
    assert_eq!(
        data.minimise(0.03, &Failing(SolverStatus::AlmostSolved), &OPTIONS)
            .unwrap()
            .status,
        SolverStatus::AlmostSolved
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn nothing_lies_below_the_minimum(seed in 0_u64..1000, delta in 0.001..0.2_f64, b in 0.0..1.0_f64, o in -0.5..0.5_f64, c in 0.0..0.1_f64) {
        let data = data(200, 0.02, seed);
        let found = data.minimise(delta, &Clarabel, &OPTIONS).unwrap();
        let best = data.objective(&found.x, delta);
        prop_assert!(best <= data.objective(&[b, o, c], delta));
        for share in [1e-3, 1e-5] {
            let near = [b, o, c].iter().zip(found.x).map(|(far, x)| x + share * (far - x)).collect::<Vec<_>>();
            prop_assert!(best <= data.objective(&[near[0], near[1], near[2]], delta) * (1.0 + 1e-13));
        }
    }

    #[test]
    fn units_do_not_matter(seed in 0_u64..1000, length in 1e-6..1e6_f64, force in 1e-6..1e6_f64) {
        let data = data(200, 0.02, seed);
        let mut other = data.clone();
        other.rows.iter_mut().for_each(|row| row[2] *= force);
        other.targets.iter_mut().for_each(|y| *y *= length);
        let here = data.minimise(0.03, &Clarabel, &OPTIONS).unwrap().x;
        let there = other.minimise(0.03 * length, &Clarabel, &OPTIONS).unwrap().x;
        for (here, there) in here.iter().zip([there[0] / length, there[1] / length, there[2] / length * force]) {
            prop_assert!((here - there).abs() < 1e-10);
        }
    }
}
