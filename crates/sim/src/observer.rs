//! Looking on while a run goes.

use crate::results::{BlockResult, ReversalResult};
use lostmotion_base::BlockRef;

/// One point of the contour as a machine cut it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContourPoint {
    /// Time, s.
    pub time_s: f64,
    /// Foot point on the programmed path from the program's zero, mm.
    pub foot_mm: [f64; 3],
    /// Unit vector to the left of travel in the plane in force.
    pub normal: [f64; 3],
    /// Contour error, signed, um.
    pub error_um: f64,
    /// Part of it that backlash causes, signed, um.
    pub backlash_um: f64,
    /// Whether the tool is on a G0 move.
    pub rapid: bool,
    /// The block.
    pub block: BlockRef,
}

/// Takes rows as they are finished, so that nobody has to hold them all. Every method does nothing
/// unless overridden.
///
/// `method` is the index in the list of methods compared; 0 for `simulate`. Rows come in a fixed
/// order, whatever the number of threads.
pub trait Observer: Send {
    /// How far the run is.
    fn progress(&mut self, _done_bytes: u64, _total_bytes: u64, _simulated_s: f64) {}

    /// Finished blocks; their text is empty.
    fn blocks(&mut self, _method: usize, _rows: &[BlockResult]) {}

    /// Finished reversals.
    fn reversals(&mut self, _method: usize, _rows: &[ReversalResult]) {}

    /// Points at the servo rate of all moving samples. Only called if [`Observer::wants_contour`].
    fn contour(&mut self, _method: usize, _points: &[ContourPoint]) {}

    /// Whether contour points are wanted; making them costs time.
    fn wants_contour(&self) -> bool {
        false
    }
}

/// Looks at nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unobserved;

impl Observer for Unobserved {}
