//! Fairing: moves the vertices of a run within a tolerance so that the curve through them bends
//! evenly.
//!
//! Noise and rounding of the points are far below the tolerance, yet differences of third order
//! blow them up. The offsets e minimise the integral of w e^2 + l^6 (x''')^2 over the run, in
//! divided differences: features longer than the length l stay as they are. Where an offset would
//! pass its bound, w is the weight that just holds it there. (Whittaker, Proc. Edinburgh Math. Soc.
//! 41, 1923, with weights.)

use crate::piece::size;
use lostmotion_base::linalg::solve_banded;
use lostmotion_base::{AXES, Coords, math};

/// Most rounds of weights. Record 38 of the decisions: 7 to 50 are needed.
const MAX_ROUNDS: usize = 48;
/// Part of its bound that an offset is aimed at where it is held back, so that rounds that end
/// early stay within the bound. A choice: nearer to 1 uses more of the bound and passes it where
/// rounds end early.
const AIMED_PART: f64 = 0.9;
/// Part of the offset aimed at up to which a vertex counts as settled: its bound.
const SETTLED_ABOVE: f64 = 1.0 / AIMED_PART;
/// Part of the offset aimed at from which on a vertex counts as settled. A choice: higher takes
/// more rounds, lower holds vertices harder than needed.
const SETTLED_BELOW: f64 = 0.8;
/// Weight below which a vertex counts as free, so that its offset may be as small as it likes; 1 is
/// free.
const NEARLY_FREE_WEIGHT: f64 = 1.1;
/// Factor on the power with which a weight follows its offset, as long as that stays on one side of
/// its aim. A choice: larger overshoots, smaller takes more rounds.
const POWER_GROWTH: f64 = 1.5;
/// The same factor where the offset has changed sides. A choice: smaller settles more surely and
/// more slowly.
const POWER_DECAY: f64 = 0.7;
/// Bounds of that power. The upper one is tuned (8 before).
const POWER_BOUNDS: [f64; 2] = [0.75, 3.0];
/// Smallest part of an offset that a weight follows, so that no weight falls to nothing at once.
const LEAST_PART: f64 = 1e-3;
/// Points on either side of a vertex that its third differences reach.
const DIFFERENCE_REACH: usize = 3;

/// Points along a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) p: Coords,
    /// Distance along the run.
    pub(super) u: f64,
    /// How far it may be moved; 0 if it is not to be moved.
    pub(super) bound: f64,
}

/// Offsets of the points; `length` is l.
pub(super) fn offsets(points: &[Point], length: f64) -> Vec<Coords> {
    let linear = |pair: &[Point]| pair[0].p.0[3..] == pair[1].p.0[3..];
    if points.windows(2).all(linear) {
        offsets_of::<3>(points, length)
    } else {
        offsets_of::<AXES>(points, length)
    }
}

/// The same where only the first N axes move.
fn offsets_of<const N: usize>(points: &[Point], length: f64) -> Vec<Coords> {
    let mut weights = vec![Weight::FREE; points.len()];
    let (stiffness, pull) = stiffness::<N>(points, length);
    let mut offsets = vec![Coords::ZERO; points.len()];
    // Iteration on the multipliers: solve for the offsets, then raise the weights of vertices that
    // pass their bounds and lower the others.
    for _ in 0..MAX_ROUNDS {
        for (offset, solved) in offsets
            .iter_mut()
            .zip(solve(points, &weights, &stiffness, &pull))
        {
            offset.0[..N].copy_from_slice(&solved);
        }
        let mut settled = true;
        for ((point, offset), weight) in points
            .iter()
            .zip(&offsets)
            .zip(&mut weights)
            .filter(|((point, _), _)| point.bound > 0.0)
        {
            settled &= weight.adapt(size(offset) / (AIMED_PART * point.bound));
        }
        if settled {
            break;
        }
    }
    // The rounds may end early, so that the bounds are imposed at last.
    let held = points
        .iter()
        .zip(&offsets)
        .filter(|(point, _)| point.bound > 0.0);
    let most = held
        .map(|(point, offset)| size(offset) / point.bound)
        .fold(0.0, f64::max);
    // All of them alike: one vertex alone would be a kink.
    if most > 1.0 {
        offsets
            .iter_mut()
            .for_each(|offset| *offset = *offset * (1.0 / most));
    }
    offsets
}

