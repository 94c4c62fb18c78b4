//! Exact minimiser of a sum of Huber losses with few unknowns and many samples.
//!
//! ```text
//! minimise  sum_k rho(y_k - a_k x),   rho(r) = r^2/2 for |r| <= delta, else delta |r| - delta^2/2,   some x_j >= 0
//! ```
//! (Huber 1964). As a quadratic program each sample costs three auxiliary variables, which for 10^5
//! samples is slow. But a sample of which it is known in advance that its residual ends inside the
//! square part adds only a quadratic form in `x`, and one that ends in a linear part only a linear
//! form. So:
//!
//! 1. A thinned copy of the samples is solved in full. It lies within a few standard errors of the
//!    answer.
//! 2. Samples whose residual there lies within a narrow band around a corner of the loss stay
//!    explicit; the others are summed up.
//! 3. After the solve every summed-up sample is checked against what was assumed of it. If all
//!    hold, the point satisfies the optimality conditions of the **whole** problem, which is
//!    convex: it is the exact minimiser, not an approximation. Otherwise the violators become
//!    explicit and the solve is repeated. The explicit set only grows, so this ends, at worst with
//!    the full problem.
//! 4. A Newton step on the final pieces removes the solver's own tolerance.
//!    [`Minimiser::optimality`] reports the gradient that is left.
//!
//! Everything is scaled: columns to RMS 1, residuals to units of delta.

mod normal;

use lostmotion_base::vec::dot;

use crate::{
    error::FitError,
    solver::{QpSolver, QuadraticProgram, SolveOptions, SolverStatus, SparseColumns},
};

pub(crate) use normal::Piece;
pub use normal::{NormalEquations, solve_small};

/// Huber's delta in standard deviations: 95 % efficiency on normal residuals (Huber 1964).
pub(crate) const HUBER_TUNING: f64 = 1.345;
/// Most samples of the thinned copy that is solved in full. A choice between the cost of this solve
/// and the number of the later ones; the result does not depend on it.
const MAX_THINNED_SAMPLES: usize = 2000;
/// Distance from a corner of the loss, in deltas, within which a sample stays explicit at first. A
/// choice: a wider band makes the first program larger, a narrower one costs more solves; the
/// result does not depend on it.
const EXPLICIT_BAND: f64 = 0.05;
/// Scaled distance from zero, in deltas, beyond which a bound is left out of the program until a
/// solve violates it: a bound a million deltas away is the one badly scaled row of an otherwise
/// well scaled program, and keeps a solver from converging.
const FAR_BOUND: f64 = 10.0;
/// Scaled distance, in deltas, within which a coefficient counts as lying on its bound. A choice:
/// above the solvers' tolerance.
const AT_BOUND: f64 = 1e-6;
/// Relative change of the objective that counts as none. A choice: some ten thousand roundings.
const TIE: f64 = 1e-12;
/// Most Newton steps at the end; one is the rule.
const MAX_POLISH_STEPS: usize = 20;

/// Linear regression `y = a x` with some coefficients bounded below by zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Regression<const P: usize> {
    /// One row `a` per sample.
    pub rows: Vec<[f64; P]>,
    /// One `y` per sample.
    pub targets: Vec<f64>,
    /// Which coefficients may not be negative.
    pub nonnegative: [bool; P],
}

/// The minimiser and how it was reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimiser<const P: usize> {
    /// Coefficients.
    pub x: [f64; P],
    /// Worst status of the solves made.
    pub status: SolverStatus,
    /// Iterations over all solves.
    pub iterations: u32,
    /// Solves made.
    pub solves: u32,
    /// Samples that were explicit in the last solve.
    pub explicit: usize,
    /// Largest component of the loss' gradient that no bound excuses, per sample, in scaled units;
    /// 0 at the minimum.
    pub optimality: f64,
}

impl<const P: usize> Regression<P> {
    /// `y_k - a_k x` of one sample.
    pub fn residual(&self, sample: usize, x: &[f64; P]) -> f64 {
        self.targets[sample] - dot(self.rows[sample], *x)
    }

    /// The objective at `x`.
    pub fn objective(&self, x: &[f64; P], delta: f64) -> f64 {
        let loss = |r: f64| {
            if r <= delta {
                0.5 * r * r
            } else {
                delta * (r - 0.5 * delta)
            }
        };
        (0..self.targets.len())
            .map(|k| loss(self.residual(k, x).abs()))
            .sum()
    }

    /// Least squares, coefficients that may not be negative cut off at zero.
    pub(crate) fn least_squares(&self) -> [f64; P] {
        let (scaled, units) = self.scaled(1.0);
        let z = scaled.scaled_least_squares();
        std::array::from_fn(|j| z[j] * units[j])
    }

    /// The exact minimiser of the objective.
    ///
    /// # Errors
    /// Any solve that ends without a solution, with its status.
    pub fn minimise(
        &self,
        delta: f64,
        solver: &dyn QpSolver,
        options: &SolveOptions,
    ) -> Result<Minimiser<P>, FitError> {
        self.minimise_from(None, delta, solver, options)
    }

