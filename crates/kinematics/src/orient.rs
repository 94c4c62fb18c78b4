//! From directions of the tool to rotary joints: both solutions of every direction, and the way
//! through a list of them that turns least, stays in the travel, and never jumps.
//!
//! The direction of the tool in the workpiece's frame is R(u1, a) R(u2, b) t for two rotary joints
//! in the order from the workpiece, whatever sits between them, so that one closed form
//! (`rotation::two`) serves tables, heads and nutating ones alike. It has two solutions, and at the
//! pole (the direction on u1) any angle of the first joint will do.

mod branch;
mod follow;

pub use follow::OrientedStep;

use crate::Reach;
use crate::chain::{Chain, ChainJoint};
use crate::rotation;
use lostmotion_base::vec::{add, dot, norm, sub, unit};
use lostmotion_base::{AxisId, Coords, math};

/// Two rotary joints (or one) that turn the tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Orientation {
    /// In the order from the workpiece.
    joints: Vec<ChainJoint>,
    travel: Vec<Option<(f64, f64)>>,
    tool: [f64; 3],
    tolerance_rad: f64,
}

/// Positions of the rotary joints, rad, in the order from the workpiece; for one joint the second
/// is 0.
pub type Angles = [f64; 2];

/// A direction that the machine cannot bring the tool into.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OrientError {
    /// No angles give it.
    #[error("the rotary axes cannot turn the tool to the direction {:.4} {:.4} {:.4}", .direction[0], .direction[1], .direction[2])]
    Unreachable {
        /// Unit vector in the workpiece's frame.
        direction: [f64; 3],
    },
    /// Some do, but they lie beyond the travel.
    #[error("the rotary axes would leave their travel for the direction {:.4} {:.4} {:.4}", .direction[0], .direction[1], .direction[2])]
    Travel {
        /// Unit vector in the workpiece's frame.
        direction: [f64; 3],
    },
    /// The way there is not continuous within the travel and the orientation tolerance.
    #[error(
        "the tool cannot stay on its way to the direction {:.4} {:.4} {:.4}: the rotary axes would have to change over, which takes it {leaves_deg:.2} degrees away (tolerance {tolerance_deg} degrees)",
        .direction[0], .direction[1], .direction[2]
    )]
    Jump {
        /// Unit vector in the workpiece's frame.
        direction: [f64; 3],
        /// How far the tool would leave the great circle, degrees.
        leaves_deg: f64,
        /// How far it may, degrees.
        tolerance_deg: f64,
    },
}

impl Orientation {
    /// For a chain with one or two rotary joints; `None` for others.
    pub(crate) fn new(chain: &Chain, reach: &Reach, tolerance_rad: f64) -> Option<Orientation> {
        let joints: Vec<ChainJoint> = chain
            .joints
            .iter()
            .filter(|joint| joint.rotary)
            .copied()
            .collect();
        // Two angles give a direction; a third would leave a choice that no word makes.
        if joints.is_empty() || joints.len() > 2 {
            return None;
        }
        let travel = joints
            .iter()
            .map(|joint| reach.0[joint.axis.index()])
            .collect();
        Some(Orientation {
            joints,
            travel,
            tool: chain.axis_at_zero(),
            tolerance_rad,
        })
    }

    /// The axes of its joints in the order from the workpiece.
    pub fn axes(&self) -> impl Iterator<Item = AxisId> + '_ {
        self.joints.iter().map(|joint| joint.axis)
    }

    /// How far the direction may leave the programmed one, rad.
    pub fn tolerance_rad(&self) -> f64 {
        self.tolerance_rad
    }

    /// Their positions out of all joints'.
    pub fn angles(&self, joints: &Coords) -> Angles {
        let mut angles = [0.0; 2];
        for (angle, joint) in angles.iter_mut().zip(&self.joints) {
            *angle = joints[joint.axis];
        }
        angles
    }

    /// All joints with these positions of the rotary ones.
    #[must_use]
    pub fn with(&self, joints: &Coords, angles: Angles) -> Coords {
        let mut joints = *joints;
        for (angle, joint) in angles.iter().zip(&self.joints) {
            joints[joint.axis] = *angle;
        }
        joints
    }

    /// Direction of the tool, from tip to spindle, in the workpiece's frame.
    pub fn direction(&self, angles: Angles) -> [f64; 3] {
        let joints = self.joints.iter().zip(angles).rev();
        joints.fold(self.tool, |direction, (joint, angle)| {
            joint.carry_direction(direction, angle)
        })
    }

    /// Every pair of angles (within a turn) that gives a direction; `None` for the first of a pair
    /// where any does. Empty if the direction cannot be had.
    pub fn solutions(&self, direction: [f64; 3]) -> Vec<(Option<f64>, f64)> {
        let Some(direction) = unit(direction) else {
            return Vec::new();
        };
        match self.joints.as_slice() {
            [first, second] => {
                // The closed form counts from the joints' zeros, and in the sense of their
                // directions.
                let found = rotation::two(&first.turning, &second.turning, self.tool, direction);
                let positions =
                    |(a, b): (Option<f64>, f64)| (a.map(|a| first.position(a)), second.position(b));
                found.into_iter().flatten().map(positions).collect()
            }
            [only] => {
                // One joint reaches the directions of a cone alone.
                let found = rotation::one(&only.turning, self.tool, direction);
                found
                    .into_iter()
                    .map(|angle| (angle.map(|a| only.position(a)), 0.0))
                    .collect()
            }
            _ => Vec::new(),
        }
    }

    /// Angle between a direction and the nearer pole of the first joint, rad; `None` where there is
    /// no pole within reach.
    fn pole_distance(&self, direction: [f64; 3]) -> Option<f64> {
        let [first, _] = self.joints.as_slice() else {
            return None;
        };
        // The pole is a direction of the tool along the first joint's axis: turning that joint
        // does not change it.
        let along = dot(first.direction(), direction);
        let pole = first.direction().map(|c| c * along.signum());
        self.solutions(pole)
            .first()
            .map(|_| angle_between(pole, direction))
    }
}

/// Angle between two unit vectors, rad; exact for small ones too.
pub(crate) fn angle_between(a: [f64; 3], b: [f64; 3]) -> f64 {
    2.0 * math::atan2(norm(sub(a, b)), norm(add(a, b)))
}
