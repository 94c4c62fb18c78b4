//! A machine whose Y axis is not square to X: `x = X - tan(a) Y`, `y = Y / cos(a)`.

use lostmotion::base::{AXES, Coords, Jet, Real, math};
use lostmotion::kinematics::{Kinematics, KinematicsError, ToolPose};

/// Y leans towards X by an angle.
#[derive(Clone, Copy, Debug)]
pub struct Skewed {
    sin: f64,
    cos: f64,
}

impl Skewed {
    /// With an angle in degrees.
    pub fn of_degrees(degrees: f64) -> Skewed {
        let (sin, cos) = math::sin_cos(degrees.to_radians());
        Skewed { sin, cos }
    }

    /// Joints of program coordinates: once for numbers, once for numbers with derivatives.
    fn joints<R: Real>(&self, program: &[R; AXES], tool: &[f64; 3]) -> [R; AXES] {
        let [x, y, z] = [0, 1, 2].map(|axis| program[axis] + R::constant(tool[axis]));
        let along = y * R::constant(1.0 / self.cos);
        let mut joints = *program;
        joints[..3].copy_from_slice(&[x - along * R::constant(self.sin), along, z]);
        joints
    }
}

impl Kinematics for Skewed {
    fn name(&self) -> &'static str {
        "skewed"
    }

    fn inverse(&self, program: &Coords, tool: &[f64; 3]) -> Result<Coords, KinematicsError> {
        Ok(Coords(self.joints(&program.0, tool)))
    }

    fn inverse_jet(
        &self,
        program: &[Jet; AXES],
        tool: &[f64; 3],
    ) -> Result<[Jet; AXES], KinematicsError> {
        Ok(self.joints(program, tool))
    }

    fn forward(&self, joints: &Coords, tool: &[f64; 3]) -> Coords {
        let [a, b, c] = joints.linear();
        let mut program = *joints;
        program.0[..3].copy_from_slice(&[
            a + b * self.sin - tool[0],
            b * self.cos - tool[1],
            c - tool[2],
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
