//! LinuxCNC's kinematics modules that have a kind of machine here, by their manual page (kins.9)
//! and its chapters on kinematics: which joints they count, and what of them stands in HAL. What an
//! INI file does not set (`[HAL] HALCMD = setp MODULE.PIN VALUE`) is filled in and told.

use super::dh;
use super::draft::{Draft, Fate};
use super::hal::Pins;
use super::problem;
use crate::machine::{Machine, Problem};
use lostmotion_base::AxisId;
use lostmotion_kinematics::chain::{JointSpec, Side};
use lostmotion_kinematics::{
    CartesianSpec, ChainSpec, CoreXySpec, DeltaSpec, KinematicsSpec, ScaraSpec, TrunnionAcSpec,
    TrunnionBcSpec,
};

/// A joint by its number: the axis that it becomes, and whether it turns.
pub(super) type Numbered = (AxisId, bool);

/// What to do with a module.
pub(super) struct Module {
    pub(super) name: &'static str,
    /// Axes of the joints in their order, where it is not that of the coordinates.
    joints: Option<&'static [Numbered]>,
    /// Coordinates that it has if the configuration names no others.
    pub(super) coordinates: &'static str,
    describe: Describe,
}

/// Writes the kinematics into a draft, from the pins, with the machine's unit in mm; the
/// coordinates tell which axes there are.
type Describe = fn(&mut Draft, &mut Pins<'_>, f64, &[Numbered]) -> Result<(), Problem>;

const ALL: &[Numbered] = &[
    (AxisId::X, false),
    (AxisId::Y, false),
    (AxisId::Z, false),
    (AxisId::A, true),
    (AxisId::B, true),
    (AxisId::C, true),
    (AxisId::U, false),
    (AxisId::V, false),
    (AxisId::W, false),
];
const ARM: &[Numbered] = &[
    (AxisId::X, true),
    (AxisId::Y, true),
    (AxisId::Z, true),
    (AxisId::A, true),
    (AxisId::B, true),
    (AxisId::C, true),
];
/// Joints of a SCARA.
pub(super) const SCARA: &[Numbered] = &[
    (AxisId::A, true),
    (AxisId::B, true),
    (AxisId::Z, false),
    (AxisId::C, true),
];

/// All that are known.
const MODULES: [Module; 11] = [
    Module {
        name: "trivkins",
        joints: None,
        coordinates: "XYZ",
        describe: cartesian,
    },
    Module {
        name: "gentrivkins",
        joints: None,
        coordinates: "XYZ",
        describe: cartesian,
    },
    Module {
        name: "corexykins",
        joints: None,
        coordinates: "XYZ",
        describe: corexy,
    },
    Module {
        name: "xyzac-trt-kins",
        joints: None,
        coordinates: "XYZAC",
        describe: trunnion_ac,
    },
    Module {
        name: "xyzbc-trt-kins",
        joints: None,
        coordinates: "XYZBC",
        describe: trunnion_bc,
    },
    Module {
        name: "5axiskins",
        joints: None,
        coordinates: "XYZBCW",
        describe: bridge_mill,
    },
    Module {
        name: "maxkins",
        joints: Some(ALL),
        coordinates: "XYZBC",
        describe: max,
    },
    Module {
        name: "lineardeltakins",
        joints: None,
        coordinates: "XYZ",
        describe: delta,
    },
    Module {
        name: "scarakins",
        joints: Some(SCARA),
        coordinates: "XYZC",
        describe: scara,
    },
    Module {
        name: "genserkins",
        joints: Some(ARM),
        coordinates: "XYZABC",
        describe: serial,
    },
    Module {
        name: "pumakins",
        joints: Some(ARM),
        coordinates: "XYZABC",
        describe: puma,
    },
];

/// The module of a name.
pub(super) fn find(name: &str, line: usize) -> Result<&'static Module, Problem> {
    MODULES
        .iter()
        .find(|module| module.name == name)
        .ok_or_else(|| {
            let known: Vec<&str> = MODULES.iter().map(|module| module.name).collect();
            let hint = format!(
                "known are {}; describe others as kind = \"chain\" by hand",
                known.join(", ")
            );
            problem(
                line,
                "KINS.KINEMATICS",
                format!("`{name}` is not known here"),
                &hint,
            )
        })
}

