//! The choice between a stop and blends of several lengths.

use super::blend::{self, Blend};
use crate::piece::Soft;
use crate::piece::{Piece, Programmed};

/// Lengths of a blend that are tried, and what follows of each is of it: one that takes all of its
/// room may bend more than a shorter one.
const TRIES: usize = 3;
const SHORTER: f64 = 0.7;

/// Decides between a blend and a stop.
pub(crate) trait Judge {
    /// Whether the blend is faster than coming to rest at the corner, whose tolerance is given in
    /// mm.
    fn is_faster(
        &self,
        blend: &Piece,
        before: &Programmed,
        next: &Programmed,
        tolerance: f64,
    ) -> bool;

    /// How soft the motions before and after a stop should be, so that they may overlap.
    fn soft(&self, before: &Programmed, next: &Programmed, tolerance: f64) -> Option<Soft>;
}

/// The longest blend between two moves that takes no more than so much of either and is faster than
/// a stop, if there is one.
pub(super) fn best_blend(
    before: &Programmed,
    next: &Programmed,
    tolerance: f64,
    longest: f64,
    judge: &dyn Judge,
) -> Option<(f64, Piece)> {
    let mut room = longest;
    for _ in 0..TRIES {
        let blend = blend::blend(&before.curve, &next.curve, tolerance, room)?;
        let piece = join(&blend, before, next);
        if judge.is_faster(&piece, before, next, tolerance) {
            return Some((blend.half, piece));
        }
        room = SHORTER * blend.half;
    }
    None
}

/// The piece that a blend makes.
fn join(blend: &Blend, before: &Programmed, next: &Programmed) -> Piece {
    let marks = [
        before.mark(0.0, before.length - blend.half),
        next.mark(blend.half, 0.0),
    ];
    let heeds = before.heeds.max(next.heeds);
    Piece {
        curve: blend.quintic.into(),
        marks,
        feed: before.feed.min(next.feed),
        heeds,
        tool_mm: next.tool_mm,
    }
}
