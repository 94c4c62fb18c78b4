//! Where a contact began: the lane of the gap without an end, in which the motor does what its
//! current does not explain.

use super::lanes::{Innovation, Progress};
use serde::{Deserialize, Serialize};

/// A half gap that is never crossed, rad.
pub(super) const ENDLESS: f64 = 10.0;
/// Lane of that gap.
const LANE: usize = 1;
/// Samples after the onset that are kept; squares that come without contact; part of a known half
/// gap over which no contact is looked for, since a traverse sets out so hard that it may look like
/// one.
const AFTER: usize = 4;
const EXPECTED: f64 = 3.0;
const LOOKED: f64 = 0.5;
/// Innovations over their standard deviation that may be the first of a contact.
const THRESHOLDS: [f64; 4] = [4.0, 8.0, 16.0, 32.0];

/// What was seen of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Onset {
    /// Sum of squares beyond what is expected.
    met: f64,
    /// Half of the way across the gap where each threshold was first exceeded, rad.
    pub(super) half_ways: [Option<f64>; THRESHOLDS.len()],
    /// Samples up to where enough was seen.
    pub(super) end: Option<usize>,
}

impl Onset {
    /// Looks for a contact in a sample: the flank that was left, a half gap that is known already
    /// (rad, else 0), and the sum of squares that is enough.
    pub(super) fn look(
        &mut self,
        innovation: &Innovation,
        progress: &Progress,
        side: f64,
        known: f64,
        enough: f64,
    ) {
        let way = ENDLESS - progress.lead[LANE] * side;
        if way < LOOKED * known {
            return;
        }
        let e = (innovation.e[LANE] * side / innovation.variance.sqrt()).max(0.0);
        self.met = (self.met + e * e - EXPECTED).max(0.0);
        if self.met > enough && self.end.is_none() {
            self.end = Some(progress.taken() + AFTER);
        }
        for (half_way, threshold) in self.half_ways.iter_mut().zip(THRESHOLDS) {
            if half_way.is_none() && e > threshold && way > 0.0 {
                *half_way = Some(0.5 * way);
            }
        }
    }
}
