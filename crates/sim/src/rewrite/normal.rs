//! What is left besides the gap, taken off along the normal: wind-up, and what the servo leaves of an
//! arc.
//!
//! Each stretch has an error that its middle tells: of a line the mean offset normal to it; of an arc an
//! offset `t` of its centre, as wind-up leaves it, and one `r` of its radius, as lag leaves it, so that at
//! the direction `u` from the centre it is `t . u + r`. Where two stretches meet without a take-up, one
//! point serves both:
//!
//! ```text
//! minimise |P1 v + e1|^2 + |P2 v + e2|^2 + lambda |v|^2      P = I - t t', t the tangent there
//! ```
//! At a corner `v` meets both; where the path goes straight on, it is the mean of both.

use super::{Original, ROUNDING_MM, STILL_MM, Stretch};
use lostmotion_base::linalg::{Matrix, cholesky, cholesky_solve};
use lostmotion_base::vec::{dot, norm};
use lostmotion_path::Curve;

/// Part of a stretch at either end that tells nothing of its middle, and the length from which on a
/// stretch has one, mm. Choices.
const ENDS: f64 = 0.1;
const HAS_A_MIDDLE_MM: f64 = 1.0;
/// Weight of a small displacement beside one that meets both neighbours. A choice: stretches that turn
/// by less than some ten degrees share the mean.
const LEAST_TURN: f64 = 0.02;

/// Weight of small offsets of an arc, in parts of its points: a short one does not tell its centre from
/// its radius. A choice.
const SMALL: f64 = 1e-3;

/// The error of a stretch: sums over its points, mm.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Off {
    /// Of a line the offset normal to it; of an arc the right-hand side of its equations, for the
    /// centre in the plane's axes and the radius.
    right: [f64; 3],
    matrix: Matrix<3>,
    /// Of an arc the offset along its plane's normal.
    aside: f64,
    count: u32,
}

/// The offset of a stretch, mm: of a line normal to it, and 0; of an arc those of its centre in the plane's
/// axes, of its radius, and along the plane's normal.
type Offset = [f64; 4];

impl Off {
    fn mean(&self, is_arc: bool) -> Offset {
        let mean = 1.0 / f64::from(self.count);
        let right = self.right.map(|sum| sum * mean);
        let [x, y, z] = right;
        if !is_arc {
            return [x, y, z, 0.0];
        }
        let mut matrix = self.matrix.map(|row| row.map(|sum| sum * mean));
        for (i, row) in matrix.iter_mut().enumerate() {
            row[i] += SMALL;
        }
        let [first, second, radius] = cholesky_solve(&cholesky(&matrix, SMALL), &right);
        [first, second, radius, self.aside * mean]
    }
}

/// Displacements of the ends of every stretch, mm.
#[derive(Clone, Debug, Default)]
pub(super) struct Shifts {
    ends: Vec<[[f64; 3]; 2]>,
    centers: Vec<[f64; 2]>,
}

impl Shifts {
    /// Those of the start and the end of a stretch, counted over the whole program.
    pub(super) fn of(&self, stretch: usize) -> [[f64; 3]; 2] {
        self.ends.get(stretch).copied().unwrap_or_default()
    }

    /// That of an arc's centre, in the axes of its plane.
    pub(super) fn center(&self, stretch: usize) -> [f64; 2] {
        self.centers.get(stretch).copied().unwrap_or_default()
    }

    /// The largest of an end, mm.
    pub(super) fn most(&self) -> f64 {
        let sizes = self.ends.iter().flatten().map(|shift| norm(*shift));
        sizes.fold(0.0, f64::max)
    }
}

/// The errors of a program's stretches, added up over the rounds.
#[derive(Debug)]
pub(super) struct Normals<'a> {
    steps: &'a [Original],
    /// The stretches of each move.
    stretches: &'a [Vec<Stretch>],
    /// The first stretch of each move, counted over the whole program.
    first: Vec<usize>,
    /// What is taken off, of each stretch.
    taken: Vec<Offset>,
}

