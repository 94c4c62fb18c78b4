//! How high a program cuts: above, the tool may go a little beyond its places.

use super::{Moves, STILL_MM};

/// How high the program cuts, machine coordinates of the tool, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Heights {
    /// Highest place of all cuts, with plunges and retracts.
    cuts: f64,
    /// Highest place of those that move X or Y.
    across: f64,
}

impl Heights {
    /// Of all cuts of a program.
    pub(super) fn of(moves: &Moves<'_>) -> Heights {
        let mut heights = Heights {
            cuts: f64::NEG_INFINITY,
            across: f64::NEG_INFINITY,
        };
        let all = moves.steps.iter().zip(moves.pieces);
        for (step, pieces) in all.filter(|(step, _)| !step.rapid) {
            for piece in pieces {
                let top = piece.start[2].max(piece.end[2]) - step.tool_z_mm;
                heights.cuts = heights.cuts.max(top);
                if piece.direction[0] != 0.0 || piece.direction[1] != 0.0 {
                    heights.across = heights.across.max(top);
                }
            }
        }
        heights
    }

    /// Whether the tool may go a little beyond its place in X and Y at a height: it is as high as all cuts,
    /// and clear of those that go across.
    pub(super) fn are_below(&self, height: f64) -> bool {
        height >= self.cuts && height > self.across + STILL_MM
    }
}
