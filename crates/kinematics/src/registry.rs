//! All kinematics by name.

use crate::{Kinematics, KinematicsError, cartesian, trunnion};
use serde::{Deserialize, Serialize};

/// What a machine file says about its kinematics. Which of the optional keys a kind takes, and which it needs, its own file
/// says; a key that the kind has no use for is refused.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KinematicsSpec {
    /// Registered name: `cartesian`, `trunnion-ac`, `trunnion-bc`.
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
    /// Whether positive angles turn the tool counter-clockwise as seen from the part (ISO 841); true if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conventional_directions: Option<bool>,
}

/// A registered kind of machine.
#[derive(Clone, Copy, Debug)]
pub struct RegistryEntry {
    /// Name in machine files.
    pub kind: &'static str,
    /// One line for people.
    pub summary: &'static str,
    /// Builds it from a description whose `kind` is this one's.
    pub build: fn(&KinematicsSpec) -> Result<Box<dyn Kinematics>, KinematicsError>,
}

/// All registered kinds.
pub fn entries() -> &'static [RegistryEntry] {
    &[
        RegistryEntry {
            kind: cartesian::KIND,
            summary: "one joint per axis; rotary axes without tool-centre-point",
            build: cartesian::build,
        },
        RegistryEntry {
            kind: trunnion::KIND_AC,
            summary: "table tilting about X (A) with C on it, tool-centre-point",
            build: trunnion::build_ac,
        },
        RegistryEntry {
            kind: trunnion::KIND_BC,
            summary: "table tilting about Y (B) with C on it, tool-centre-point",
            build: trunnion::build_bc,
        },
    ]
}

/// Builds the kinematics that a machine file describes.
///
/// # Errors
/// An unknown kind, or parameters that make no sense.
pub fn build(spec: &KinematicsSpec) -> Result<Box<dyn Kinematics>, KinematicsError> {
    match entries().iter().find(|entry| entry.kind == spec.kind) {
        Some(entry) => (entry.build)(spec),
        None => {
            let known: Vec<_> = entries().iter().map(|entry| entry.kind).collect();
            let why = format!("there is no such kind; known are {}", known.join(", "));
            Err(KinematicsError::Description { kind: spec.kind.clone(), why })
        }
    }
}

/// Refuses keys that the kind does not take and values that are no numbers.
pub(crate) fn check_parameters(spec: &KinematicsSpec, kind: &str, taken: &[&str]) -> Result<(), KinematicsError> {
    let given: [(&str, Option<&[f64]>); 5] = [
        ("rotation_point_mm", spec.rotation_point_mm.as_ref().map(<[f64; 3]>::as_slice)),
        ("offset_x_mm", spec.offset_x_mm.as_ref().map(std::slice::from_ref)),
        ("offset_y_mm", spec.offset_y_mm.as_ref().map(std::slice::from_ref)),
        ("offset_z_mm", spec.offset_z_mm.as_ref().map(std::slice::from_ref)),
        ("conventional_directions", spec.conventional_directions.map(|_| [].as_slice())),
    ];
    for (key, values) in given {
        let Some(values) = values else { continue };
        let refuse = |why: String| Err(KinematicsError::Description { kind: kind.to_owned(), why });
        if !taken.contains(&key) {
            let takes = if taken.is_empty() { "no parameters".to_owned() } else { taken.join(", ") };
            return refuse(format!("it has no use for `{key}`; it takes {takes}"));
        }
        if let Some(value) = values.iter().find(|value| !value.is_finite()) {
            return refuse(format!("`{key}` is {value}; it has to be finite"));
        }
    }
    Ok(())
}
