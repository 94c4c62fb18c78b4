//! Least time along a smooth path from rest to rest under limits of velocity, acceleration and jerk
//! of X, Y and Z.
//!
//! The path is travelled first by a nominal polynomial motion, whose rest at both ends takes the
//! singularity away; sought is b, the square of the pace, at even steps of nominal time, by finite
//! differences. The time is a sum of 1 / sqrt(b), made of second-order cones; limits of velocity
//! and acceleration are linear; that of jerk over sqrt(b) has a convex right side, which is
//! linearised at the last b. Each of these programs is convex: its dual value proves how near to
//! its optimum it was solved, and since each has all that the last one had, the times fall until
//! they stand. Leaving the jerk out gives a lower bound that holds whatever the linearisation does.

use super::solver::{Clarabel, ConeProgram, ConeSolver};
use crate::common::LIMITS;
use lostmotion_path::Curve;

/// Times of the optimum, s.
pub(crate) struct Reference {
    /// Of what was found; it keeps all limits.
    pub(crate) time: f64,
    /// Lower bound of the last convex program.
    pub(crate) bound: f64,
    /// Optimum without the limit of jerk.
    pub(crate) without_jerk: f64,
}

/// Rounds of linearisation, and the change of the time at which they end.
const ROUNDS: usize = 40;
const STANDS: f64 = 2e-5;

/// Velocity, acceleration and jerk of an axis at a node of the nominal motion.
type Node = [[f64; 3]; 3];

struct Problem {
    nodes: Vec<Node>,
    /// One over the largest b by node, for velocities and feed.
    ceilings: Vec<f64>,
    step: f64,
}

/// The optimum on a curve whose parameter is its length.
pub(crate) fn best(curve: &Curve, feed: f64, steps: usize) -> Reference {
    let problem = nominal(curve, feed, steps);
    let mut b = vec![1.0; steps + 1];
    scale(&problem, &mut b);
    let without_jerk = solve(&problem, &b, false).1;
    let (mut time, mut bound) = (f64::INFINITY, 0.0);
    for _ in 0..ROUNDS {
        let (next, value, dual) = solve(&problem, &b, true);
        let fell = 1.0 - value / time;
        (b, time, bound) = (next, value, dual);
        let worst = excess(&problem, &b);
        assert!(worst < 1e-5, "passes a limit by {worst}");
        if fell < STANDS {
            break;
        }
    }
    Reference {
        time,
        bound,
        without_jerk,
    }
}

/// The septic from rest to rest with a jerk that starts and ends at zero would leave the ends
/// singular; the quintic does not.
fn nominal(curve: &Curve, feed: f64, steps: usize) -> Problem {
    let (length, step) = (curve.length(), 1.0 / steps as f64);
    let mut problem = Problem {
        nodes: Vec::new(),
        ceilings: Vec::new(),
        step,
    };
    for k in 0..=steps {
        let u = k as f64 * step;
        let s = length * u * u * u * (10.0 + u * (6.0 * u - 15.0));
        let v = length * 30.0 * u * u * (1.0 - u) * (1.0 - u);
        let a = length * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u);
        let j = length * (60.0 + u * (360.0 * u - 360.0));
        let jets = curve.jet(s);
        let node: Node = std::array::from_fn(|axis| {
            let d = jets[axis].0;
            [
                d[1] * v,
                d[2] * v * v + d[1] * a,
                d[3] * v * v * v + 3.0 * d[2] * v * a + d[1] * j,
            ]
        });
        let fastest = node.iter().fold(v / feed, |most, axis| {
            most.max(axis[0].abs() / LIMITS.velocity)
        });
        problem.nodes.push(node);
        problem.ceilings.push(fastest * fastest);
    }
    problem
}

/// Makes a steady pace so slow that all limits are kept.
fn scale(problem: &Problem, b: &mut [f64]) {
    let mut slowest = f64::INFINITY;
    for (node, ceiling) in problem.nodes.iter().zip(&problem.ceilings) {
        slowest = slowest.min(1.0 / ceiling.max(1e-12));
        for axis in node {
            slowest = slowest.min(LIMITS.acceleration / axis[1].abs().max(1e-12));
            let pace = LIMITS.jerk / axis[2].abs().max(1e-12);
            slowest = slowest.min(lostmotion_base::math::cbrt(pace * pace));
        }
    }
    b.fill(0.9 * slowest);
}

