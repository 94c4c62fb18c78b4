//! Machines that come with the library, as files that a user could have written, and their axes.

use super::problem::MachineError;
use super::{Machine, axis_from_toml};
use lostmotion_base::names::did_you_mean;
use lostmotion_methods::AxisConfig;

/// Name of the machine that is taken if none is named.
pub const DEFAULT_MACHINE: &str = "vmc3";

/// A machine that comes with the library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PresetInfo {
    /// Name on the command line.
    pub name: &'static str,
    /// One line for people.
    pub summary: &'static str,
    /// The file, with a comment and a source for every value.
    pub toml: &'static str,
}

macro_rules! preset {
    ($name:literal, $summary:literal) => {
        PresetInfo {
            name: $name,
            summary: $summary,
            toml: include_str!(concat!("../../presets/", $name, ".toml")),
        }
    };
}

/// All machines that come with the library, the default one first.
pub fn presets() -> &'static [PresetInfo] {
    &[
        preset!(
            "vmc3",
            "3-axis vertical mill, 762 x 406 x 508 mm, 10 um gap"
        ),
        preset!(
            "vmc3-worn",
            "the same mill worn: 40 um gap, three times the friction"
        ),
        preset!("vmc4", "the mill with a rotary table A, 30 arc seconds gap"),
        preset!(
            "trunnion5",
            "5-axis mill with a tilting A/C table and tool-centre-point control"
        ),
        preset!(
            "gantry3",
            "3-axis bridge mill, two motors on Y with gaps of 10 and 25 um"
        ),
        preset!(
            "fork5",
            "5-axis mill with a C/B fork head (head-head), G43.4 and tilted planes"
        ),
        preset!(
            "swivel5",
            "5-axis mill with a B head over a C table (head-table), G43.4 and tilted planes"
        ),
        preset!(
            "nutating5",
            "5-axis mill with a 45 degree nutating table (B, C), G43.4 and tilted planes"
        ),
        preset!("corexy", "CoreXY gantry, 400 x 400 x 300 mm"),
        preset!("delta", "linear delta, 300 mm across"),
        preset!("scara", "SCARA arm of 400 + 300 mm, 200 mm quill"),
        preset!("arm6", "six-axis arm with a spherical wrist, reach 1.3 m"),
        preset!(
            "bench3",
            "three equal axes of 100 mm/s, 1 m/s2, 30 m/s3, part zero in machine zero"
        ),
    ]
}

impl Machine {
    /// A machine that comes with the library.
    ///
    /// ```
    /// use lostmotion_sim::Machine;
    ///
    /// assert_eq!(Machine::preset("vmc3")?.axes().len(), 3);
    /// let error = Machine::preset("vcm3").unwrap_err().to_string();
    /// assert!(error.contains("did you mean `vmc3`?"));
    /// # Ok::<(), lostmotion_sim::machine::MachineError>(())
    /// ```
    ///
    /// # Errors
    /// There is no machine of that name.
    pub fn preset(name: &str) -> Result<Machine, MachineError> {
        match presets().iter().find(|info| info.name == name) {
            Some(info) => Machine::from_toml(&format!("{name}.toml"), info.toml),
            None => {
                let known: Vec<&str> = presets().iter().map(|info| info.name).collect();
                let message = format!("there is no machine `{name}`");
                Err(MachineError::of(
                    "",
                    "",
                    message,
                    &did_you_mean(name, &known),
                ))
            }
        }
    }
}

/// Name of the axis of the paper, which is not part of a machine.
const PAPER_AXIS: &str = "paper";
/// Name of a robot's joint, and its file.
const ROBOT_JOINT: (&str, &str) = (
    "robot-joint",
    include_str!("../../presets/axes/robot-joint.toml"),
);

/// An axis that comes with the library: `paper`, `robot-joint`, or an axis of a machine as `vmc3:x`
/// (`gantry3:y2` is a gantry's second motor); `None` if there is none of that
/// name.
pub fn axis_preset(name: &str) -> Option<AxisConfig> {
    if name == PAPER_AXIS {
        return Some(AxisConfig::paper());
    }
    if name == ROBOT_JOINT.0 {
        return axis_from_toml(ROBOT_JOINT.0, ROBOT_JOINT.1).ok();
    }
    let (machine, drive) = name.split_once(':')?;
    let machine = Machine::preset(machine).ok()?;
    machine.drive(drive).cloned()
}

/// The file of an axis that comes with the library, all keys written out; `None` if there is none
/// of that name or it cannot be written.
pub fn axis_preset_toml(name: &str) -> Option<String> {
    if name == ROBOT_JOINT.0 {
        return Some(ROBOT_JOINT.1.to_owned());
    }
    toml::to_string(&axis_preset(name)?).ok()
}

/// Names of all axes that come with the library.
pub fn axis_presets() -> Vec<String> {
    let of = |info: &PresetInfo| {
        let drives = Machine::preset(info.name)
            .as_ref()
            .map(Machine::drives)
            .unwrap_or_default();
        drives
            .iter()
            .map(|drive| format!("{}:{drive}", info.name))
            .collect::<Vec<_>>()
    };
    [PAPER_AXIS, ROBOT_JOINT.0]
        .map(str::to_owned)
        .into_iter()
        .chain(presets().iter().flat_map(of))
        .collect()
}
