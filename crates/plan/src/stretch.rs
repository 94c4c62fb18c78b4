//! Motion in time between two stops.

use crate::motion::{Knot, PathState, Profile};
use crate::piece::Piece;
use lostmotion_base::Coords;
use std::collections::VecDeque;
use std::sync::Arc;

/// The motion between two stops.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    /// When it starts, s since the start of the program.
    pub(crate) start_s: f64,
    /// Place and time on the path.
    pub(crate) profile: Profile,
    /// Where on the path it starts.
    pub(crate) from: f64,
    /// Pieces of the path with the place where each begins.
    pieces: VecDeque<(f64, Arc<Piece>)>,
    /// Time up to which the motion was final before the last part was added, s.
    settled_s: f64,
    /// Whether it comes to rest at its end and nothing more will be added.
    pub(crate) complete: bool,
    /// The corner at its start, if it sets out before the stretch before has come to rest.
    pub(crate) corner: Option<Coords>,
}

impl Stretch {
    pub(crate) fn new(from: f64) -> Stretch {
        Stretch {
            start_s: 0.0,
            profile: Profile::default(),
            from,
            pieces: VecDeque::new(),
            settled_s: 0.0,
            complete: false,
            corner: None,
        }
    }

    /// Adds pieces and the motion over them.
    pub(crate) fn extend(
        &mut self,
        pieces: impl Iterator<Item = (f64, Arc<Piece>)>,
        knots: &[Knot],
    ) {
        self.pieces.extend(pieces);
        self.settled_s = self.profile.end_s();
        self.profile.extend(knots);
    }

    /// When the motion ends as far as it is known, s since the start of the program.
    pub(crate) fn rest_s(&self) -> f64 {
        self.start_s + self.profile.end_s()
    }

    /// The longest time at its start, and at its end if it is complete, over which it may move
    /// together with its neighbour: less than half of it, and nothing of what may have been sampled
    /// before its end was known.
    pub(crate) fn longest_overlap_s(&self) -> f64 {
        let half = 0.5 * self.profile.end_s();
        if self.complete {
            half.min(self.profile.end_s() - self.settled_s)
        } else {
            half
        }
    }

    /// Up to when the motion is known for good, s since the start of the program.
    pub(crate) fn known_s(&self) -> f64 {
        if self.complete {
            self.rest_s() - self.longest_overlap_s()
        } else {
            self.rest_s()
        }
    }

    /// The motion at a time that never falls; what lies before it is forgotten.
    pub(crate) fn advance(&mut self, t: f64) -> PathState {
        let motion = self.profile.advance(t);
        while self.pieces.len() > 1
            && self
                .pieces
                .get(1)
                .is_some_and(|(start, _)| *start <= motion.s)
        {
            self.pieces.pop_front();
        }
        motion
    }

    /// The piece at the place where it has advanced to, and the place on it.
    pub(crate) fn here(&self, s: f64) -> Option<(&Piece, f64)> {
        self.pieces
            .front()
            .map(|(start, piece)| (piece.as_ref(), (s - start).max(0.0)))
    }

    /// The piece at a place and the place on it.
    pub(crate) fn peek(&self, s: f64) -> Option<(&Piece, f64)> {
        let index = self
            .pieces
            .partition_point(|(start, _)| *start <= s)
            .saturating_sub(1);
        self.pieces
            .get(index)
            .map(|(start, piece)| (piece.as_ref(), (s - start).max(0.0)))
    }

    /// The first piece of those that it holds.
    pub(crate) fn first(&self) -> Option<&Piece> {
        self.pieces.front().map(|(_, piece)| piece.as_ref())
    }

    /// The last piece.
    pub(crate) fn last(&self) -> Option<&Piece> {
        self.pieces.back().map(|(_, piece)| piece.as_ref())
    }

    /// How many pieces it holds.
    pub(crate) fn len(&self) -> usize {
        self.pieces.len()
    }
}
