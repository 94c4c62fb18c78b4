//! Tilting rotary table under a spindle that does not turn, with tool-centre-point control: X Y Z
//! are the tool tip in the part's frame, whatever the table does. A short description of one kind
//! of [`chain`](crate::chain).
//!
//! With T the tip in the part's frame, L the tool's offset, O the rotation point (where C's axis
//! meets the table when everything is at zero), D the way from there to the tilting axis, and s = 1
//! for conventional directions, -1 for reversed ones,
//!
//! J = L + O + D + R(-s tilt) [Rz(-s C) (T - O) - D]
//!
//! R turning about X (`trunnion-ac`, D = (0, dy, dz)) or Y (`trunnion-bc`, D = (dx, 0, dz)). These
//! are LinuxCNC's `xyzac-trt` and `xyzbc-trt`, which write the same with P = T + L and dz including
//! the tool's length; s = -1 is their default. Conventional means that a positive program angle
//! turns the tool counter-clockwise about the axis as seen from the part, so the table turns
//! clockwise (ISO 841). U, V and W are passed through.

use crate::chain::{Chain, GaugeSpec, JointSpec, JointType, Side};
use crate::machine_tool::{MachineTool, tolerance};
use crate::spec::check_parameters;
use crate::{Kinematics, KinematicsError, KinematicsSpec, Reach};

/// Registered name of the machine that tilts about X.
pub const KIND_AC: &str = "trunnion-ac";
/// Registered name of the machine that tilts about Y.
pub const KIND_BC: &str = "trunnion-bc";

const ROTATION_POINT: &str = "rotation_point_mm";
const KEYS: [&str; 5] = [
    ROTATION_POINT,
    "offset_z_mm",
    "conventional_directions",
    "tip_control",
    "orientation_tolerance_deg",
];

/// Builds `trunnion-ac` from a machine file's description.
pub(crate) fn build_ac(
    spec: &KinematicsSpec,
    reach: &Reach,
) -> Result<Box<dyn Kinematics>, KinematicsError> {
    let [point, rest @ ..] = KEYS;
    let mut keys = vec![point, "offset_y_mm"];
    keys.extend(rest);
    check_parameters(spec, KIND_AC, &keys)?;
    build(spec, reach, KIND_AC, ("a", [1.0, 0.0, 0.0]))
}

/// Builds `trunnion-bc` from a machine file's description.
pub(crate) fn build_bc(
    spec: &KinematicsSpec,
    reach: &Reach,
) -> Result<Box<dyn Kinematics>, KinematicsError> {
    let [point, rest @ ..] = KEYS;
    let mut keys = vec![point, "offset_x_mm"];
    keys.extend(rest);
    check_parameters(spec, KIND_BC, &keys)?;
    build(spec, reach, KIND_BC, ("b", [0.0, 1.0, 0.0]))
}

fn build(
    spec: &KinematicsSpec,
    reach: &Reach,
    kind: &'static str,
    (tilt, about): (&str, [f64; 3]),
) -> Result<Box<dyn Kinematics>, KinematicsError> {
    let describe = |why: String| KinematicsError::Description {
        kind: kind.to_owned(),
        why,
    };
    let Some(point) = spec.rotation_point_mm else {
        return Err(describe(format!(
            "`{ROTATION_POINT}` is missing: where the axis of C meets the table, [x, y, z] in machine coordinates"
        )));
    };
    let offset =
        [spec.offset_x_mm, spec.offset_y_mm, spec.offset_z_mm].map(|offset| offset.unwrap_or(0.0));
    let sign = Some(if spec.conventional_directions.unwrap_or(true) {
        1.0
    } else {
        -1.0
    });
    let rotary = |axis: &str, direction, point_mm| JointSpec {
        axis: axis.to_owned(),
        kind: JointType::Rotary,
        side: Some(Side::Table),
        direction,
        point_mm: Some(point_mm),
        sign,
        zero_mm: None,
        zero_deg: None,
        wrap: None,
    };
    let linear = |axis: &str, direction| JointSpec {
        kind: JointType::Linear,
        side: None,
        point_mm: None,
        sign: None,
        ..rotary(axis, direction, [0.0; 3])
    };
    let joints = [
        rotary("c", [0.0, 0.0, 1.0], point),
        rotary(tilt, about, std::array::from_fn(|i| point[i] + offset[i])),
        linear("x", [1.0, 0.0, 0.0]),
        linear("y", [0.0, 1.0, 0.0]),
        linear("z", [0.0, 0.0, 1.0]),
    ];
    let chain = Chain::new(&joints, &GaugeSpec::default()).map_err(describe)?;
    Ok(Box::new(
        MachineTool::new(kind, chain, reach, tolerance(spec)?).map_err(describe)?,
    ))
}
