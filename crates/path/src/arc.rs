//! Circular, helical or spiral.
use serde::{Deserialize, Serialize};

/// Circular, helical or spiral.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Arc {}
