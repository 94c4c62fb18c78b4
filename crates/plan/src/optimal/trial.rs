//! What a plan of a window would give.

use super::tighten::Excess;
use super::warp::Walk;
use crate::Sample;

/// Samples that a plan would give, each with its interval.
pub(super) struct Trial {
    pub(super) samples: Vec<(usize, Sample)>,
    pub(super) walk: Walk,
    /// Intervals around what passes a limit, with the part of the limits of acceleration and jerk that is left to them.
    pub(super) excess: Excess,
    /// Whether the solver found something.
    pub(super) found: bool,
}

impl Trial {
    /// The least part of a limit that is left to an interval.
    pub(super) fn least(&self) -> f64 {
        self.excess.iter().flat_map(|(_, scale)| *scale).fold(1.0, f64::min)
    }
}