    /// The same from a point nearby, such as the minimiser for another delta or for targets that
    /// are little different: only samples near a corner of the loss there are explicit then. The
    /// nearer it is the less is to be solved; the minimiser does not depend on it, and from a point
    /// too far off it is sought as [`Self::minimise`] does.
    ///
    /// # Errors
    /// As [`Self::minimise`].
    pub fn minimise_from(
        &self,
        near: Option<&[f64; P]>,
        delta: f64,
        solver: &dyn QpSolver,
        options: &SolveOptions,
    ) -> Result<Minimiser<P>, FitError> {
        // From here on columns have RMS 1 and residuals are in deltas.
        let (scaled, units) = self.scaled(delta);
        let mut state = match (scaled.square_alone(), near) {
            (Some(z), _) => Descent::at(z),
            (None, Some(x)) => {
                let mut state = Descent::at(std::array::from_fn(|j| x[j] / units[j]));
                match scaled.reduce(&mut state, solver, options) {
                    Ok(()) => state,
                    // Too far: where no sample is near a corner nothing bends the program.
                    Err(FitError::Solver { .. }) => scaled.cold(solver, options)?,
                    Err(error) => return Err(error),
                }
            }
            (None, None) => scaled.cold(solver, options)?,
        };
        // Remove the solver's own tolerance.
        scaled.polish(&mut state.z);
        let optimality = scaled.optimality(&state.z);
        let x = std::array::from_fn(|j| state.z[j] * units[j]);
        let Descent {
            status,
            iterations,
            solves,
            explicit,
            ..
        } = state;
        Ok(Minimiser {
            x,
            status,
            iterations,
            solves,
            explicit,
            optimality,
        })
    }

    /// Least squares, where it is the minimiser: no residual leaves the square part and no bound is
    /// in force. A program of data without noise has nothing that a solver could scale by.
    fn square_alone(&self) -> Option<[f64; P]> {
        let z = self.scaled_least_squares();
        let free = (0..P).all(|j| !self.nonnegative[j] || z[j] > 0.0);
        let square = || (0..self.targets.len()).all(|k| self.residual(k, &z).abs() <= 1.0);
        (free && square()).then_some(z)
    }

    /// The descent from least squares.
    fn cold(&self, solver: &dyn QpSolver, options: &SolveOptions) -> Result<Descent<P>, FitError> {
        let mut state = Descent::at(self.scaled_least_squares());
        // A thinned set in full gives a point near enough to sum up the samples far from the
        // corners.
        let thinned = self.thinned(MAX_THINNED_SAMPLES);
        state.solve(
            &thinned,
            &vec![Piece::Explicit; thinned.targets.len()],
            solver,
            options,
        )?;
        if thinned.targets.len() < self.targets.len() {
            self.reduce(&mut state, solver, options)?;
        }
        Ok(state)
    }

    /// Columns of RMS 1, targets in deltas, and the unit of each scaled coefficient.
    fn scaled(&self, delta: f64) -> (Self, [f64; P]) {
        let count = self.rows.len().max(1) as f64;
        let rms: [f64; P] = std::array::from_fn(|j| {
            let square: f64 = self.rows.iter().map(|row| row[j] * row[j]).sum();
            if square > 0.0 {
                (square / count).sqrt()
            } else {
                1.0
            }
        });
        let rows = self
            .rows
            .iter()
            .map(|row| std::array::from_fn(|j| row[j] / rms[j]))
            .collect();
        let targets = self.targets.iter().map(|y| y / delta).collect();
        (
            Self {
                rows,
                targets,
                nonnegative: self.nonnegative,
            },
            std::array::from_fn(|j| delta / rms[j]),
        )
    }

    /// Every n-th sample, so that at most `most` are left.
    pub(crate) fn thinned(&self, most: usize) -> Self {
        let step = self.rows.len().div_ceil(most).max(1);
        Self {
            rows: self.rows.iter().step_by(step).copied().collect(),
            targets: self.targets.iter().step_by(step).copied().collect(),
            nonnegative: self.nonnegative,
        }
    }

    fn reduce(
        &self,
        state: &mut Descent<P>,
        solver: &dyn QpSolver,
        options: &SolveOptions,
    ) -> Result<(), FitError> {
        let centre = state.z;
        // Samples near a corner of the loss stay explicit; of the others the part is presumed.
        let mut pieces: Vec<Piece> = (0..self.targets.len())
            .map(|k| Piece::assume(self.residual(k, &centre), EXPLICIT_BAND))
            .collect();
        loop {
            // Always around the same centre, for which the pieces were presumed.
            state.z = centre;
            state.solve(self, &pieces, solver, options)?;
            // A sample that crossed its assumed corner becomes explicit, and the program is solved
            // again.
            let mut violated = 0;
            for (k, piece) in pieces.iter_mut().enumerate() {
                if !piece.holds(self.residual(k, &state.z)) {
                    *piece = Piece::Explicit;
                    violated += 1;
                }
            }
            if violated == 0 {
                return Ok(());
            }
        }
    }

