//! Figures of a cell, and the sums of each method's deviations that they come from.
//!
//! The practical limit is what may be expected of a drive. Three causes limit a method that learns,
//! and add up:
//!
//! - torque: the gap is crossed on a quintic, whose largest torque `5.77 J_M g/T^2` is the drive's
//!   limit. That takes 1.2 times as long as the shortest traverse with full torque one way and the
//!   other, and errors go with the second or third power of the time: 1.73 times the least possible
//!   at most.
//! - the gap has to be known: to a hundredth, which four reversals can show; a hundredth of the
//!   error stays.
//! - encoder: a motion below a count is not seen. RMS a count over the square root of 12, at most a
//!   count.
//!
//! The squares of the RMS errors add up, and the largest errors do.

use super::cycle::{self, Turns, Windows};
use super::factor::Cell;
use lostmotion_base::units::UM_PER_MM;
use lostmotion_drive::{AxisSample, Engagement};
use lostmotion_methods::MethodId;
use lostmotion_report::number::round_to;
use serde::{Deserialize, Serialize};

/// Decimals kept of a figure in um, ms or as a ratio: below what a change of compiler moves.
pub(super) const FIGURE_DECIMALS: usize = 6;

/// One method in one cell. Micrometres at the slide; all figures after the fourth reversal of each
/// axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MethodFigures {
    /// Registered name.
    pub method: String,
    /// RMS of the contour error that backlash causes, um.
    pub rms_um: f64,
    /// Its largest magnitude, um.
    pub max_um: f64,
    /// RMS of what backlash adds to the position of the loads of X and Y, um.
    pub axis_rms_um: [f64; 2],
    /// Mean magnitude of the relative error of the estimated half gap while load and motor are in
    /// contact, the worse axis; `None` if the method estimates none.
    pub gap_error: Option<f64>,
    /// Whether an axis hunts where without compensation it does not.
    pub hunts: bool,
    /// Part of the time for which a drive was at its current or voltage limit, the worse axis.
    pub saturated: f64,
}

/// A cell's figures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellResult {
    /// The cell.
    pub cell: Cell,
    /// Length of the motion, s.
    pub duration_s: f64,
    /// Start of measuring, s: 0.1 s after the fourth reversal of the axis that is later to have it.
    pub measured_from_s: f64,
    /// Servo ticks measured: cutting moves only.
    pub samples: u64,
    /// Highest path speed on a cutting move, mm/min.
    pub reached_mm_min: f64,
    /// Reversals of X and Y in all.
    pub reversals: [u32; 2],
    /// Shortest possible traverse of the gap, ms.
    pub traverse_ms: f64,
    /// Least possible largest error, um, by the formulae of the module `limit`.
    pub limit_max_um: f64,
    /// Least possible RMS, um, taking every unavoidable error at its largest for the whole
    /// traverse.
    pub limit_rms_um: f64,
    /// Part of the measured time in which the load of X or Y floats in its gap: no friction, and no
    /// need of torque.
    #[serde(default)]
    pub floating: f64,
    /// A count of the encoder, um at the slide; 0 for an ideal one.
    #[serde(default)]
    pub encoder_um: f64,
    /// One row a method; the first is `none`.
    pub methods: Vec<MethodFigures>,
}

/// RMS error of `none` above which a ratio to it is meaningful, um. A choice.
pub const RATIO_FROM_UM: f64 = 0.02;
/// A method is worse than `none` if its error is larger by more than this, um. A choice.
pub const WORSE_UM: f64 = 0.1;

/// A cell in which a load floats for more than this part of the time counts as one of floating
/// loads. A choice.
const FLOATING_TIME_SHARE: f64 = 0.05;

impl CellResult {
    /// Whether loads float for a notable part of the time.
    pub fn floats(&self) -> bool {
        self.floating > FLOATING_TIME_SHARE
    }

    /// The figures of a method.
    pub fn of(&self, method: &str) -> Option<&MethodFigures> {
        self.methods.iter().find(|figures| figures.method == method)
    }

