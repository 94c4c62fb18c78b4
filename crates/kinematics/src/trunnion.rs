//! Tilting rotary table under a spindle that does not turn, with tool-centre-point control: X Y Z are the tool tip in the
//! part's frame, whatever the table does.
//!
//! With T the tip in the part's frame, L the tool's offset, O the rotation point (where C's axis meets the table when
//! everything is at zero), D the way from there to the tilting axis, and s = 1 for conventional directions, -1 for reversed
//! ones,
//!
//! J = L + O + D + R(-s tilt) [Rz(-s C) (T - O) - D]
//!
//! R turning about X (`trunnion-ac`, D = (0, dy, dz)) or Y (`trunnion-bc`, D = (dx, 0, dz)). These are LinuxCNC's
//! `xyzac-trt` and `xyzbc-trt`, which write the same with P = T + L and dz including the tool's length; s = -1 is their
//! default. Conventional means that a positive program angle turns the tool counter-clockwise about the axis as seen from the
//! part, so the table turns clockwise (ISO 841). U, V and W are passed through.

use crate::registry::check_parameters;
use crate::{Kinematics, KinematicsError, KinematicsSpec, ToolPose};
use lostmotion_base::{AXES, AxisId, Coords, Jet, Real};

/// Registered name of the machine that tilts about X.
pub const KIND_AC: &str = "trunnion-ac";
/// Registered name of the machine that tilts about Y.
pub const KIND_BC: &str = "trunnion-bc";

const ROTATION_POINT: &str = "rotation_point_mm";
const OFFSET_Z: &str = "offset_z_mm";
const DIRECTIONS: &str = "conventional_directions";

/// The axis about which the table tilts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tilt {
    A,
    B,
}

impl Tilt {
    fn kind(self) -> &'static str {
        match self {
            Tilt::A => KIND_AC,
            Tilt::B => KIND_BC,
        }
    }

    fn axis(self) -> AxisId {
        match self {
            Tilt::A => AxisId::A,
            Tilt::B => AxisId::B,
        }
    }

    /// The two axes that the rotation mixes, in right-handed order.
    fn mixes(self) -> (usize, usize) {
        match self {
            Tilt::A => (1, 2),
            Tilt::B => (2, 0),
        }
    }
}

/// Table-table machine: C on a tilting A or B.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trunnion {
    tilt: Tilt,
    rotation_point: [f64; 3],
    offset: [f64; 3],
    sign: f64,
}

/// Builds `trunnion-ac` from a machine file's description.
pub(crate) fn build_ac(spec: &KinematicsSpec) -> Result<Box<dyn Kinematics>, KinematicsError> {
    check_parameters(spec, KIND_AC, &[ROTATION_POINT, "offset_y_mm", OFFSET_Z, DIRECTIONS])?;
    build(spec, Tilt::A)
}

/// Builds `trunnion-bc` from a machine file's description.
pub(crate) fn build_bc(spec: &KinematicsSpec) -> Result<Box<dyn Kinematics>, KinematicsError> {
    check_parameters(spec, KIND_BC, &[ROTATION_POINT, "offset_x_mm", OFFSET_Z, DIRECTIONS])?;
    build(spec, Tilt::B)
}

fn build(spec: &KinematicsSpec, tilt: Tilt) -> Result<Box<dyn Kinematics>, KinematicsError> {
    let Some(rotation_point) = spec.rotation_point_mm else {
        let why = format!("`{ROTATION_POINT}` is missing: where the axis of C meets the table, [x, y, z] in machine coordinates");
        return Err(KinematicsError::Description { kind: spec.kind.clone(), why });
    };
    let offset = [spec.offset_x_mm, spec.offset_y_mm, spec.offset_z_mm].map(|offset| offset.unwrap_or(0.0));
    let sign = if spec.conventional_directions.unwrap_or(true) { 1.0 } else { -1.0 };
    Ok(Box::new(Trunnion { tilt, rotation_point, offset, sign }))
}

/// Turns a vector in the plane of two of its axes.
fn turn<R: Real>(vector: &mut [R; 3], (first, second): (usize, usize), angle: R) {
    let (sin, cos) = (angle.sin(), angle.cos());
    let (a, b) = (vector[first], vector[second]);
    vector[first] = a * cos - b * sin;
    vector[second] = a * sin + b * cos;
}

fn shift<R: Real>(vector: &mut [R; 3], by: [f64; 3], sign: f64) {
    for (component, offset) in vector.iter_mut().zip(by) {
        *component = *component + R::constant(sign * offset);
    }
}

impl Trunnion {
    /// Part to joints, for numbers and for jets alike.
    fn joints<R: Real>(&self, program: &[R; AXES], tool: &[f64; 3]) -> [R; AXES] {
        let against = R::constant(-self.sign);
        let mut v = [program[0], program[1], program[2]];
        shift(&mut v, self.rotation_point, -1.0);
        turn(&mut v, (0, 1), program[AxisId::C.index()] * against);
        shift(&mut v, self.offset, -1.0);
        turn(&mut v, self.tilt.mixes(), program[self.tilt.axis().index()] * against);
        for by in [self.offset, self.rotation_point, *tool] {
            shift(&mut v, by, 1.0);
        }
        let mut joints = *program;
        joints[..3].copy_from_slice(&v);
        joints
    }

    /// Undoes the tilt of a vector in the machine.
    fn untilt(&self, vector: &mut [f64; 3], joints: &Coords) {
        turn(vector, self.tilt.mixes(), self.sign * joints[self.tilt.axis()]);
    }

    /// Undoes C.
    fn unturn(&self, vector: &mut [f64; 3], joints: &Coords) {
        turn(vector, (0, 1), self.sign * joints[AxisId::C]);
    }
}

impl Kinematics for Trunnion {
    fn name(&self) -> &'static str {
        self.tilt.kind()
    }

    fn is_affine(&self) -> bool {
        false
    }

    fn inverse(&self, program: &Coords, tool: &[f64; 3]) -> Result<Coords, KinematicsError> {
        Ok(Coords(self.joints(&program.0, tool)))
    }

    fn inverse_jet(&self, program: &[Jet; 9], tool: &[f64; 3]) -> Result<[Jet; 9], KinematicsError> {
        Ok(self.joints(program, tool))
    }

    fn forward(&self, joints: &Coords, tool: &[f64; 3]) -> Coords {
        let mut v = joints.linear();
        for by in [*tool, self.rotation_point, self.offset] {
            shift(&mut v, by, -1.0);
        }
        self.untilt(&mut v, joints);
        shift(&mut v, self.offset, 1.0);
        self.unturn(&mut v, joints);
        shift(&mut v, self.rotation_point, 1.0);
        let mut program = *joints;
        program.0[..3].copy_from_slice(&v);
        program
    }

    fn tool_pose(&self, joints: &Coords, tool: &[f64; 3]) -> ToolPose {
        let mut axis = [0.0, 0.0, 1.0];
        self.untilt(&mut axis, joints);
        self.unturn(&mut axis, joints);
        ToolPose { tip: self.forward(joints, tool).linear(), axis }
    }
}
