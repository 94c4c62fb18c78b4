//! All kinematics by name.
use crate::{Kinematics, KinematicsError};
use serde::{Deserialize, Serialize};

/// What a machine file says about its kinematics.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KinematicsSpec {
    /// Registered name: `cartesian`, `trunnion-ac`.
    pub kind: String,
}

/// A registered kind of machine.
#[derive(Clone, Copy, Debug)]
pub struct RegistryEntry {
    /// Name in machine files.
    pub kind: &'static str,
    /// One line for people.
    pub summary: &'static str,
}

/// All registered kinds.
pub fn entries() -> &'static [RegistryEntry] {
    &[]
}

/// Builds the kinematics that a machine file describes.
///
/// # Errors
/// An unknown kind, or parameters that make no sense.
pub fn build(spec: &KinematicsSpec) -> Result<Box<dyn Kinematics>, KinematicsError> {
    Err(KinematicsError::Description { kind: spec.kind.clone(), why: "unknown".into() })
}