    /// RMS and largest error of a method as parts of those of `none`; `None` if `none` leaves next
    /// to nothing.
    pub fn ratios(&self, method: &str) -> Option<[f64; 2]> {
        let (none, figures) = (self.of(MethodId::NONE.name())?, self.of(method)?);
        // The ratio of two tiny errors says nothing.
        (none.rms_um > RATIO_FROM_UM)
            .then(|| [figures.rms_um / none.rms_um, figures.max_um / none.max_um])
    }

    /// Whether RMS and largest error of a method are worse than those of `none` by more than
    /// [`WORSE_UM`].
    pub fn worse(&self, method: &str) -> [bool; 2] {
        let (Some(none), Some(figures)) = (self.of(MethodId::NONE.name()), self.of(method)) else {
            return [false; 2];
        };
        [
            figures.rms_um > none.rms_um + WORSE_UM,
            figures.max_um > none.max_um + WORSE_UM,
        ]
    }
}

/// Sum of squares and largest magnitude.
#[derive(Clone, Copy, Debug, Default)]
struct Size {
    squares: f64,
    max: f64,
    count: u64,
}

impl Size {
    fn push(&mut self, value: f64) {
        self.squares += value * value;
        self.max = self.max.max(value.abs());
        self.count += 1;
    }

    fn rms(&self) -> f64 {
        (self.squares / (self.count.max(1) as f64)).sqrt()
    }
}

/// Sums of one axis.
#[derive(Clone, Debug, Default)]
struct AxisTally {
    deviation: Size,
    gap_error: f64,
    gap_samples: u64,
    turns: Turns,
}

/// One method's sums.
#[derive(Clone, Debug)]
pub(super) struct Tally {
    step_um: f64,
    contour: Size,
    axes: [AxisTally; 2],
}

impl Tally {
    pub(super) fn new(step_um: f64) -> Tally {
        Tally {
            step_um,
            contour: Size::default(),
            axes: Default::default(),
        }
    }

    /// Takes the contour error that backlash causes at one servo tick on a cutting move, mm.
    pub(super) fn contour(&mut self, backlash_mm: f64) {
        self.contour.push(backlash_mm * UM_PER_MM);
    }

    /// Takes what an axis did at one servo tick: the load's deviation from that of the machine
    /// without a gap (mm), its trace, its true half gap (rad).
    pub(super) fn axis(
        &mut self,
        axis: usize,
        tick: usize,
        deviation_mm: f64,
        sample: &AxisSample,
        half_gap_rad: f64,
    ) {
        let Some(tally) = self.axes.get_mut(axis) else {
            return;
        };
        tally.deviation.push(deviation_mm * UM_PER_MM);
        tally
            .turns
            .push(tick, deviation_mm * UM_PER_MM, self.step_um);
        // Only in contact, true and estimated, is the estimated gap angle the half gap.
        let touching =
            sample.engagement != Engagement::Gap && sample.engagement_estimate != Engagement::Gap;
        if touching && sample.gap_angle_estimate.is_finite() {
            tally.gap_error += (sample.gap_angle_estimate.abs() / half_gap_rad - 1.0).abs();
            tally.gap_samples += 1;
        }
    }

    /// Samples of the contour.
    pub(super) fn samples(&self) -> u64 {
        self.contour.count
    }

    /// The figures, held against `none` and the motion's own events.
    pub(super) fn figures(
        &self,
        method: &str,
        none: &Tally,
        events: &[Windows; 2],
        saturated: f64,
    ) -> MethodFigures {
        // Compared with `none` on the same axis, window by window.
        let mut hunting = self.axes.iter().zip(&none.axes).zip(events);
        let gap_errors = self
            .axes
            .iter()
            .filter(|axis| axis.gap_samples > 0)
            .map(|axis| axis.gap_error / (axis.gap_samples as f64));
        MethodFigures {
            method: method.to_owned(),
            rms_um: round_to(self.contour.rms(), FIGURE_DECIMALS),
            max_um: round_to(self.contour.max, FIGURE_DECIMALS),
            axis_rms_um: self
                .axes
                .each_ref()
                .map(|axis| round_to(axis.deviation.rms(), FIGURE_DECIMALS)),
            gap_error: gap_errors
                .reduce(f64::max)
                .map(|error| round_to(error, FIGURE_DECIMALS)),
            hunts: hunting.any(|((axis, none), events)| {
                cycle::hunts(&axis.turns.windows, &none.turns.windows, events)
            }),
            saturated: round_to(saturated, FIGURE_DECIMALS),
        }
    }
}