/// What holds a vertex where it is.
#[derive(Clone, Copy, Debug)]
struct Weight {
    value: f64,
    /// The power of the part of its bound that an offset has by which its weight changes.
    power: f64,
    /// Whether the offset passed its bound the last time.
    over: bool,
}

impl Weight {
    const FREE: Weight = Weight {
        value: 1.0,
        power: 1.5,
        over: false,
    };

    /// Grows where an offset passes its bound and falls where it needs less, faster as long as it
    /// goes the same way; whether the offset was as it should be.
    fn adapt(&mut self, part: f64) -> bool {
        let settled =
            part <= SETTLED_ABOVE && (part >= SETTLED_BELOW || self.value < NEARLY_FREE_WEIGHT);
        let over = part > 1.0;
        // An offset that stays on one side is followed ever faster, one that oscillates more
        // slowly.
        self.power = if over == self.over {
            (POWER_GROWTH * self.power).min(POWER_BOUNDS[1])
        } else {
            (POWER_DECAY * self.power).max(POWER_BOUNDS[0])
        };
        self.over = over;
        self.value = (self.value * math::pow(part.max(LEAST_PART), self.power)).max(1.0);
        settled
    }
}

/// The matrix of the bending, by rows from the diagonal on, and its product with the points,
/// negative.
fn stiffness<const N: usize>(
    points: &[Point],
    length: f64,
) -> (Vec<[f64; DIFFERENCE_REACH + 1]>, Vec<[f64; N]>) {
    let (mut rows, mut pull) = (
        vec![[0.0; DIFFERENCE_REACH + 1]; points.len()],
        vec![[0.0; N]; points.len()],
    );
    let cube = length * length * length;
    for (k, four) in points.windows(DIFFERENCE_REACH + 1).enumerate() {
        // Each four points stand for a third of the way that they span, in an integral of squares.
        let factor = cube * ((four[DIFFERENCE_REACH].u - four[0].u) / 3.0).sqrt();
        let mut d = [0.0; DIFFERENCE_REACH + 1];
        // Third divided differences on uneven points.
        for (m, d) in d.iter_mut().enumerate() {
            let product: f64 = (0..=DIFFERENCE_REACH)
                .filter(|l| *l != m)
                .map(|l| four[m].u - four[l].u)
                .product();
            *d = 6.0 * factor / product;
        }
        // Relative to the first point, since large coordinates would cost digits.
        let third: [f64; N] = std::array::from_fn(|axis| {
            four.iter().zip(d).fold(0.0, |sum, (point, d)| {
                sum + (point.p.0[axis] - four[0].p.0[axis]) * d
            })
        });
        // Normal equations: d d' to the matrix, the present third difference to the right side.
        for (i, di) in d.iter().enumerate() {
            for (pull, third) in pull[k + i].iter_mut().zip(third) {
                *pull -= third * di;
            }
            for (j, dj) in d.iter().enumerate().skip(i) {
                rows[k + i][j - i] += di * dj;
            }
        }
    }
    (rows, pull)
}

