//! What Newton's method works on: the way still to go, and how the joints change it.

use super::{Numeric, Pose};
use lostmotion_base::vec::{Vec3, across, add, cross, dot, norm, scale, sub};
use lostmotion_base::{AXES, Coords, Real};
use nalgebra::SMatrix;

/// Length by which turns enter the residual, mm per rad: about the size of a tool.
pub(super) const RESIDUAL_ARM_MM: f64 = 100.0;
/// Ratio of the smallest to the largest pivot of J J' below which the pose is singular.
pub(super) const SINGULAR_RATIO: f64 = 1e-10;

pub(super) type Jacobian = SMatrix<f64, 6, AXES>;
pub(super) type Residual<R> = [R; 6];

impl Numeric {
    /// With five joints the turn about the tool's own axis is left out.
    pub(super) fn rows(&self) -> usize {
        if self.free.len() == 5 { 5 } else { 6 }
    }

    /// Pivots of J J' in falling order: squares of how fast the tool can be moved, for the weakest
    /// directions left last.
    pub(super) fn pivots(&self, joints: &Coords, tool: &[f64; 3]) -> Vec<f64> {
        let jacobian = self.jacobian(joints, tool);
        // Elimination with full pivoting on the diagonal: J J' is symmetric.
        let mut square = jacobian * jacobian.transpose();
        let mut pivots = Vec::new();
        for step in 0..6 {
            let (mut at, mut largest) = (step, 0.0);
            for row in step..6 {
                if square[(row, row)] > largest {
                    (at, largest) = (row, square[(row, row)]);
                }
            }
            if largest <= 0.0 {
                break;
            }
            pivots.push(largest);
            square.swap_rows(step, at);
            square.swap_columns(step, at);
            for row in step + 1..6 {
                // Schur complement: what is left once the directions so far are held.
                let factor = square[(row, step)] / largest;
                for column in step + 1..6 {
                    square[(row, column)] -= factor * square[(step, column)];
                }
            }
        }
        pivots
    }

    pub(super) fn jacobian(&self, joints: &Coords, tool: &[f64; 3]) -> Jacobian {
        // Turns are taken in the tool's frame and times an arm, so that all rows are lengths.
        let mut matrix = Jacobian::zeros();
        let frame = self.frame(joints);
        for (joint, (linear, angular)) in self
            .chain
            .joints
            .iter()
            .zip(self.chain.jacobian(joints, tool))
        {
            let column = joint.axis.index();
            if !self.free.contains(joint.axis) {
                continue;
            }
            for row in 0..3 {
                matrix[(row, column)] = linear[row];
                matrix[(3 + row, column)] = RESIDUAL_ARM_MM * dot(frame[row], angular);
            }
            // The sixth row, the turn about the tool itself, is empty with five joints.
            if self.rows() == 5 {
                matrix[(5, column)] = 0.0;
            }
        }
        matrix
    }

    /// Directions in which turns are told: two across the tool and the tool's own.
    pub(super) fn frame(&self, joints: &Coords) -> [[f64; 3]; 3] {
        let axis = self.chain.axis(joints);
        let side = across(axis);
        [side, cross(axis, side), axis]
    }

    /// The way still to go: of the tip in mm, of the tool's frame as a rotation vector (to first
    /// order) times an arm.
    pub(super) fn residual<R: Real>(
        &self,
        target: &Pose<R>,
        joints: &[R; AXES],
        frame: &[[f64; 3]; 3],
        tool: &[f64; 3],
    ) -> Residual<R> {
        let here = Pose::of_joints(&self.chain, joints, tool);
        let way = sub(target.tip, here.tip);
        let half = R::constant(0.5 * RESIDUAL_ARM_MM);
        let turn: Vec3<R> = if self.rows() == 5 {
            // The tool's axis alone: how far it turns about itself does not count.
            scale(
                cross(here.columns[2], target.columns[2]),
                R::constant(RESIDUAL_ARM_MM),
            )
        } else {
            // Half the sum of the crosses of corresponding columns is the rotation vector to first order.
            let crosses = here
                .columns
                .iter()
                .zip(&target.columns)
                .map(|(here, there)| cross(*here, *there));
            scale(crosses.fold([R::constant(0.0); 3], add), half)
        };
        let told = |row: usize| dot(frame[row].map(R::constant), turn);
        let last = if self.rows() == 5 {
            R::constant(0.0)
        } else {
            told(2)
        };
        [way[0], way[1], way[2], told(0), told(1), last]
    }

    /// Whether the tool's frame is more than a right angle from the target's: the first-order turn
    /// vanishes at half a turn, too.
    pub(super) fn is_turned_away(
        &self,
        target: &Pose<f64>,
        joints: &Coords,
        tool: &[f64; 3],
    ) -> bool {
        let here = Pose::of_joints(&self.chain, &joints.0, tool);
        let count = if self.rows() == 5 { 2..3 } else { 0..3 };
        count
            .into_iter()
            .any(|i| dot(here.columns[i], target.columns[i]) < 0.0)
    }

    /// (J J' + lambda I)^-1, then J'.
    pub(super) fn inverse_of(jacobian: &Jacobian, damping: f64) -> Option<SMatrix<f64, AXES, 6>> {
        let mut square = jacobian * jacobian.transpose();
        let lambda = damping * square.trace() + f64::MIN_POSITIVE;
        // Marquardt's damping relative to the size of J J': steps stay finite at singular poses.
        for i in 0..6 {
            square[(i, i)] += lambda;
        }
        square
            .cholesky()
            .map(|factor| jacobian.transpose() * factor.inverse())
    }
}

pub(super) fn length(residual: &Residual<f64>) -> f64 {
    let [x, y, z, a, b, c] = *residual;
    let (linear, angular) = (norm([x, y, z]), norm([a, b, c]));
    (linear * linear + angular * angular).sqrt()
}
