//! Straight in all axes.
use serde::{Deserialize, Serialize};

/// Straight in all axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {}