/// Offsets for given weights: a banded system, three entries to either side of the diagonal.
fn solve<const N: usize>(
    points: &[Point],
    weights: &[Weight],
    stiffness: &[[f64; DIFFERENCE_REACH + 1]],
    pull: &[[f64; N]],
) -> Vec<[f64; N]> {
    let n = points.len();
    let mut rows = stiffness.to_vec();
    let mut x = pull.to_vec();
    for i in 0..n {
        if points[i].bound > 0.0 {
            // The weight stands for half the way to either neighbour.
            let (before, after) = (points[i.saturating_sub(1)].u, points[(i + 1).min(n - 1)].u);
            rows[i][0] += weights[i].value * 0.5 * (after - before);
        } else {
            // A fixed vertex: a row of identity, without couplings from the rows before.
            rows[i] = [1.0, 0.0, 0.0, 0.0];
            x[i] = [0.0; N];
            for back in 1..=DIFFERENCE_REACH.min(i) {
                rows[i - back][back] = 0.0;
            }
        }
    }
    solve_banded(&mut rows, &mut x);
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A noisy sine: what the noise does to the third differences goes, the sine stays, and no
    /// point moves too far.
    #[test]
    fn noise_goes_and_the_curve_stays() {
        let (h, bound) = (0.2, 0.008);
        let noise = |i: usize| 0.005 * math::sin(12.9898 * (i * i) as f64);
        let exact = |i: usize| 2.0 * math::sin(0.314 * h * i as f64);
        let points: Vec<Point> = (0..200)
            .map(|i| Point {
                p: Coords::xyz(h * i as f64, 0.0, exact(i) + noise(i)),
                u: h * i as f64,
                bound: if i % 199 < 3 { 0.0 } else { bound },
            })
            .collect();
        let offsets = offsets(&points, 0.8);
        let third = |z: &dyn Fn(usize) -> f64| {
            (20..170)
                .map(|i| ((z(i + 3) - 3.0 * z(i + 2) + 3.0 * z(i + 1) - z(i)) / (h * h * h)).abs())
                .fold(0.0, f64::max)
        };
        let faired = |i: usize| points[i].p.0[2] + offsets[i].0[2];
        assert!(
            offsets
                .iter()
                .zip(&points)
                .all(|(e, point)| size(e) <= point.bound + 1e-15)
        );
        assert!((20..180).all(|i| (faired(i) - exact(i)).abs() < 0.006));
        let (before, after, ideal) = (third(&|i| points[i].p.0[2]), third(&faired), third(&exact));
        assert!(
            after < 2.0 * ideal && before > 10.0 * ideal,
            "{before} {after} {ideal}"
        );
        assert!(
            offsets
                .iter()
                .all(|e| (0..AXES).all(|axis| axis == 2 || e.0[axis].abs() < 1e-9))
        );
    }

    /// What is minimised, over the windows and points from `from` to `to`.
    fn energy(z: &[f64], u: &[f64], e: &[f64], length: f64, from: usize, to: usize) -> f64 {
        let third = |k: usize| {
            let part = |m: usize| {
                z[m] / (k..k + 4)
                    .filter(|l| *l != m)
                    .map(|l| u[m] - u[l])
                    .product::<f64>()
            };
            6.0 * (k..k + 4).map(part).sum::<f64>()
        };
        let bend =
            |k: usize| math::pow(length, 6.0) * third(k) * third(k) * (u[k + 3] - u[k]) / 3.0;
        let pull =
            |k: usize| e[k] * e[k] * 0.5 * (u[(k + 1).min(u.len() - 1)] - u[k.saturating_sub(1)]);
        (from.saturating_sub(3)..(to + 1).min(u.len() - 3))
            .map(bend)
            .sum::<f64>()
            + (from..to + 1).map(pull).sum::<f64>()
    }

    /// Bounds that most of the noise passes: as smooth as what moving one vertex after the other
    /// finds, ten thousand times, within the bounds that are aimed at.
    #[test]
    fn held_vertices_leave_no_kinks() {
        let (n, bound, length) = (40, 0.003, 0.7);
        let u: Vec<f64> = (0..n)
            .map(|i| 0.2 * i as f64 + 0.05 * math::sin(i as f64))
            .collect();
        let given: Vec<f64> = (0..n)
            .map(|i| math::sin(0.4 * u[i]) + 0.006 * math::sin(12.9898 * (i * i) as f64))
            .collect();
        let held = |i: usize| i < 2 || i + 2 >= n;
        let point = |i: usize| Point {
            p: Coords::xyz(u[i], 0.0, given[i]),
            u: u[i],
            bound: if held(i) { 0.0 } else { bound },
        };
        let points: Vec<Point> = (0..n).map(point).collect();
        let ours: Vec<f64> = offsets(&points, length)
            .iter()
            .map(|offset| offset.0[2])
            .collect();
        assert!(ours.iter().all(|e| e.abs() <= bound * (1.0 + 1e-12)));
        let (mut z, mut e) = (given.clone(), vec![0.0; n]);
        for _ in 0..10_000 {
            for k in (0..n).filter(|k| !held(*k)) {
                let mut at = |offset: f64| {
                    (e[k], z[k]) = (offset, given[k] + offset);
                    energy(&z, &u, &e, length, k, k)
                };
                let (low, middle, high) = (at(-1.0), at(0.0), at(1.0));
                at((0.5 * (low - high) / (low - 2.0 * middle + high))
                    .clamp(-AIMED_PART * bound, AIMED_PART * bound));
            }
        }
        let all = |e: &[f64]| {
            let z: Vec<f64> = given.iter().zip(e).map(|(z, e)| z + e).collect();
            energy(&z, &u, e, length, 0, n - 1)
        };
        let (best, found) = (all(&e), all(&ours));
        assert!((found / best - 1.0).abs() < 0.1, "{best} {found}");
    }
}
