//! Linear delta: three carriages on upright towers carry the tool on rods.
//!
//! The towers stand at `tower_angles_deg` on a circle of `tower_radius_mm`, which is the distance
//! of the rods' joints on the towers less that on the platform; L is `rod_mm`. With (x, y, z) the
//! platform (tip plus the tool's offset), the joint of the tower at (px, py) is the height of its
//! carriage
//!
//! h = z + sqrt(L2 - (x - px)2 - (y - py)2).
//!
//! Forward is the intersection of three spheres of radius L about the carriages, the lower one of
//! its two points.

use crate::kind::finite;
use crate::{KindSpec, Kinematics, KinematicsError, Reach, ToolPose};
use lostmotion_base::units::rad;
use lostmotion_base::vec::{cross, dot, scale, sub, unit};
use lostmotion_base::{AXES, Coords, Jet, Real, math};
use serde::{Deserialize, Serialize};

/// Where the towers stand if nothing else is said, degrees: X front left, Y front right, Z at the
/// back.
const DEFAULT_TOWER_ANGLES_DEG: [f64; 3] = [210.0, 330.0, 90.0];
/// Least share of a rod's length that has to stand upright: a rod nearly flat no longer carries the
/// platform's height (the joint's derivatives grow as 1 / share).
const MIN_UPRIGHT_SHARE: f64 = 0.05;

/// Smallest area of the parallelogram over two sides of the towers' triangle, as a part of
/// `tower_radius_mm` squared; 2.6 where they stand at 120 degrees. A choice: the nearer to a line,
/// the farther an error of the carriages' heights moves the platform beside it.
const MIN_TOWER_AREA: f64 = 0.1;

/// Describes a linear delta.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeltaSpec {
    /// Distance of a delta's towers from the middle, less that of the rods on the platform, mm.
    pub tower_radius_mm: f64,
    /// Length of a delta's rods, mm.
    pub rod_mm: f64,
    /// Where a delta's towers X, Y, Z stand, deg; 210, 330 and 90 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tower_angles_deg: Option<[f64; 3]>,
}

/// Three carriages on towers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delta {
    towers: [[f64; 2]; 3],
    rod_mm: f64,
}

impl KindSpec for DeltaSpec {
    const SUMMARY: &'static str = "three carriages on towers carry the tool on rods";

    fn build(&self, _: &Reach) -> Result<Box<dyn Kinematics>, String> {
        let (radius, rod_mm) = (self.tower_radius_mm, self.rod_mm);
        let angles = self.tower_angles_deg.unwrap_or(DEFAULT_TOWER_ANGLES_DEG);
        finite("tower_radius_mm", &[radius])?;
        finite("rod_mm", &[rod_mm])?;
        finite("tower_angles_deg", &angles)?;
        // Shorter rods do not reach the middle between the towers.
        if !(radius > 0.0 && rod_mm > radius) {
            return Err(format!(
                "the rods (`rod_mm` = {rod_mm}) have to be longer than `tower_radius_mm` = {radius}, and both above 0"
            ));
        }
        let towers = angles.map(|degrees| {
            let (sin, cos) = math::sin_cos(rad(degrees));
            [radius * cos, radius * sin]
        });
        // Towers in a line leave the height of the platform beside it open.
        let [p, q, r] = towers;
        let area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        if area.abs() < MIN_TOWER_AREA * radius * radius {
            return Err(format!(
                "the towers (`tower_angles_deg` = {angles:?}) stand nearly in a line"
            ));
        }
        Ok(Box::new(Delta { towers, rod_mm }))
    }
}

impl Delta {
    fn joints<R: Real>(&self, program: &[R; AXES], tool: &[f64; 3]) -> Option<[R; AXES]> {
        let [x, y, z] = [0, 1, 2].map(|i| program[i] + R::constant(tool[i]));
        let mut joints = *program;
        for (joint, [px, py]) in joints.iter_mut().zip(self.towers) {
            let (dx, dy) = (x - R::constant(px), y - R::constant(py));
            // Height of the carriage over the platform, squared (Pythagoras).
            let square = R::constant(self.rod_mm * self.rod_mm) - dx * dx - dy * dy;
            if square.value() < MIN_UPRIGHT_SHARE * MIN_UPRIGHT_SHARE * self.rod_mm * self.rod_mm {
                return None;
            }
            *joint = z + square.sqrt();
        }
        Some(joints)
    }

    fn unreachable(pose: Coords) -> KinematicsError {
        KinematicsError::Unreachable {
            pose,
            why: "a rod would lie flat or be too short".into(),
        }
    }
}

impl Kinematics for Delta {
    fn name(&self) -> &'static str {
        DeltaSpec::KIND
    }

    fn inverse(&self, program: &Coords, tool: &[f64; 3]) -> Result<Coords, KinematicsError> {
        self.joints(&program.0, tool)
            .map(Coords)
            .ok_or_else(|| Delta::unreachable(*program))
    }

    fn inverse_jet(
        &self,
        program: &[Jet; 9],
        tool: &[f64; 3],
    ) -> Result<[Jet; 9], KinematicsError> {
        self.joints(program, tool)
            .ok_or_else(|| Delta::unreachable(Coords(program.map(|jet| jet.0[0]))))
    }

    fn forward(&self, joints: &Coords, tool: &[f64; 3]) -> Coords {
        let heights = joints.linear();
        let carriage =
            |tower: usize| [self.towers[tower][0], self.towers[tower][1], heights[tower]];
        let [p, q, r] = [0, 1, 2].map(carriage);
        // The centre of the circle through the three carriages, and down from it across their
        // plane.
        let (u, v) = (sub(q, p), sub(r, p));
        let normal = cross(u, v);
        let square = dot(normal, normal);
        let to = scale(
            cross(sub(scale(v, dot(u, u)), scale(u, dot(v, v))), normal),
            0.5 / square,
        );
        let down = unit(normal).map_or([0.0; 3], |n| if n[2] > 0.0 { scale(n, -1.0) } else { n });
        let drop = (self.rod_mm * self.rod_mm - dot(to, to)).max(0.0).sqrt();
        let mut program = *joints;
        for (i, coordinate) in program.0.iter_mut().take(3).enumerate() {
            *coordinate = p[i] + to[i] + drop * down[i] - tool[i];
        }
        program
    }

    fn tool_pose(&self, joints: &Coords, tool: &[f64; 3]) -> ToolPose {
        ToolPose {
            tip: self.forward(joints, tool).linear(),
            axis: [0.0, 0.0, 1.0],
        }
    }
}
