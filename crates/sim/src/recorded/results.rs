//! What a check of a recorded motion answers, as data; its JSON form is versioned like that of
//! [`crate::results`].

use crate::results::ProgramInfo;
use lostmotion_base::{AxisId, BlockRef};
use serde::{Deserialize, Serialize};

/// Version of the JSON form of [`RecordCheck`].
pub const RECORD_SCHEMA: u32 = 1;

/// What was recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum RecordKind {
    /// Commands of the control: held against the tolerance of G64.
    #[default]
    Commanded,
    /// Positions that encoders or scales have read: held against the tolerance of G64 and that of
    /// the verdict together.
    Measured,
}

/// Whose coordinates the record was found to be in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum RecordCoordinates {
    /// The machine's, with the work offsets of the machine file.
    #[default]
    Machine,
    /// The program's.
    Program,
    /// Others: a shift was fitted.
    Shifted,
}

/// Which derivative of a position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Derivative {
    /// The first.
    #[default]
    Velocity,
    /// The second.
    Acceleration,
    /// The third.
    Jerk,
}

impl std::fmt::Display for Derivative {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Derivative::Velocity => "velocity",
            Derivative::Acceleration => "acceleration",
            Derivative::Jerk => "jerk",
        })
    }
}

/// How much of a limit the record certainly uses somewhere.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct LimitUse {
    /// The axis.
    pub axis: AxisId,
    /// What of it.
    pub derivative: Derivative,
    /// Its limit, mm or deg and s.
    pub limit: f64,
    /// The largest magnitude that the record proves, mm or deg and s: a mean over `over_s`.
    pub found: f64,
    /// How far rounding and noise of the record may have it off.
    pub plus_minus: f64,
    /// `found` in parts of the limit.
    pub times: f64,
    /// Over which time it is a mean, s.
    pub over_s: f64,
    /// When, s of the log.
    pub time_s: f64,
    /// In which block.
    pub block: BlockRef,
    /// Whether the limit is certainly exceeded.
    pub is_exceeded: bool,
}

impl LimitUse {
    /// The least that is certain, in parts of the limit.
    pub(super) fn certain(&self) -> f64 {
        (self.found - self.plus_minus) / self.limit
    }
}

/// A block of the program, each time it runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct RecordedBlock {
    /// Where it stands.
    pub block: BlockRef,
    /// Its text, trimmed, at most 80 characters.
    pub text: String,
    /// Whether it is a G0.
    pub rapid: bool,
    /// When the record enters it, s of the log.
    pub from_s: f64,
    /// When the record leaves it, s of the log.
    pub to_s: f64,
    /// Largest distance from the programmed path, um.
    pub deviation_um: f64,
    /// When, s of the log.
    pub deviation_s: f64,
    /// How far it may be, um; `null` where nothing is asked (G64 without P, rapids of a measured
    /// record).
    pub allowed_um: Option<f64>,
    /// Whether it certainly is farther.
    pub is_outside: bool,
    /// The limit that it uses most.
    pub limit: Option<LimitUse>,
}

impl RecordedBlock {
    /// How many times over it is what it may be, in the worse of the two ways.
    pub fn times(&self) -> f64 {
        let off = self
            .allowed_um
            .map_or(0.0, |allowed| self.deviation_um / allowed.max(1e-3));
        let limit = self.limit.as_ref().map_or(0.0, |limit| limit.times);
        off.max(limit)
    }

    /// Whether anything of it is certainly more than it may be.
    pub fn is_at_fault(&self) -> bool {
        self.is_outside || self.limit.as_ref().is_some_and(|limit| limit.is_exceeded)
    }
}

/// What the record tells of an axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct RecordedAxisCheck {
    /// The axis.
    pub axis: AxisId,
    /// `mm` or `deg`.
    pub unit: String,
    /// Step of its values, mm or deg; 0 where none is seen. Of joints that follow from positions of
    /// the tool how far the steps of these move them at most.
    pub step: f64,
    /// Standard deviation of their noise, mm or deg, carried over in the same way; 0 where the steps
    /// explain all.
    pub noise: f64,
    /// Velocity, acceleration and, of commands, jerk.
    pub limits: Vec<LimitUse>,
}

/// Where in the program the record is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct RecordPlace {
    /// First and last block.
    pub first: BlockRef,
    /// First and last block.
    pub last: BlockRef,
    /// First time of the log that is on the path, s.
    pub from_s: f64,
    /// Last time of the log that is on the path, s.
    pub to_s: f64,
    /// Rows of the log, and how many of them lie before and behind the stretch on the path.
    pub rows: u64,
    /// Rows before it.
    pub rows_before: u64,
    /// Rows behind it.
    pub rows_behind: u64,
    /// Whose coordinates.
    pub coordinates: RecordCoordinates,
    /// Positions of the record minus the machine's coordinates, mm.
    pub shift_mm: [f64; 3],
    /// How far the shift may be off (95 %), mm.
    pub shift_error_mm: f64,
    /// First blocks of other places that fit as well, at most ten.
    pub others: Vec<BlockRef>,
    /// How many there are.
    pub other_places: u64,
}

/// Answer of one `check-log`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct RecordCheck {
    /// Version of this form, [`RECORD_SCHEMA`].
    pub schema: u32,
    /// The program.
    pub program: ProgramInfo,
    /// Machine name.
    pub machine: String,
    /// What was recorded.
    pub kind: RecordKind,
    /// Usual time between two rows, s.
    pub period_s: f64,
    /// Where in the program.
    pub place: RecordPlace,
    /// A list of what each axis has.
    pub axes: Vec<RecordedAxisCheck>,
    /// Largest distance from the programmed path, um.
    pub deviation_max_um: f64,
    /// The same, RMS over the rows.
    pub deviation_rms_um: f64,
    /// How far a distance may be off, um: rounding, noise and the shift.
    pub deviation_plus_minus_um: f64,
    /// The worst blocks, those at fault first.
    pub blocks: Vec<RecordedBlock>,
    /// How many blocks the record goes through.
    pub block_count: u64,
    /// How many of them are at fault.
    pub at_fault: u64,
    /// What the record cannot tell, and why.
    pub untold: Vec<String>,
}

impl RecordCheck {
    /// Whether nothing is certainly more than it may be.
    pub fn is_within(&self) -> bool {
        self.at_fault == 0
    }
}
