//! One servo tick of a cell: the part that all methods share, and the part of the traced one.

use lostmotion_base::Tick;
use lostmotion_contour::ContourSample;
use lostmotion_drive::AxisSample;
use lostmotion_plan::Sample;

/// Receives the servo ticks of the traced method.
pub type Trace<'a> = dyn FnMut(&Traced) + Send + 'a;

/// A servo tick of the traced method.
#[derive(Clone, Copy, Debug)]
pub struct Traced {
    /// Servo tick since the start of the program.
    pub tick: Tick,
    /// Signed contour error, um, and that of the machine without a gap.
    pub error_um: [f64; 2],
    /// Whether it counts for the figures.
    pub measured: bool,
    /// X and Y.
    pub axes: [AxisSample; 2],
}

/// The part of a servo tick that all methods of a cell share.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub(super) tick: Tick,
    pub(super) command: Sample,
    pub(super) commanded_tip_mm: [f64; 3],
    pub(super) without_gap: ContourSample,
    /// Whether Z has reversed so often that its backlash counts, too.
    pub(super) z_counts: bool,
    /// Servo ticks since measuring began, if it has.
    pub(super) since: Option<usize>,
}

impl Frame {
    /// Whether it counts for the figures: a cutting move, after the first reversals.
    pub(super) fn measured(&self) -> bool {
        self.since.is_some() && self.command.path_speed > 0.0 && !self.without_gap.rapid
    }
}

/// The part of a signed contour error that backlash causes: with the gap minus without (errors and
/// loads with and without, mm). It can be no larger than the loads are apart. Where the difference
/// is larger all the same, the path turns back so sharply that one place lies on its left and on
/// its right: there the signs mean nothing, and the magnitudes are compared.
pub(super) fn caused_mm([with, without]: [f64; 2], [load, ideal]: [[f64; 3]; 2]) -> f64 {
    // Triangle inequality: the distance to the path changes by no more than the loads are apart.
    let apart = load
        .iter()
        .zip(ideal)
        .map(|(a, b)| (a - b) * (a - b))
        .sum::<f64>()
        .sqrt();
    let difference = with - without;
    // Tolerance for rounding, and for the foot point, which is found to a hundredth.
    if difference.abs() <= 1.01 * apart + 1e-6 {
        difference
    } else {
        (with.abs() - without.abs()).clamp(-apart, apart)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_the_path_turns_back_only_magnitudes_are_compared() {
        let at = |x: f64| [x, 0.0, 0.0];
        assert!((caused_mm([3e-3, -1e-3], [at(4e-3), at(0.0)]) - 4e-3).abs() < 1e-18);
        // 20 um on either side of a cusp, loads 1 um apart
        assert!((caused_mm([20e-3, -19.5e-3], [at(1e-3), at(0.0)]) - 0.5e-3).abs() < 1e-15);
        assert!((caused_mm([20e-3, -15e-3], [at(1e-3), at(0.0)]) - 1e-3).abs() < 1e-15);
    }
}
