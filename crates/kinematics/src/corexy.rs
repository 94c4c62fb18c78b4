//! CoreXY: two motors that stand still move one belt each, and together the carriage.
//!
//! a = x + y and b = x - y are the ways of the belts, which are the joints X and Y; Z and all
//! others are as programmed. The tool's offset is added before.

use crate::{KindSpec, Kinematics, KinematicsError, Reach, ToolPose};
use lostmotion_base::{AXES, Coords, Jet, Real};
use serde::{Deserialize, Serialize};

/// Describes a CoreXY machine: there are no keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoreXySpec {}

impl KindSpec for CoreXySpec {
    const SUMMARY: &'static str = "two belts that move X and Y together";

    fn build(&self, _: &Reach) -> Result<Box<dyn Kinematics>, String> {
        Ok(Box::new(CoreXy))
    }
}

/// Two belts for X and Y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CoreXy;

fn joints<R: Real>(program: &[R; AXES], tool: &[f64; 3]) -> [R; AXES] {
    let [x, y, z] = [0, 1, 2].map(|i| program[i] + R::constant(tool[i]));
    let mut joints = *program;
    joints[..3].copy_from_slice(&[x + y, x - y, z]);
    joints
}

impl Kinematics for CoreXy {
    fn name(&self) -> &'static str {
        CoreXySpec::KIND
    }

    fn inverse(&self, program: &Coords, tool: &[f64; 3]) -> Result<Coords, KinematicsError> {
        Ok(Coords(joints(&program.0, tool)))
    }

    fn inverse_jet(
        &self,
        program: &[Jet; 9],
        tool: &[f64; 3],
    ) -> Result<[Jet; 9], KinematicsError> {
        Ok(joints(program, tool))
    }

    fn forward(&self, joints: &Coords, tool: &[f64; 3]) -> Coords {
        let [a, b, z] = joints.linear();
        let mut program = *joints;
        program.0[..3].copy_from_slice(&[
            0.5 * (a + b) - tool[0],
            0.5 * (a - b) - tool[1],
            z - tool[2],
        ]);
        program
    }

    fn tool_pose(&self, joints: &Coords, tool: &[f64; 3]) -> ToolPose {
        ToolPose {
            tip: self.forward(joints, tool).linear(),
            axis: [0.0, 0.0, 1.0],
        }
    }
}
