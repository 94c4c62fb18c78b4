//! Every joint carries the axis of its own name.
//!
//! Joint = program coordinate, plus the tool's offset on X, Y and Z. Rotary axes are joints like
//! the others: the program gives coordinates that already hold for the tilted part (no
//! tool-centre-point control), as on a mill with a rotary table whose CAM knows the table.

use crate::{JointMap, KindSpec, Kinematics, KinematicsError, Reach, ToolPose};
use lostmotion_base::{Coords, Jet};
use serde::{Deserialize, Serialize};

/// Describes a machine whose joints carry the axes of their own names: there are no keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CartesianSpec {}

impl KindSpec for CartesianSpec {
    const SUMMARY: &'static str = "one joint per axis; rotary axes without tool-centre-point";

    fn build(&self, _: &Reach) -> Result<Box<dyn Kinematics>, String> {
        Ok(Box::new(Cartesian))
    }
}

/// Every joint carries the axis of its own name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cartesian;

impl Kinematics for Cartesian {
    fn name(&self) -> &'static str {
        CartesianSpec::KIND
    }

    fn joint_map(&self) -> JointMap {
        JointMap::Shifted
    }

    fn inverse(&self, program: &Coords, tool: &[f64; 3]) -> Result<Coords, KinematicsError> {
        Ok(*program + Coords::xyz(tool[0], tool[1], tool[2]))
    }

    fn inverse_jet(
        &self,
        program: &[Jet; 9],
        tool: &[f64; 3],
    ) -> Result<[Jet; 9], KinematicsError> {
        let mut joints = *program;
        for (joint, offset) in joints.iter_mut().zip(tool) {
            joint.0[0] += offset;
        }
        Ok(joints)
    }

    fn forward(&self, joints: &Coords, tool: &[f64; 3]) -> Coords {
        *joints - Coords::xyz(tool[0], tool[1], tool[2])
    }

    /// The tip in program coordinates and an axis along +Z: where rotary axes sit is not known
    /// here, so an orientation in the part's frame cannot be told.
    fn tool_pose(&self, joints: &Coords, tool: &[f64; 3]) -> ToolPose {
        ToolPose {
            tip: self.forward(joints, tool).linear(),
            axis: [0.0, 0.0, 1.0],
        }
    }
}
