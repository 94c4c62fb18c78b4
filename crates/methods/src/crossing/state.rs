//! What a crossing carries from tick to tick.

use crate::passage::Passage;
use crate::traverse::Traverse;
use lostmotion_drive::twin::{Shown, TwinState};
use serde::{Deserialize, Serialize};

/// What the crossing carries along.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CrossingState {
    pub(crate) twin: TwinState,
    /// The twin before its last step.
    pub(crate) before: Shown,
    pub(crate) side: i8,
    pub(super) traverse: Traverse,
    /// Whether the traverse takes up a half gap that changed, on the same flank.
    pub(super) taking_up: bool,
    /// Reference velocity and acceleration as the axis follows them.
    pub(super) lagged: [f64; 2],
    pub(super) passage: Passage,
    pub(super) wound: f64,
    /// Torque of the motor, averaged over the times of `HOLDING_TICKS`, N m.
    pub(super) holding: [f64; 2],
    /// Ticks of rest since the last traverse.
    pub(super) held_ticks: u32,
}

impl CrossingState {
    /// Whether it is on its way from flank to flank.
    pub(crate) fn crossing(&self) -> bool {
        self.traverse.moving() && !self.taking_up
    }

    pub(super) fn new(twin: TwinState) -> CrossingState {
        CrossingState {
            before: twin.shown(),
            twin,
            side: 0,
            traverse: Traverse::default(),
            taking_up: false,
            lagged: [0.0; 2],
            passage: Passage::default(),
            wound: 0.0,
            holding: [0.0; 2],
            held_ticks: 0,
        }
    }
}
