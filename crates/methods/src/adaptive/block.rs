//! Half of a triangle: sums over 4 ms, from two of which in a row come means weighted with a
//! triangle over 8 ms.

use lostmotion_drive::Signals;
use serde::{Deserialize, Serialize};

/// Ticks of a block: 4 ms.
pub(super) const BLOCK: u32 = 16;

/// Half of a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Block {
    pub(super) ticks: u32,
    /// Sums of the current with rising and with falling weights, ticks times A.
    pub(super) rising: f64,
    pub(super) falling: f64,
    /// Position of the motor at its start, sum of those since less that, rad.
    pub(super) position: f64,
    pub(super) way: f64,
}

impl Block {
    /// Begins at a position, rad.
    pub(super) fn start(position: f64) -> Block {
        Block {
            position,
            ..Block::default()
        }
    }

    /// Takes the tick that ends now.
    pub(super) fn push(&mut self, signals: &Signals) {
        let part = (f64::from(self.ticks) + 0.5) / f64::from(BLOCK);
        self.rising += part * signals.mean_current;
        self.falling += (1.0 - part) * signals.mean_current;
        self.way += signals.motor_position - self.position;
        self.ticks += 1;
    }
}