/// Traverse on a quintic over the shortest one, to the third power: (sqrt(5.77)/2)^3.
const QUINTIC_TRAVERSE_CUBED: f64 = 1.733;
/// Part of the gap that is not known: what a careful measurement leaves. A choice.
const UNKNOWN_GAP_SHARE: f64 = 0.01;
/// Goal where the limit allows it: RMS and largest error over those of `none`. A choice.
pub(super) const WANTED: [f64; 2] = [0.02, 0.10];

/// The practical limit in um, RMS and largest error, from the least errors that physics leaves, from
/// those of `none`, and from a count of the encoder at the load.
pub(crate) fn practical_um(least_um: [f64; 2], none_um: [f64; 2], count_um: f64) -> [f64; 2] {
    let rms = [
        QUINTIC_TRAVERSE_CUBED * least_um[0],
        UNKNOWN_GAP_SHARE * none_um[0],
        count_um / 12.0_f64.sqrt(),
    ];
    let max = QUINTIC_TRAVERSE_CUBED * least_um[1] + UNKNOWN_GAP_SHARE * none_um[1] + count_um;
    // Independent causes: variances add up, largest errors add up at worst.
    let squares: f64 = rms.iter().map(|part| part * part).sum();
    [squares.sqrt(), max]
}

impl CellResult {
    /// The practical limit: RMS and largest error, over those of `none`; `None` if `none` leaves
    /// next to nothing.
    pub fn practical(&self) -> Option<[f64; 2]> {
        let none = self.of(MethodId::NONE.name())?;
        // No limit where `none` leaves next to nothing: there is no ratio to hold it against.
        self.ratios(MethodId::NONE.name())?;
        let least = [self.limit_rms_um, self.limit_max_um];
        let none_um = [none.rms_um, none.max_um];
        let [rms, max] = practical_um(least, none_um, self.encoder_um);
        Some([rms / none.rms_um, max / none.max_um])
    }

    /// Whether a method leaves no more than is wanted in RMS (0) and in its largest error (1), or
    /// than the limit allows where that is more.
    pub fn within(&self, method: &str) -> Option<[bool; 2]> {
        let (ratios, limit) = (self.ratios(method)?, self.practical()?);
        Some([0, 1].map(|which: usize| ratios[which] <= WANTED[which].max(limit[which])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_of_the_three_shows_where_it_is_the_largest() {
        let figures = |method: &str, rms_um, max_um| MethodFigures {
            method: method.to_owned(),
            rms_um,
            max_um,
            ..MethodFigures::default()
        };
        let mut cell: CellResult = serde_json::from_str(
            r#"{"cell":"circle5-f300-cw-g20-t30-v0-j8-ideal-steady","duration_s":1,"measured_from_s":0,"samples":1,"reached_mm_min":300,"reversals":[4,4],
                "traverse_ms":1,"limit_max_um":0,"limit_rms_um":0,"methods":[]}"#,
        )
        .unwrap();
        cell.methods = vec![
            figures("none", 5.0, 10.0),
            figures("good", 0.09, 0.9),
            figures("fair", 0.2, 2.0),
        ];
        assert_eq!(cell.practical(), Some([0.01, 0.01]));
        assert_eq!(
            (
                cell.within("good"),
                cell.within("fair"),
                cell.within("nobody")
            ),
            (Some([true; 2]), Some([false; 2]), None)
        );
        // a count of 1 um: 0.29 um RMS
        cell.encoder_um = 1.0;
        let [rms, max] = cell.practical().unwrap();
        assert!(
            (rms - (1.0_f64 / 12.0 / 25.0 + 1e-4).sqrt()).abs() < 1e-12
                && (max - 0.11).abs() < 1e-12,
            "{rms} {max}"
        );
        assert_eq!(cell.within("fair"), Some([true, false]));
        cell.limit_max_um = 1.0;
        assert!(cell.within("fair") == Some([true, true]));
    }
}
