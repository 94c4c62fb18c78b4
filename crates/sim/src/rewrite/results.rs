//! What came of a program that was rewritten, as data.

use serde::{Deserialize, Serialize};

/// How far the tool leaves the contour of the original program while it cuts, um.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct Leaves {
    /// At most.
    pub max_um: f64,
    /// Root mean square.
    pub rms_um: f64,
}

/// What is left where the gaps are in truth smaller or larger.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct LeavesWith {
    /// True gaps over those of the machine description: of the axis whose gap is known least.
    pub factor: f64,
    /// The same of each of X, Y and Z.
    pub factors: [f64; 3],
    /// The original program.
    pub before: Leaves,
    /// The new one.
    pub after: Leaves,
}

/// Answer of `compensate`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct Rewritten {
    /// Version of this form, 1.
    pub schema: u32,
    /// File name of the program as given.
    pub program: String,
    /// Machine name.
    pub machine: String,
    /// Tolerance of the verdict, um.
    pub tolerance_um: f64,
    /// The new program, byte for byte as it is to be written. Not part of the JSON form: it is a file of its own.
    #[serde(skip)]
    pub bytes: Vec<u8>,
    /// The same as text; bytes that are not UTF-8 are replacement characters.
    #[serde(skip)]
    pub text: String,
    /// Half of the gap of each of X, Y and Z by which end points are moved, mm.
    pub shift_mm: [f64; 3],
    /// Most that end points are moved along the normal besides, um.
    pub normal_um: f64,
    /// The original program.
    pub before: Leaves,
    /// The new one, against the contour of the original.
    pub after: Leaves,
    /// Both with the gaps smaller and larger than described.
    pub uncertain: Vec<LeavesWith>,
    /// Whether the machine description or the user says of all axes how well their gaps are known.
    pub is_uncertainty_told: bool,
    /// Axes with a gap of which nobody says it: 30 % are taken.
    pub untold: Vec<String>,
    /// Duration of the original, s.
    pub time_before_s: f64,
    /// Duration of the new program, s.
    pub time_after_s: f64,
    /// Gaps that are taken up in the air, on a rapid of their own.
    pub in_the_air: u64,
    /// Gaps that are taken up within a cut, where the tool stands on the contour.
    pub within_cuts: u64,
    /// Axes that begin their first cut, or the first behind a change of the tool, from a side that is not known:
    /// nowhere before could they go beyond their place safely.
    pub sides_unknown: u64,
    /// Arcs that are cut at their reversals.
    pub arcs_split: u64,
    /// Why the new program must not be used, if there is a reason; nothing is written then.
    pub refused: Option<String>,
}

impl Rewritten {
    /// Whether the new program is good to use and keeps the tolerance.
    pub fn is_within_tolerance(&self) -> bool {
        self.refused.is_none() && self.after.max_um <= self.tolerance_um
    }
}
