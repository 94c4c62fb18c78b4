//! What a machine file says about its kinematics, and the checks that every kind needs.

use crate::KinematicsError;
use crate::chain::{GaugeSpec, JointSpec};
use serde::{Deserialize, Serialize};

/// When X Y Z are the tool's tip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TipControl {
    /// Always, as LinuxCNC's five-axis kinematics do; G43.4 is the tool's length then.
    #[default]
    Always,
    /// From G43.4 or G43.5 to G49, and in a plane that G53.1 has turned to; else X Y Z are the
    /// linear joints.
    Programmed,
}

/// What the rotary words of a chain are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Words {
    /// Positions of the rotary joints of that name: machine tools.
    Axes,
    /// Roll, pitch and yaw of the tool's frame: arms.
    Pose,
}

/// On which side of the way from base to tool the elbow is, seen from above looking out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Elbow {
    /// B is negative.
    Left,
    /// B is positive.
    Right,
}

/// What a machine file says about its kinematics. Which of the optional keys a kind takes, and
/// which it needs, its own file says; a key that the kind has no use for is refused.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KinematicsSpec {
    /// Registered name, as `entries` lists them.
    pub kind: String,
    /// Where the axis of C meets the table with all axes at zero, machine coordinates, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation_point_mm: Option<[f64; 3]>,
    /// From the rotation point to the tilting axis along X, mm; 0 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_x_mm: Option<f64>,
    /// From the rotation point to the tilting axis along Y, mm; 0 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_y_mm: Option<f64>,
    /// From the rotation point to the tilting axis along Z, mm; 0 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_z_mm: Option<f64>,
    /// Whether positive angles turn the tool counter-clockwise as seen from the part (ISO 841);
    /// true if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conventional_directions: Option<bool>,
    /// When X Y Z are the tool's tip: `always` or `programmed`; `always` if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip_control: Option<TipControl>,
    /// How far the tool's direction may leave the programmed one while it turns, deg; 0.1 if not
    /// given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation_tolerance_deg: Option<f64>,
    /// What the rotary words are: `axes` or `pose`; `axes` if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub words: Option<Words>,
    /// Joints at home in the order of the chain, mm and deg: chooses among the solutions where
    /// words are a pose.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub home: Option<Vec<f64>>,
    /// Distance of a delta's towers from the middle, less that of the rods on the platform, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tower_radius_mm: Option<f64>,
    /// Length of a delta's rods, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rod_mm: Option<f64>,
    /// Where a delta's towers X, Y, Z stand, deg; 210, 330 and 90 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tower_angles_deg: Option<[f64; 3]>,
    /// From a SCARA's first axis to its second, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub upper_arm_mm: Option<f64>,
    /// From a SCARA's second axis to its wrist, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub forearm_mm: Option<f64>,
    /// Side of a SCARA's elbow: `left` or `right`; `right` if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub elbow: Option<Elbow>,
    /// The spindle of a chain with all joints at zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gauge: Option<GaugeSpec>,
    /// Joints of a chain in the order from the workpiece to the tool.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joint: Vec<JointSpec>,
}

impl KinematicsSpec {
    /// When X Y Z are the tool's tip.
    pub fn tip_control(&self) -> TipControl {
        self.tip_control.unwrap_or_default()
    }
}

/// The keys that are given, each with its numbers.
fn given(spec: &KinematicsSpec) -> Vec<(&'static str, Vec<f64>)> {
    let one = |value: Option<f64>| value.map(|value| vec![value]);
    let there = |is: bool| is.then(Vec::new);
    let all = [
        (
            "rotation_point_mm",
            spec.rotation_point_mm.map(|v| v.to_vec()),
        ),
        ("offset_x_mm", one(spec.offset_x_mm)),
        ("offset_y_mm", one(spec.offset_y_mm)),
        ("offset_z_mm", one(spec.offset_z_mm)),
        (
            "conventional_directions",
            there(spec.conventional_directions.is_some()),
        ),
        ("tip_control", there(spec.tip_control.is_some())),
        (
            "orientation_tolerance_deg",
            one(spec.orientation_tolerance_deg),
        ),
        ("words", there(spec.words.is_some())),
        ("home", spec.home.clone()),
        ("tower_radius_mm", one(spec.tower_radius_mm)),
        ("rod_mm", one(spec.rod_mm)),
        (
            "tower_angles_deg",
            spec.tower_angles_deg.map(|v| v.to_vec()),
        ),
        ("upper_arm_mm", one(spec.upper_arm_mm)),
        ("forearm_mm", one(spec.forearm_mm)),
        ("elbow", there(spec.elbow.is_some())),
        ("gauge", there(spec.gauge.is_some())),
        ("joint", there(!spec.joint.is_empty())),
    ];
    all.into_iter()
        .filter_map(|(key, values)| values.map(|values| (key, values)))
        .collect()
}

/// Refuses keys that the kind does not take and values that are no numbers.
pub(crate) fn check_parameters(
    spec: &KinematicsSpec,
    kind: &str,
    taken: &[&str],
) -> Result<(), KinematicsError> {
    for (key, values) in given(spec) {
        let refuse = |why: String| {
            Err(KinematicsError::Description {
                kind: kind.to_owned(),
                why,
            })
        };
        if !taken.contains(&key) {
            let takes = if taken.is_empty() {
                "no parameters".to_owned()
            } else {
                taken.join(", ")
            };
            return refuse(format!("it has no use for `{key}`; it takes {takes}"));
        }
        if let Some(value) = values.iter().find(|value| !value.is_finite()) {
            return refuse(format!("`{key}` is {value}; it has to be finite"));
        }
    }
    Ok(())
}