impl<'a> Normals<'a> {
    pub(super) fn new(steps: &'a [Original], stretches: &'a [Vec<Stretch>]) -> Normals<'a> {
        let mut first = Vec::with_capacity(steps.len());
        let mut count = 0;
        for own in stretches {
            first.push(count);
            count += own.len();
        }
        Normals {
            steps,
            stretches,
            first,
            taken: vec![Default::default(); count],
        }
    }

    /// Room for the errors of all stretches.
    pub(super) fn room(&self) -> Vec<Off> {
        vec![Off::default(); self.taken.len()]
    }

    /// Adds a point of a move to the error of its stretch: `s` is that of its foot.
    pub(super) fn add(&self, off: &mut [Off], step: usize, s: f64, at: [f64; 3]) {
        let (Some(original), Some(own), Some(first)) = (
            self.steps.get(step),
            self.stretches.get(step),
            self.first.get(step),
        ) else {
            return;
        };
        let Some(number) = own.iter().position(|stretch| s <= stretch.range[1]) else {
            return;
        };
        let [from, to] = own[number].range;
        let ends = if to - from > HAS_A_MIDDLE_MM {
            ENDS * (to - from)
        } else {
            0.0
        };
        if s < from + ends || s > to - ends {
            return;
        }
        let Some(off) = off.get_mut(first + number) else {
            return;
        };
        let foot = original.curve.point(s).linear();
        let error: [f64; 3] = std::array::from_fn(|axis| at[axis] - foot[axis]);
        if let Some(outward) = outward(&original.curve, foot) {
            let radial = dot(error, outward);
            off.aside += error[original.curve.plane().axes()[2]];
            let row = arc_row(&original.curve, outward);
            for i in 0..3 {
                for j in 0..3 {
                    off.matrix[i][j] += row[i] * row[j];
                }
                off.right[i] += row[i] * radial;
            }
        } else {
            let tangent = original.curve.tangent(s);
            let along = dot(error, tangent);
            for ((sum, error), tangent) in off.right.iter_mut().zip(error).zip(tangent) {
                *sum += error - along * tangent;
            }
        }
        off.count += 1;
    }

    /// Takes what was found off, besides what is taken off already. A line without a point has what the
    /// line before it has.
    pub(super) fn take(&mut self, off: &[Off]) {
        let mut before = None;
        for (step, own) in self.stretches.iter().enumerate() {
            let is_arc = matches!(self.steps[step].curve, Curve::Arc(_));
            let from = self.first[step];
            for (taken, off) in self.taken[from..from + own.len()]
                .iter_mut()
                .zip(&off[from..])
            {
                let found = if off.count > 0 {
                    Some(off.mean(is_arc))
                } else {
                    before.filter(|_| !is_arc)
                };
                before = found.filter(|_| !is_arc);
                for (taken, found) in taken.iter_mut().zip(found.unwrap_or_default()) {
                    *taken += found;
                }
            }
        }
    }

    /// What is taken off at a place of a stretch, mm.
    fn at(&self, step: usize, number: usize, s: f64) -> [f64; 3] {
        let curve = &self.steps[step].curve;
        let taken = self.taken[self.first[step] + number];
        match outward(curve, curve.point(s).linear()) {
            Some(outward) => {
                let [first, second, radius, aside] = taken;
                let radial = dot(arc_row(curve, outward), [first, second, radius]);
                let mut offset = outward.map(|part| part * radial);
                offset[curve.plane().axes()[2]] += aside;
                offset
            }
            None => [taken[0], taken[1], taken[2]],
        }
    }

    /// The displacements, of at most so many mm. Where an axis reverses its gap is taken up, so that
    /// the ends there need not meet; `half` are the half gaps.
    pub(super) fn shifts(&self, half: [f64; 3], most_mm: f64) -> Shifts {
        let mut shifts = Shifts {
            ends: vec![Default::default(); self.taken.len()],
            centers: vec![Default::default(); self.taken.len()],
        };
        let bounded = |v: [f64; 3]| v.map(|part| part * (most_mm / norm(v)).min(1.0));
        // The last cut's last stretch, as long as nothing but a cut follows it.
        let mut last: Option<(usize, usize)> = None;
        let mut side = [0.0; 3];
        for (step, own) in self.stretches.iter().enumerate() {
            let is_cut = !self.steps[step].rapid;
            for (number, stretch) in own.iter().enumerate() {
                let mut turns = false;
                for ((side, direction), half) in side.iter_mut().zip(stretch.direction).zip(half) {
                    turns |= direction != 0.0 && *side != direction && half > 0.0;
                    if direction != 0.0 {
                        *side = direction;
                    }
                }
                if !is_cut {
                    continue;
                }
                let curve = &self.steps[step].curve;
                let index = self.first[step] + number;
                let [from, to] = stretch.range;
                let minus = |v: [f64; 3]| v.map(|part| -part);
                shifts.ends[index] = [from, to].map(|s| bounded(minus(self.at(step, number, s))));
                if matches!(curve, Curve::Arc(_)) {
                    let [first, second, ..] = self.taken[index];
                    let [first, second, _] = bounded([-first, -second, 0.0]);
                    shifts.centers[index] = [first, second];
                }
                let before = last.replace((step, number));
                let Some((earlier, piece)) = before.filter(|_| !turns) else {
                    continue;
                };
                let other = &self.steps[earlier].curve;
                let end = self.stretches[earlier][piece].range[1];
                let apart: [f64; 3] = {
                    let (a, b) = (other.point(end).linear(), curve.point(from).linear());
                    std::array::from_fn(|axis| a[axis] - b[axis])
                };
                if norm(apart) > STILL_MM.max(1e-6) {
                    continue;
                }
                let joint = bounded(meet([
                    (other.tangent(end), self.at(earlier, piece, end)),
                    (curve.tangent(from), self.at(step, number, from)),
                ]));
                shifts.ends[self.first[earlier] + piece][1] = joint;
                shifts.ends[index][0] = joint;
            }
            if !is_cut {
                last = None;
            }
        }
        // A rapid goes to where the cut behind it begins.
        for step in 1..self.steps.len() {
            if self.steps[step - 1].rapid && !self.steps[step].rapid {
                let start = shifts.ends[self.first[step]][0];
                shifts.ends[self.first[step] - 1][1] = start;
            }
        }
        // What a program's digits hardly tell would make a helix of an arc in a plane.
        for part in shifts.ends.iter_mut().flatten().flatten() {
            if part.abs() <= ROUNDING_MM {
                *part = 0.0;
            }
        }
        shifts
    }
}

