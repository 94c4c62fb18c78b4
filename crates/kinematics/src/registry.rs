//! All kinematics by name.

use crate::{
    Kinematics, KinematicsError, KinematicsSpec, Reach, cartesian, corexy, delta, machine_tool,
    scara, trunnion,
};

/// Builds a kind from a description.
pub type Build = fn(&KinematicsSpec, &Reach) -> Result<Box<dyn Kinematics>, KinematicsError>;

/// A registered kind of machine.
#[derive(Clone, Copy, Debug)]
pub struct RegistryEntry {
    /// Name in machine files.
    pub kind: &'static str,
    /// One line for people.
    pub summary: &'static str,
    /// Builds it from a description whose `kind` is this one's.
    pub build: Build,
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
        RegistryEntry {
            kind: machine_tool::KIND,
            summary: "joints in any order from workpiece to tool: tables, heads, nutating ones, arms",
            build: machine_tool::build,
        },
        RegistryEntry {
            kind: corexy::KIND,
            summary: "two belts that move X and Y together",
            build: corexy::build,
        },
        RegistryEntry {
            kind: delta::KIND,
            summary: "three carriages on towers carry the tool on rods",
            build: delta::build,
        },
        RegistryEntry {
            kind: scara::KIND,
            summary: "two arms about upright axes (A, B), quill Z, wrist C",
            build: scara::build,
        },
    ]
}

/// Builds the kinematics that a machine file describes.
///
/// # Errors
/// An unknown kind, or parameters that make no sense.
pub fn build(spec: &KinematicsSpec) -> Result<Box<dyn Kinematics>, KinematicsError> {
    build_within(spec, &Reach::default())
}

/// The same for a machine whose joints have a travel, which the choice among solutions keeps.
///
/// # Errors
/// As [`build`].
pub fn build_within(
    spec: &KinematicsSpec,
    reach: &Reach,
) -> Result<Box<dyn Kinematics>, KinematicsError> {
    match entries().iter().find(|entry| entry.kind == spec.kind) {
        Some(entry) => (entry.build)(spec, reach),
        None => {
            let known: Vec<_> = entries().iter().map(|entry| entry.kind).collect();
            let why = format!("there is no such kind; known are {}", known.join(", "));
            Err(KinematicsError::Description {
                kind: spec.kind.clone(),
                why,
            })
        }
    }
}