impl Module {
    /// Axes of the joints by their number.
    pub(super) fn numbered(&self, coordinates: &str) -> Vec<Numbered> {
        let own = || {
            coordinates
                .chars()
                .filter_map(AxisId::from_letter)
                .map(|axis| (axis, axis.is_rotary()))
                .collect()
        };
        self.joints.map_or_else(own, <[Numbered]>::to_vec)
    }

    /// Whether it has a joint for every letter if it is not told which there are.
    pub(super) fn numbers_all_letters(&self) -> bool {
        matches!(self.name, "trivkins" | "gentrivkins")
    }

    /// Whether words are joints of the same letter, so that what an axis may do is what its joint
    /// may.
    pub(super) fn words_are_joints(&self) -> bool {
        !matches!(
            self.name,
            "lineardeltakins" | "scarakins" | "genserkins" | "pumakins"
        )
    }

    /// Describes the machine; pins that nothing was made of are told as that.
    pub(super) fn describe(
        &self,
        draft: &mut Draft,
        mut pins: Pins<'_>,
        mm: f64,
        coordinates: &[Numbered],
    ) -> Result<(), Problem> {
        (self.describe)(draft, &mut pins, mm, coordinates)?;
        pins.rest(draft);
        Ok(())
    }
}

fn cartesian(draft: &mut Draft, _: &mut Pins<'_>, _: f64, _: &[Numbered]) -> Result<(), Problem> {
    draft.kinematics = CartesianSpec {}.into();
    Ok(())
}

fn corexy(draft: &mut Draft, _: &mut Pins<'_>, _: f64, _: &[Numbered]) -> Result<(), Problem> {
    draft.kinematics = CoreXySpec {}.into();
    Ok(())
}

/// Six joints by their Denavit-Hartenberg parameters.
fn serial(draft: &mut Draft, pins: &mut Pins<'_>, mm: f64, _: &[Numbered]) -> Result<(), Problem> {
    dh::serial(draft, pins, mm)
}

/// Six joints of the arm that `pumakins` knows.
fn puma(draft: &mut Draft, pins: &mut Pins<'_>, mm: f64, _: &[Numbered]) -> Result<(), Problem> {
    dh::puma(draft, pins, mm)
}

/// A table that tilts about X (A), with C on it.
fn trunnion_ac(
    draft: &mut Draft,
    pins: &mut Pins<'_>,
    mm: f64,
    _: &[Numbered],
) -> Result<(), Problem> {
    draft.kinematics = TrunnionAcSpec {
        rotation_point_mm: rotation_point(draft, pins, mm)?,
        offset_y_mm: pins.told(draft, "y-offset", mm, "kinematics.offset_y_mm")?,
        offset_z_mm: pins.told(draft, "z-offset", mm, "kinematics.offset_z_mm")?,
        conventional_directions: Some(conventional(draft, pins)?),
        ..TrunnionAcSpec::default()
    }
    .into();
    Ok(())
}

/// A table that tilts about Y (B), with C on it.
fn trunnion_bc(
    draft: &mut Draft,
    pins: &mut Pins<'_>,
    mm: f64,
    _: &[Numbered],
) -> Result<(), Problem> {
    draft.kinematics = TrunnionBcSpec {
        rotation_point_mm: rotation_point(draft, pins, mm)?,
        offset_x_mm: pins.told(draft, "x-offset", mm, "kinematics.offset_x_mm")?,
        offset_z_mm: pins.told(draft, "z-offset", mm, "kinematics.offset_z_mm")?,
        conventional_directions: Some(conventional(draft, pins)?),
        ..TrunnionBcSpec::default()
    }
    .into();
    Ok(())
}

