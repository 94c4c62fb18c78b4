//! Polynomial piece.
use serde::{Deserialize, Serialize};

/// Polynomial piece.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quintic {}
