//! What a plan of a window would give.

use super::tighten::Excess;
use super::warp::Walk;
use crate::Sample;

/// A sample with its place on the nominal motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    pub(crate) interval: usize,
    pub(crate) part: f64,
    /// d sigma / dt, and its rate of change, 1/s.
    pub(crate) pace: [f64; 2],
    pub(crate) sample: Sample,
}

/// What a plan of a window would give.
pub(crate) struct Trial {
    pub(super) samples: Vec<Placed>,
    pub(super) walk: Walk,
    /// Intervals around what passes a limit, with the part of the limits of acceleration and jerk
    /// that is left to them.
    pub(super) excess: Excess,
    /// Whether the solver found something.
    pub(crate) found: bool,
}

impl Trial {
    /// The least part of a limit that is left to an interval.
    pub(crate) fn least(&self) -> f64 {
        self.excess
            .iter()
            .flat_map(|(_, scale)| *scale)
            .fold(1.0, f64::min)
    }
}
