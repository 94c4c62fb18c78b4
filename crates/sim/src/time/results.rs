//! What `time` answers, as data; its JSON form is versioned like that of [`crate::results`].

use crate::results::ProgramInfo;
use lostmotion_base::BlockRef;
use serde::{Deserialize, Serialize};

/// Version of the JSON form of [`CycleTime`].
pub const TIME_SCHEMA: u32 = 1;

/// What a stretch of time is spent on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum TimeKind {
    /// G1, G2, G3 and what becomes of them.
    #[default]
    Cutting,
    /// G0.
    Rapid,
    /// G4.
    Dwell,
}

/// How long one thing was what kept the machine from going faster.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct LimitShare {
    /// `feed`; `velocity X`, `acceleration X`, `jerk X` of a joint; `tolerance`: on a corner's
    /// rounding, no joint at a limit; `look-ahead`: nothing at its limit, the motion gets ready for
    /// what comes or leaves what has been; `chord`: the tool's bow between two commands, where a
    /// limit is kept; `dwell`.
    pub limit: String,
    /// Time, s.
    pub time_s: f64,
    /// Part of the time that it is listed under, 0 to 1.
    pub share: f64,
}

/// One block, each time it runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct BlockTime {
    /// Where the block stands.
    pub block: BlockRef,
    /// The block's text, trimmed, at most 80 characters.
    pub text: String,
    /// Running number of its first move.
    pub segment: u64,
    /// What the time is spent on.
    pub kind: TimeKind,
    /// When it begins, s.
    pub start_s: f64,
    /// How long it takes, s.
    pub time_s: f64,
    /// What limits it, longest first.
    pub limits: Vec<LimitShare>,
}

/// Time by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct KindTimes {
    /// Cutting, s.
    pub cutting_s: f64,
    /// Rapids, s.
    pub rapid_s: f64,
    /// Dwells, s.
    pub dwell_s: f64,
    /// Number of tool changes, and what each was taken to last, s.
    pub tool_changes: u64,
    /// Taken from the options, not simulated.
    pub tool_change_s: f64,
    /// Number of times the spindle starts, stops or turns round, and what each was taken to last,
    /// s.
    pub spindle_events: u64,
    /// Taken from the options, not simulated.
    pub spindle_event_s: f64,
}

/// The program on a machine that is better in one thing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct WhatIf {
    /// What is changed: `velocity limits +20 %`.
    pub change: String,
    /// Time of its plan, s.
    pub plan_s: f64,
    /// How much less that is, s.
    pub saved_s: f64,
    /// The same in parts of the plan as it is.
    pub saved_share: f64,
}

/// Answer of one `time`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct CycleTime {
    /// Version of this form, [`TIME_SCHEMA`].
    pub schema: u32,
    /// The program.
    pub program: ProgramInfo,
    /// Machine name.
    pub machine: String,
    /// Time of the program, s: the plan and what tool changes and spindle were taken to last.
    pub total_s: f64,
    /// Time of the plan, s: motion and dwells.
    pub plan_s: f64,
    /// By kind.
    pub kinds: KindTimes,
    /// What limits the whole plan, longest first.
    pub limits: Vec<LimitShare>,
    /// Blocks that take longest, longest first.
    pub blocks: Vec<BlockTime>,
    /// Number of all blocks that take time, each time they run.
    pub block_count: u64,
    /// What changes would bring; empty if not asked for.
    pub what_if: Vec<WhatIf>,
}
