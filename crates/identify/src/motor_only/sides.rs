//! Which flank the contact torque presses on, window by window.

use crate::{
    contact::{MIN_TORQUE_SHARE, NOISE_FACTOR, noise},
    error::NotExcited,
    settings::FitSettings,
    window::WindowSample,
};
use lostmotion_base::math::quantile;

/// A side, and the first and the last window of a stretch of it.
pub(super) type Stretch = (i8, usize, usize);

/// Sides by the sign of the torque.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sides {
    sides: Vec<i8>,
    pub(super) threshold_nm: f64,
    largest_nm: f64,
}

impl Sides {
    pub(super) fn new(
        windows: &[WindowSample],
        settings: &FitSettings,
    ) -> Result<Sides, NotExcited> {
        let torques = || windows.iter().map(|window| window.torque_nm);
        // As in the fit with a load position: a high quantile of the torque, and the noise.
        let largest_nm = quantile(torques().map(f64::abs).collect(), 0.999);
        let threshold_nm = settings.torque_threshold_nm.unwrap_or_else(|| {
            (MIN_TORQUE_SHARE * largest_nm).max(NOISE_FACTOR * noise(torques()))
        });
        if largest_nm <= threshold_nm {
            return Err(NotExcited::TorqueBelowThreshold {
                largest_nm,
                threshold_nm,
            });
        }
        let side = |torque: f64| {
            if torque.abs() <= threshold_nm {
                0
            } else {
                torque.signum() as i8
            }
        };
        Ok(Sides {
            sides: torques().map(side).collect(),
            threshold_nm,
            largest_nm,
        })
    }

    /// Side of a window, 0 if unsure or beyond the log.
    pub(super) fn of(&self, window: usize) -> i8 {
        self.sides.get(window).copied().unwrap_or(0)
    }

    /// Whether a window and two on either side press on one flank: contact that begins within a
    /// neighbour's triangle may begin within its own.
    pub(super) fn firm(&self, window: usize) -> bool {
        let side = self.of(window);
        side != 0 && window >= 2 && (window - 2..=window + 2).all(|n| self.of(n) == side)
    }

    pub(super) fn largest_nm(&self) -> f64 {
        self.largest_nm
    }

    /// How often a stretch of one side is followed by one of the other.
    pub(super) fn changes(&self) -> usize {
        self.stretches()
            .windows(2)
            .filter(|pair| pair[0].0 != pair[1].0)
            .count()
    }

    /// Stretches of one side, first and last window, unsure ones left out.
    pub(super) fn stretches(&self) -> Vec<Stretch> {
        let mut stretches = Vec::new();
        let mut first = 0;
        for run in self.sides.chunk_by(|a, b| a == b) {
            // Runs of one or two windows are noise near the threshold.
            if run[0] != 0 && run.len() >= 3 {
                stretches.push((run[0], first, first + run.len() - 1));
            }
            first += run.len();
        }
        stretches
    }
}
