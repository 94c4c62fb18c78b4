//! Bounds that keep any input from taking unbounded time or memory.

mod names;

pub use names::{LimitError, LimitRow};
use serde::{Deserialize, Serialize};

/// What a program may use. Every bound is settable; exceeding one is an error that names it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Bytes of one line.
    pub line_bytes: usize,
    /// Bytes of the whole source.
    pub source_bytes: u64,
    /// Words on one line.
    pub words: usize,
    /// Nesting of brackets, signs and `#` in one value.
    pub expression_depth: usize,
    /// Executed blocks, repetitions counted.
    pub executed_blocks: u64,
    /// Executed blocks without reading a further line: what loops and subroutines may do at a
    /// stretch.
    pub looped_blocks: u64,
    /// Operations that they may make at a stretch: a canned cycle can make many with one block.
    pub looped_operations: u64,
    /// Of those, blocks in a row that neither move nor dwell.
    pub idle_blocks: u64,
    /// Nesting of subroutine calls.
    pub call_depth: usize,
    /// Branches and loops open at once.
    pub open_structures: usize,
    /// Bytes of source held for loops and subroutines.
    /// Every line counts 32 bytes more than it has, every subroutine 256.
    pub held_bytes: usize,
    /// Largest absolute coordinate, in mm or degrees.
    pub coordinate: f64,
    /// Largest radius of an arc, in mm.
    pub radius_mm: f64,
    /// Largest feed rate, in mm or degrees per minute (or per revolution).
    pub feed: f64,
    /// Largest dwell in seconds.
    pub dwell_s: f64,
    /// Moves that one canned cycle block may make.
    pub cycle_moves: u32,
    /// Control points of one curve.
    pub curve_points: usize,
    /// Diagnostics kept; the others are only counted.
    pub diagnostics: usize,
    /// Named parameters alive at once.
    pub named_parameters: usize,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            line_bytes: 65_536,
            source_bytes: 1 << 40,
            words: 64,
            expression_depth: 64,
            executed_blocks: 1_000_000_000,
            looped_blocks: 2_500_000,
            looped_operations: 2_500_000,
            idle_blocks: 1_000_000,
            call_depth: 30,
            open_structures: 1000,
            held_bytes: 64 << 20,
            coordinate: 1e9,
            radius_mm: 1e9,
            feed: 1e9,
            dwell_s: 1e6,
            cycle_moves: 1_000_000,
            curve_points: 100_000,
            diagnostics: 100,
            named_parameters: 10_000,
        }
    }
}
