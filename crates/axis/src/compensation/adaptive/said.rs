//! The answer of a reading.

use super::lanes::{LANES, Lanes};
use super::newton::Accepted;
use super::prior::GAP;

/// Half gaps that what was found is held against, parts of it, itself first; one without an end comes last.
pub(super) const AGAINST: [f64; LANES - 1] = [1.0, 0.98, 1.02, 0.94, 1.06, 0.8, 1.25];

/// What a window says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Said {
    pub(super) half_gap: f64,
    /// Variance of the half gap, rad2.
    pub(super) variance: f64,
    /// Whether the flank wavered.
    pub(super) wavered: bool,
    /// Mean square of the innovations over their variance: with the best hypothesis, and without a gap.
    pub(super) misfit: f64,
    pub(super) without: f64,
    /// By how much the squares of the innovations over their variance are fewer than if the gap had no end.
    pub(super) evidence: f64,
}

impl Said {
    /// No contact was seen.
    pub(super) const NOTHING: Said =
        Said { half_gap: 0.0, variance: f64::INFINITY, wavered: true, misfit: f64::INFINITY, without: 0.0, evidence: 0.0 };

    /// What was found, with the costs of the half gaps that it is held against: it is no surer than these tell, whatever the derivatives say.
    pub(super) fn checked(found: &Accepted, costs: &Lanes, wavered: bool, without: f64) -> Said {
        let Accepted { at, misfit, mut variance, .. } = *found;
        let [least, .., endless] = costs.map(|cost| cost / misfit.max(1.0));
        for (part, cost) in AGAINST.iter().zip(costs) {
            let off = (part - 1.0) * at[GAP];
            variance = variance.max(off * off / (cost / misfit.max(1.0) - least).max(1.0));
        }
        Said { half_gap: at[GAP], variance, wavered, misfit, without, evidence: endless - least }
    }
}
