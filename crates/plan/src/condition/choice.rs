//! The choice between a stop and blends of several lengths.

use super::blend::{self, Blend};
use super::piece::{Piece, Programmed};
use crate::soft::Soft;

/// Parts of the room for a blend that are tried: one that takes all of it may bend more than a shorter one.
const PARTS: [f64; 3] = [1.0, 0.7, 0.5];
/// A blend that leaves more of its room is as long as its tolerance allows.
const NEARLY: f64 = 0.99;
/// Decides between a blend and a stop.
pub(crate) trait Judge {
    /// Whether the blend is faster than coming to rest at the corner, whose tolerance is given in mm.
    fn is_faster(&self, blend: &Piece, before: &Programmed, next: &Programmed, tolerance: f64) -> bool;

    /// How soft the motions before and after a stop should be, so that they may overlap.
    fn soft(&self, before: &Programmed, next: &Programmed, tolerance: f64) -> Option<Soft>;
}

/// The longest blend between two moves that takes no more than so much of either and is faster than a stop, if there is one.
pub(super) fn best_blend(before: &Programmed, next: &Programmed, tolerance: f64, longest: f64, judge: &dyn Judge) -> Option<(f64, Piece)> {
    for room in PARTS.map(|part| part * longest) {
        let Some(blend) = blend::blend(&before.curve, &next.curve, tolerance, room) else { continue };
        let piece = join(&blend, before, next);
        if judge.is_faster(&piece, before, next, tolerance) {
            return Some((blend.half, piece));
        }
        // A shorter one would be the same, or slower.
        if blend.half < NEARLY * room {
            break;
        }
    }
    None
}

/// The piece that a blend makes.
fn join(blend: &Blend, before: &Programmed, next: &Programmed) -> Piece {
    let marks = [before.mark(0.0, before.length - blend.half), next.mark(blend.half, 0.0)];
    let heeds = before.heeds.max(next.heeds);
    Piece { curve: blend.quintic.into(), marks, feed: before.feed.min(next.feed), heeds, tool_mm: next.tool_mm }
}