/// The direction from an arc's centre to a point of it; `None` of a line.
fn outward(curve: &Curve, point: [f64; 3]) -> Option<[f64; 3]> {
    let Curve::Arc(arc) = curve else {
        return None;
    };
    let [first, second, _] = curve.plane().axes();
    let mut outward = [0.0; 3];
    outward[first] = point[first] - arc.center()[0];
    outward[second] = point[second] - arc.center()[1];
    let radius = norm(outward);
    (radius > 0.0).then(|| outward.map(|part| part / radius))
}

/// What an offset of an arc's centre and its radius are worth in a direction from the centre.
fn arc_row(curve: &Curve, outward: [f64; 3]) -> [f64; 3] {
    let [first, second, _] = curve.plane().axes();
    [outward[first], outward[second], 1.0]
}

/// The displacement of a point that takes off what both stretches there have, of tangents and errors.
fn meet(both: [([f64; 3], [f64; 3]); 2]) -> [f64; 3] {
    let mut matrix: Matrix<3> = [[0.0; 3]; 3];
    let mut right = [0.0; 3];
    for (tangent, error) in both {
        let along = dot(tangent, error);
        for i in 0..3 {
            for j in 0..3 {
                let unit = if i == j { 1.0 + 0.5 * LEAST_TURN } else { 0.0 };
                matrix[i][j] += unit - tangent[i] * tangent[j];
            }
            right[i] -= error[i] - along * tangent[i];
        }
    }
    cholesky_solve(&cholesky(&matrix, LEAST_TURN * LEAST_TURN), &right)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A corner of 90 degrees meets both errors, a straight way their mean.
    #[test]
    fn one_point_serves_both_neighbours() {
        let x = [1.0, 0.0, 0.0];
        let y = [0.0, 1.0, 0.0];
        let near = |a: [f64; 3], b: [f64; 3]| {
            assert!(
                (0..3).all(|axis| (a[axis] - b[axis]).abs() < 0.03 * 5e-3),
                "{a:?} {b:?}"
            );
        };
        near(
            meet([(x, [0.0, 3e-3, 0.0]), (y, [5e-3, 0.0, 0.0])]),
            [-5e-3, -3e-3, 0.0],
        );
        near(
            meet([(x, [0.0, 3e-3, 0.0]), (x, [0.0, 1e-3, 0.0])]),
            [0.0, -2e-3, 0.0],
        );
    }
}