    /// Newton steps on the pieces of the loss, kept only while they lower it.
    fn polish(&self, z: &mut [f64; P]) {
        let mut best = self.objective(z, 1.0);
        for _ in 0..MAX_POLISH_STEPS {
            // Newton on the present pieces: exact in one step if no residual changes its piece.
            let normal = NormalEquations::at(self, z);
            // A coefficient at its bound that the gradient pushes against it stays there (active
            // set).
            let free = std::array::from_fn(|j| {
                !(self.nonnegative[j] && z[j] <= AT_BOUND && normal.gradient[j] <= 0.0)
            });
            let Some(step) = normal.newton(&free) else {
                return;
            };
            // Projected step: what would become negative ends at zero.
            let next: [f64; P] = std::array::from_fn(|j| match (free[j], self.nonnegative[j]) {
                (false, _) => 0.0,
                (true, true) => (z[j] + step[j]).max(0.0),
                (true, false) => z[j] + step[j],
            });
            let objective = self.objective(&next, 1.0);
            let gain = best - objective;
            // a tie is taken: near the minimum the objective no longer resolves what the gradient
            // does
            if gain < -TIE * best || self.optimality(&next) > self.optimality(z) {
                return;
            }
            (*z, best) = (next, objective);
        }
    }

    fn optimality(&self, z: &[f64; P]) -> f64 {
        let gradient = NormalEquations::at(self, z).gradient;
        // Karush, Kuhn and Tucker: at a bound the gradient may point against it.
        let excused = |j: usize| self.nonnegative[j] && z[j] <= 0.0 && gradient[j] <= 0.0;
        let worst = (0..P)
            .filter(|&j| !excused(j))
            .map(|j| gradient[j].abs())
            .fold(0.0, f64::max);
        worst / self.rows.len().max(1) as f64
    }

    fn scaled_least_squares(&self) -> [f64; P] {
        // with every sample in the square part, one Newton step from zero is least squares
        let step = NormalEquations::square(self)
            .newton(&[true; P])
            .unwrap_or([0.0; P]);
        std::array::from_fn(|j| {
            if self.nonnegative[j] {
                step[j].max(0.0)
            } else {
                step[j]
            }
        })
    }
}

/// Where the descent stands, in scaled units.
struct Descent<const P: usize> {
    z: [f64; P],
    status: SolverStatus,
    iterations: u32,
    solves: u32,
    explicit: usize,
}

impl<const P: usize> Descent<P> {
    /// Before any solve.
    fn at(z: [f64; P]) -> Self {
        Descent {
            z,
            status: SolverStatus::Solved,
            iterations: 0,
            solves: 0,
            explicit: 0,
        }
    }

    /// One program around the present point, and again with any bound that it was wrong to leave
    /// out.
    fn solve(
        &mut self,
        data: &Regression<P>,
        pieces: &[Piece],
        solver: &dyn QpSolver,
        options: &SolveOptions,
    ) -> Result<(), FitError> {
        // Bounds far from the centre are left out at first (see FAR_BOUND).
        let mut bounded = std::array::from_fn(|j| data.nonnegative[j] && self.z[j] <= FAR_BOUND);
        loop {
            let (program, unit) = quadratic_program(data, pieces, &self.z, &bounded);
            let solution = solver.solve(&program, options)?;
            self.iterations += solution.iterations;
            self.solves += 1;
            self.explicit = program.equations;
            match solution.status {
                SolverStatus::Solved => {}
                SolverStatus::AlmostSolved => self.status = SolverStatus::AlmostSolved,
                status => {
                    return Err(FitError::Solver {
                        status,
                        iterations: self.iterations,
                    });
                }
            }
            let z: [f64; P] = std::array::from_fn(|j| {
                self.z[j] + unit * solution.x.get(j).copied().unwrap_or(0.0)
            });
            // A bound that was left out and is violated joins the program, which is solved again.
            let missed: [bool; P] =
                std::array::from_fn(|j| data.nonnegative[j] && !bounded[j] && z[j] < 0.0);
            if !missed.contains(&true) {
                // what is still below zero is within the solver's tolerance of its bound
                self.z = std::array::from_fn(|j| {
                    if data.nonnegative[j] {
                        z[j].max(0.0)
                    } else {
                        z[j]
                    }
                });
                return Ok(());
            }
            bounded = std::array::from_fn(|j| bounded[j] || missed[j]);
        }
    }
}

/// Variables: step `d` (P), then for each explicit sample its square part `u`, its excess above
/// `v >= 0` and below `w >= 0` with `a d + u + v - w = r`, `r` the residual at the centre; loss
/// `u^2/2 + v + w`. The other samples add `d'Hd/2 - h'd`. A coefficient that is `bounded` keeps
/// centre plus step from falling below zero.
///
/// The step is in units of `1/sqrt(samples)`, the size that steps have, so that `H` does not
/// outgrow the explicit samples. Returns the program and the unit of its first variables.
fn quadratic_program<const P: usize>(
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
    let summed = NormalEquations::of_pieces(data, pieces, centre);
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
