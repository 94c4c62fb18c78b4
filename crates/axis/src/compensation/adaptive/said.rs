//! The answer of a reading.

/// What a window says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Said {
    pub(super) half_gap: f64,
    /// Variance of the half gap, rad2.
    pub(super) variance: f64,
    /// Whether the contact showed but faintly.
    pub(super) faint: bool,
    /// Whether the flank wavered.
    pub(super) wavered: bool,
    /// Samples of the window.
    pub(super) samples: usize,
    /// Mean square of the innovations over their variance: with the best hypothesis, and without a gap.
    pub(super) misfit: f64,
    pub(super) without: f64,
    /// By how much the squares of the innovations over their variance are fewer than if the gap had no end.
    pub(super) evidence: f64,
}

impl Said {
    /// No contact was seen.
    pub(super) const NOTHING: Said = Said {
        half_gap: 0.0,
        variance: f64::INFINITY,
        faint: true,
        wavered: true,
        samples: 0,
        misfit: f64::INFINITY,
        without: 0.0,
        evidence: 0.0,
    };
}
