//! What the planner takes, and the samples that it outputs.

use lostmotion_base::{BlockRef, Coords, Tick};
use lostmotion_path::Curve;
use std::ops::AddAssign;

/// How the planner may leave the programmed path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathControl {
    /// G61.1: full stop at the end of every move.
    ExactStop,
    /// G61: the programmed path exactly, stopping where its tangent breaks.
    ExactPath,
    /// G64: blend within a tolerance.
    Continuous {
        /// P: largest distance from the programmed path, mm; `None` for G64 without P.
        tolerance_mm: Option<f64>,
        /// Q: tolerance for merging short lines, mm; 0 turns merging off.
        merge_tolerance_mm: Option<f64>,
    },
}

/// How fast a move may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FeedLimit {
    /// G0: as fast as the joints allow.
    Rapid,
    /// Path parameter per second: mm/s, or degrees/s where only rotary axes move (G94, G95).
    PerSecond(f64),
    /// The whole move in this number of seconds (G93).
    Duration(f64),
    /// As [`FeedLimit::PerSecond`], and no override changes it (M49, M50 P0, threads).
    Fixed(f64),
}

impl FeedLimit {
    /// The override that it heeds.
    pub(crate) fn heeds(self) -> Heeds {
        match self {
            FeedLimit::Rapid => Heeds::Rapid,
            FeedLimit::PerSecond(_) | FeedLimit::Duration(_) => Heeds::Feed,
            FeedLimit::Fixed(_) => Heeds::Nothing,
        }
    }
}

/// Which of the operator's overrides changes how fast a place is passed; where moves meet, the
/// later of these.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Heeds {
    /// That of rapid moves.
    Rapid,
    /// That of the feed.
    #[default]
    Feed,
    /// None.
    Nothing,
}

/// How often a plan is not what it could be: what was planned keeps every limit, but takes longer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Shortfalls {
    /// Stops because the look-ahead window was too short for the path's detail.
    pub window_stops: u64,
    /// Stops where a smooth curve in place of many lines could not be found any further.
    pub curve_stops: u64,
    /// Windows of a retimed motion (quality `optimal`, overrides above 100 %) in which nothing
    /// faster was found than the pace that they end with.
    pub kept_windows: u64,
}

impl AddAssign for Shortfalls {
    fn add_assign(&mut self, other: Shortfalls) {
        self.window_stops += other.window_stops;
        self.curve_stops += other.curve_stops;
        self.kept_windows += other.kept_windows;
    }
}

/// One programmed move.
#[derive(Clone, Copy, Debug)]
pub struct Move {
    /// Programmed curve in program coordinates (machine frame of the kinematics' program side), mm
    /// and rad.
    pub curve: Curve,
    /// Speed limit.
    pub feed: FeedLimit,
    /// Path control in force.
    pub control: PathControl,
    /// Tool offset in force, mm.
    pub tool_mm: [f64; 3],
    /// Block that commanded it.
    pub block: BlockRef,
}

/// Standing still for a time (G4).
#[derive(Clone, Copy, Debug)]
pub struct Dwell {
    /// How long, in s, never negative.
    pub seconds: f64,
    /// Block that commanded it.
    pub block: BlockRef,
}

/// Coming to rest for something that takes no time in the simulation (tool change, program stop,
/// spindle event).
#[derive(Clone, Copy, Debug)]
pub struct Halt {
    /// Block that commanded it.
    pub block: BlockRef,
}

/// One thing for the planner to do.
///
/// Moves are by far the most frequent kind, and none is kept: boxing them would only cost.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Copy, Debug)]
pub enum PlanItem {
    /// Moves along a curve.
    Move(Move),
    /// Waits.
    Dwell(Dwell),
    /// Comes to rest.
    Halt(Halt),
}

/// Commanded state of all joints at one tick of the planner's clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Tick of the planner's clock (1 ms unless configured otherwise); 0 is the first sample, at
    /// rest.
    pub tick: Tick,
    /// Joint positions, mm and rad.
    pub position: Coords,
    /// Joint velocities, mm/s and rad/s; exact derivative of the planned motion.
    pub velocity: Coords,
    /// Joint accelerations, mm/s2 and rad/s2.
    pub acceleration: Coords,
    /// Running number of the programmed move (as pushed, from 0) on which the planned point lies.
    /// Never decreases.
    pub segment: u64,
    /// Parameter on that move's *programmed* curve, 0 to its length, nearest to the planned point
    /// (to first order on blends).
    pub s: f64,
    /// Path speed, per second in the unit of `s`.
    pub path_speed: f64,
    /// Speed as a part of what the feed allows; 0 on rapid moves.
    pub feed_part: f64,
    /// Speed as a part of what the limit of the tool's bow between two commands allows; 0 without
    /// one.
    pub chord_part: f64,
    /// The override that changes the feed.
    pub heeds: Heeds,
    /// Tool offset in force, mm.
    pub tool_mm: [f64; 3],
    /// Block of the move.
    pub block: BlockRef,
}
