//! Sums of one method's deviations over a cell.

use super::cycle::{self, Turns, Windows};
use super::result::{FIGURE_DECIMALS, MethodFigures};
use lostmotion_base::units::UM_PER_MM;
use lostmotion_drive::{AxisSample, Engagement};
use lostmotion_report::number::round_to;

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
