//! What the planner outputs.

use crate::Heeds;
use lostmotion_base::{BlockRef, Coords, Tick};

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