/// First and second derivative of b at a node by the values at up to three nodes.
fn stencil(node: usize, count: usize, step: f64) -> (usize, [[f64; 3]; 3]) {
    let first = node.clamp(1, count - 2) - 1;
    let at = node - first;
    let value = std::array::from_fn(|k| if k == at { 1.0 } else { 0.0 });
    let slope = [[-1.5, 2.0, -0.5], [-0.5, 0.0, 0.5], [0.5, -2.0, 1.5]][at].map(|c| c / step);
    let bend = [1.0, -2.0, 1.0].map(|c| c / (step * step));
    (first, [value, slope, bend])
}

/// Acceleration and jerk over sqrt(b) of an axis as coefficients of the three values.
fn rows([v, a, j]: [f64; 3], [value, slope, bend]: [[f64; 3]; 3]) -> [[f64; 3]; 2] {
    let row =
        |c: [f64; 3]| std::array::from_fn(|k| c[0] * value[k] + c[1] * slope[k] + c[2] * bend[k]);
    [row([a, 0.5 * v, 0.0]), row([j, 1.5 * a, 0.5 * v])]
}

/// By which part the limits themselves, not linearised, are passed at most.
fn excess(problem: &Problem, b: &[f64]) -> f64 {
    let mut worst = 0.0_f64;
    for (k, node) in problem.nodes.iter().enumerate() {
        let (first, derivatives) = stencil(k, b.len(), problem.step);
        worst = worst.max(b[k] * problem.ceilings[k]);
        for axis in node {
            let [a, j] = rows(*axis, derivatives)
                .map(|row| (0..3).map(|i| row[i] * b[first + i]).sum::<f64>());
            worst = worst
                .max(a.abs() / LIMITS.acceleration)
                .max(j.abs() * b[k].sqrt() / LIMITS.jerk);
        }
    }
    worst - 1.0
}

/// Solves the convex program around b: the new b, the time, its lower bound.
fn solve(problem: &Problem, b: &[f64], jerk: bool) -> (Vec<f64>, f64, f64) {
    let count = b.len();
    // Unknown are b in units of the last b, r <= sqrt(b), t >= 1 / r, each by node.
    let (roots, times) = (count, 2 * count);
    let weight = |k: usize| {
        if k == 0 || k + 1 == count {
            0.5 * problem.step
        } else {
            problem.step
        }
    };
    let mut linear = vec![0.0; 3 * count];
    let (mut entries, mut bounds) = (Vec::new(), Vec::new());
    for (k, node) in problem.nodes.iter().enumerate() {
        linear[times + k] = weight(k) / b[k].sqrt();
        entries.push((bounds.len(), k, problem.ceilings[k] * b[k]));
        bounds.push(1.0);
        let (first, derivatives) = stencil(k, count, problem.step);
        for axis in node {
            let [acceleration, jolt] = rows(*axis, derivatives);
            let mut add = |row: [f64; 3], limit: f64, slope: f64| {
                for sign in [1.0, -1.0] {
                    let at = bounds.len();
                    (0..3).for_each(|i| {
                        entries.push((at, first + i, sign * row[i] * b[first + i] / limit));
                    });
                    entries.push((at, k, slope));
                    bounds.push(1.0 + slope);
                }
            };
            add(acceleration, LIMITS.acceleration, 0.0);
            if jerk {
                // 1 / sqrt(x) >= 1 - (x - 1) / 2 for b in units of the last b.
                add(jolt, LIMITS.jerk / b[k].sqrt(), 0.5);
            }
        }
    }
    let inequalities = bounds.len();
    for k in 0..count {
        // |(2 r, b - 1)| <= b + 1 and |(2, t - r)| <= t + r.
        let at = bounds.len();
        entries.extend([(at, k, -1.0), (at + 1, roots + k, -2.0), (at + 2, k, -1.0)]);
        bounds.extend([1.0, 0.0, -1.0]);
        let at = bounds.len();
        entries.extend([
            (at, times + k, -1.0),
            (at, roots + k, -1.0),
            (at + 2, times + k, -1.0),
            (at + 2, roots + k, 1.0),
        ]);
        bounds.extend([0.0, 2.0, 0.0]);
    }
    let found = Clarabel.solve(&ConeProgram {
        linear,
        entries,
        bounds,
        inequalities,
    });
    let next = (0..count).map(|k| found.x[k] * b[k]).collect();
    (next, found.value, found.bound)
}
