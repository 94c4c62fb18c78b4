//! SCARA: two arms that turn about upright axes, a quill, and a wrist that turns the tool.
//!
//! Joints: A the upper arm (from +X), B the forearm (from the upper arm), Z the quill, C the wrist
//! (from the forearm). Words: X Y Z the tip, C the tool's angle; the tool's offset counts in its
//! turned frame in X and Y and adds to Z. With r2 = x2 + y2 of the wrist, l1 `upper_arm_mm`, l2
//! `forearm_mm` and e = -1 for `elbow = "left"`, 1 for `"right"`,
//!
//! B = e atan2(sqrt(4 l1^2 l2^2 - k^2), k),  k = r2 - l1^2 - l2^2
//! A = atan2(y, x) - atan2(l2 sin B, l1 + l2 cos B),   wrist = C - A - B.
//!
//! The elbow stays on its side, so joints are continuous up to the cut of atan2 behind the base,
//! which the travel of A has to leave out.

use crate::kind::finite;
use crate::{KindSpec, Kinematics, KinematicsError, Layout, Reach, ToolPose};
use lostmotion_base::{AXES, AxisId, Coords, Jet, Real};
use serde::{Deserialize, Serialize};

const A: usize = AxisId::A as usize;
const B: usize = AxisId::B as usize;
const C: usize = AxisId::C as usize;

/// On which side of the way from base to tool the elbow is, seen from above looking out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Elbow {
    /// B is negative.
    Left,
    /// B is positive.
    Right,
}

/// Describes a SCARA.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScaraSpec {
    /// From a SCARA's first axis to its second, mm.
    pub upper_arm_mm: f64,
    /// From a SCARA's second axis to its wrist, mm.
    pub forearm_mm: f64,
    /// Side of a SCARA's elbow: `left` or `right`; `right` if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub elbow: Option<Elbow>,
}

/// Two arms, a quill, a wrist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scara {
    upper: f64,
    fore: f64,
    bend: f64,
}

impl KindSpec for ScaraSpec {
    const SUMMARY: &'static str = "two arms about upright axes (A, B), quill Z, wrist C";

    fn build(&self, _: &Reach) -> Result<Box<dyn Kinematics>, String> {
        let (upper, fore) = (self.upper_arm_mm, self.forearm_mm);
        finite("upper_arm_mm", &[upper])?;
        finite("forearm_mm", &[fore])?;
        if !(upper > 0.0 && fore > 0.0) {
            return Err(format!(
                "`upper_arm_mm` = {upper} and `forearm_mm` = {fore} have to be above 0"
            ));
        }
        let bend = match self.elbow {
            Some(Elbow::Left) => -1.0,
            Some(Elbow::Right) | None => 1.0,
        };
        Ok(Box::new(Scara { upper, fore, bend }))
    }
}

/// A vector turned about Z.
fn turn<R: Real>([x, y]: [R; 2], angle: R) -> [R; 2] {
    let (sin, cos) = (angle.sin(), angle.cos());
    [x * cos - y * sin, x * sin + y * cos]
}

impl Scara {
    fn joints<R: Real>(&self, program: &[R; AXES], tool: &[f64; 3]) -> Option<[R; AXES]> {
        let of = R::constant;
        // From the tip to the wrist's axis: the offset turns with the word C.
        let offset = turn([of(tool[0]), of(tool[1])], program[C]);
        let (x, y) = (program[0] + offset[0], program[1] + offset[1]);
        let (upper, fore) = (of(self.upper), of(self.fore));
        // Law of cosines for the elbow: k = 2 l1 l2 cos B.
        let k = x * x + y * y - upper * upper - fore * fore;
        let most = of(2.0 * self.upper * self.fore);
        // (2 l1 l2 sin B)^2 as a product: exact where the arm is nearly straight or folded.
        let square = (most - k) * (most + k);
        if square.value() <= 0.0 {
            return None;
        }
        let b = (square.sqrt() * of(self.bend)).atan2(k);
        let a = y.atan2(x) - (fore * b.sin()).atan2(upper + fore * b.cos());
        // The upper arm within half a turn of +X.
        let around = std::f64::consts::TAU * (-a.value() / std::f64::consts::TAU).round();
        let a = a + of(around);
        let mut joints = *program;
        // The tip's X and Y are the arms' business: there are no joints of these names.
        (joints[0], joints[1]) = (of(0.0), of(0.0));
        joints[2] = program[2] + of(tool[2]);
        (joints[A], joints[B], joints[C]) = (a, b, program[C] - a - b);
        Some(joints)
    }

    fn unreachable(&self, pose: Coords) -> KinematicsError {
        let (near, far) = ((self.upper - self.fore).abs(), self.upper + self.fore);
        KinematicsError::Unreachable {
            pose,
            why: format!("the arms reach from {near} to {far} mm around the base"),
        }
    }
}

impl Kinematics for Scara {
    fn name(&self) -> &'static str {
        ScaraSpec::KIND
    }

    fn inverse(&self, program: &Coords, tool: &[f64; 3]) -> Result<Coords, KinematicsError> {
        self.joints(&program.0, tool)
            .map(Coords)
            .ok_or_else(|| self.unreachable(*program))
    }

    fn inverse_jet(
        &self,
        program: &[Jet; 9],
        tool: &[f64; 3],
    ) -> Result<[Jet; 9], KinematicsError> {
        self.joints(program, tool)
            .ok_or_else(|| self.unreachable(Coords(program.map(|jet| jet.0[0]))))
    }

    fn forward(&self, joints: &Coords, tool: &[f64; 3]) -> Coords {
        let (a, b) = (joints.0[A], joints.0[B]);
        // Angles add up along the arm: each joint counts from the link before it.
        let c = a + b + joints.0[C];
        let (elbow, wrist) = (turn([self.upper, 0.0], a), turn([self.fore, 0.0], a + b));
        let offset = turn([tool[0], tool[1]], c);
        let mut program = *joints;
        program.0[..3].copy_from_slice(&[
            elbow[0] + wrist[0] - offset[0],
            elbow[1] + wrist[1] - offset[1],
            joints.0[2] - tool[2],
        ]);
        (program.0[A], program.0[B], program.0[C]) = (0.0, 0.0, c);
        program
    }

    fn layout(&self) -> Option<Layout> {
        let words = [AxisId::X, AxisId::Y, AxisId::Z, AxisId::C]
            .into_iter()
            .collect();
        let joints = [AxisId::Z, AxisId::A, AxisId::B, AxisId::C]
            .into_iter()
            .collect();
        Some(Layout { words, joints })
    }

    fn tool_pose(&self, joints: &Coords, tool: &[f64; 3]) -> ToolPose {
        ToolPose {
            tip: self.forward(joints, tool).linear(),
            axis: [0.0, 0.0, 1.0],
        }
    }
}