/// Where C's axis meets the table, mm; each coordinate that no pin sets is 0.
fn rotation_point(draft: &mut Draft, pins: &mut Pins<'_>, mm: f64) -> Result<[f64; 3], Problem> {
    let mut point = [0.0; 3];
    let mut pointed = false;
    for (slot, pin) in point
        .iter_mut()
        .zip(["x-rot-point", "y-rot-point", "z-rot-point"])
    {
        let told = pins.told(draft, pin, mm, "kinematics.rotation_point_mm")?;
        *slot = told.unwrap_or(0.0);
        pointed |= told.is_some();
    }
    // Told once, not once a coordinate.
    if !pointed {
        let note = "LinuxCNC has it in HAL (x-rot-point, ...), and no HALCMD of the INI file sets it: set it";
        draft.row(
            "kinematics.rotation_point_mm",
            "[0, 0, 0]",
            Fate::Filled,
            note,
        );
    }
    Ok(point)
}

/// Whether positive angles are those of ISO 841; LinuxCNC's default is that they are not.
fn conventional(draft: &mut Draft, pins: &mut Pins<'_>) -> Result<bool, Problem> {
    pins.bit(
        draft,
        "conventional-directions",
        "kinematics.conventional_directions",
    )
}

/// A slide of the head.
fn linear(axis: AxisId, direction: [f64; 3]) -> JointSpec {
    JointSpec {
        side: Some(Side::Head),
        ..JointSpec::linear(axis, direction)
    }
}

/// A rotary joint about an axis through the machine's Z, at a height.
fn rotary(axis: AxisId, side: Side, direction: [f64; 3], height_mm: f64, sign: f64) -> JointSpec {
    JointSpec {
        sign: Some(sign),
        ..JointSpec::rotary(axis, side, direction, [0.0, 0.0, height_mm])
    }
}

fn slides() -> [JointSpec; 3] {
    [
        linear(AxisId::X, [1.0, 0.0, 0.0]),
        linear(AxisId::Y, [0.0, 1.0, 0.0]),
        linear(AxisId::Z, [0.0, 0.0, 1.0]),
    ]
}

/// W goes along the tool.
fn quill(coordinates: &[Numbered]) -> Option<JointSpec> {
    coordinates
        .iter()
        .any(|(axis, _)| *axis == AxisId::W)
        .then(|| linear(AxisId::W, [0.0, 0.0, -1.0]))
}

/// A head that tilts (B) on one that turns (C), the tool's tip a pivot's length below.
fn bridge_mill(
    draft: &mut Draft,
    pins: &mut Pins<'_>,
    mm: f64,
    coordinates: &[Numbered],
) -> Result<(), Problem> {
    let pivot = pins.length(
        draft,
        "pivot-length",
        mm,
        250.0 * mm,
        "kinematics.joint.point_mm",
        "LinuxCNC's default: set it to your head's",
    )?;
    let (pan, tilt) = ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]);
    let mut joints = slides().to_vec();
    joints.extend([
        rotary(AxisId::C, Side::Head, pan, 0.0, 1.0),
        rotary(AxisId::B, Side::Head, tilt, pivot, -1.0),
    ]);
    // The quill sits in the head, behind both rotary joints.
    joints.extend(quill(coordinates));
    chain(draft, joints);
    Ok(())
}

/// A table that turns (C) under a head that tilts (B).
fn max(
    draft: &mut Draft,
    pins: &mut Pins<'_>,
    mm: f64,
    coordinates: &[Numbered],
) -> Result<(), Problem> {
    let pivot = pins.length(
        draft,
        "pivot-length",
        mm,
        0.666 * mm,
        "kinematics.joint.point_mm",
        "LinuxCNC's default: set it to your head's",
    )?;
    // Off where it is not set: positive angles then turn against ISO 841.
    let sign = if pins.bit(draft, "conventional-directions", "kinematics.joint.sign")? {
        1.0
    } else {
        -1.0
    };
    let mut joints = vec![rotary(AxisId::C, Side::Table, [0.0, 0.0, 1.0], 0.0, 1.0)];
    joints.extend(slides());
    joints.push(rotary(AxisId::B, Side::Head, [0.0, 1.0, 0.0], pivot, sign));
    joints.extend(quill(coordinates));
    chain(draft, joints);
    Ok(())
}

fn chain(draft: &mut Draft, joints: Vec<JointSpec>) {
    draft.kinematics = ChainSpec {
        joint: joints,
        ..ChainSpec::default()
    }
    .into();
}

/// The kinematics of a preset whose measures are lent where no pin tells them.
fn lender(preset: &str, line: usize) -> Result<KinematicsSpec, Problem> {
    Machine::preset(preset)
        .map(|machine| machine.kinematics().clone())
        .map_err(|error| no_lender(preset, &error.to_string(), line))
}

fn no_lender(preset: &str, found: &str, line: usize) -> Problem {
    let message = format!("machine `{preset}`, which lends its measures, is {found}");
    problem(line, "KINS.KINEMATICS", message, "set the pins in [HAL]")
}

/// Carriages on towers: joint 0 at (0, R), the others 120 degrees clockwise each.
fn delta(draft: &mut Draft, pins: &mut Pins<'_>, mm: f64, _: &[Numbered]) -> Result<(), Problem> {
    let own = match lender("delta", pins.line())? {
        KinematicsSpec::Delta(own) => own,
        other => return Err(no_lender("delta", other.kind(), pins.line())),
    };
    let lent = "machine `delta`; LinuxCNC has it in HAL (lineardeltakins.R, .L): set it";
    let radius = pins.length(
        draft,
        "R",
        mm,
        own.tower_radius_mm,
        "kinematics.tower_radius_mm",
        lent,
    )?;
    let rod = pins.length(draft, "L", mm, own.rod_mm, "kinematics.rod_mm", lent)?;
    draft.kinematics = DeltaSpec {
        tower_radius_mm: radius,
        rod_mm: rod,
        tower_angles_deg: Some([90.0, 330.0, 210.0]),
    }
    .into();
    Ok(())
}

/// Two arms about upright axes (joints 0 and 1), a quill that counts downwards (2), a wrist (3).
fn scara(draft: &mut Draft, pins: &mut Pins<'_>, mm: f64, _: &[Numbered]) -> Result<(), Problem> {
    let own = match lender("scara", pins.line())? {
        KinematicsSpec::Scara(own) => own,
        other => return Err(no_lender("scara", other.kind(), pins.line())),
    };
    let lent = "machine `scara`; LinuxCNC has it in HAL (scarakins.D2, .D4): set it";
    let upper = pins.length(
        draft,
        "D2",
        mm,
        own.upper_arm_mm,
        "kinematics.upper_arm_mm",
        lent,
    )?;
    let fore = pins.length(
        draft,
        "D4",
        mm,
        own.forearm_mm,
        "kinematics.forearm_mm",
        lent,
    )?;
    // Heights of the links in the order of the chain; the quill goes down from them.
    let mut height = 0.0;
    for (pin, sign) in [("D1", 1.0), ("D3", 1.0), ("D5", -1.0)] {
        height += sign
            * pins
                .told(
                    draft,
                    pin,
                    mm,
                    "height of Z: quill's joint counts downwards",
                )?
                .unwrap_or(0.0);
    }
    // Z counts upwards here, so the ends of its travel change places.
    if let Some(quill) = draft.axes.iter_mut().find(|axis| axis.id == AxisId::Z) {
        std::mem::swap(&mut quill.min, &mut quill.max);
        for told in [&mut quill.min, &mut quill.max].into_iter().flatten() {
            told.value = height - told.value;
        }
    }
    let note = format!("{height} mm less the joint: Z counts upwards here");
    draft.row("axis.z", "turned round", Fate::Used, note);
    draft.kinematics = ScaraSpec {
        upper_arm_mm: upper,
        forearm_mm: fore,
        elbow: None,
    }
    .into();
    Ok(())
}
