//! Motion in time between two stops, smoothed by a moving average.

use crate::condition::Piece;
use crate::profile::Node;
use crate::smooth::{Motion, Smooth};
use lostmotion_base::Coords;
use std::collections::VecDeque;

/// The motion between two stops. The planned profile has steps of acceleration; what is commanded is its moving average.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    /// When the profile starts, s since the start of the program.
    pub(crate) start_s: f64,
    /// Place and time on the path.
    pub(crate) smooth: Smooth,
    /// Pieces of the path with the place where each begins.
    pieces: VecDeque<(f64, Piece)>,
    /// Time of the profile that was final before the last part was added, s.
    settled_s: f64,
    /// Whether the profile comes to rest at its end and nothing more will be added.
    pub(crate) complete: bool,
    /// The corner at its start, if it sets out before the stretch before has come to rest.
    pub(crate) corner: Option<Coords>,
}

impl Stretch {
    pub(crate) fn new(window_s: f64, from: f64) -> Stretch {
        let smooth = Smooth::new(window_s, from);
        Stretch { start_s: 0.0, smooth, pieces: VecDeque::new(), settled_s: 0.0, complete: false, corner: None }
    }

    /// Adds pieces and the profile over them.
    pub(crate) fn extend(&mut self, pieces: impl Iterator<Item = (f64, Piece)>, nodes: &[Node]) {
        self.pieces.extend(pieces);
        self.settled_s = self.smooth.profile_s();
        self.smooth.extend(nodes);
    }

    /// When the commanded motion ends, s since the start of the program.
    pub(crate) fn rest_s(&self) -> f64 {
        self.start_s + self.smooth.duration_s()
    }

    /// The longest time at its start, and at its end if it is complete, over which it may move together with its
    /// neighbour: less than half of it, and nothing of what may have been sampled before its end was known.
    pub(crate) fn longest_overlap_s(&self) -> f64 {
        let (profile, whole) = (self.smooth.profile_s(), self.smooth.duration_s());
        if self.complete { (0.5 * whole).min(whole - self.settled_s) } else { 0.5 * profile }
    }

    /// Up to when the motion is known for good, s since the start of the program.
    pub(crate) fn known_s(&self) -> f64 {
        let profile = self.start_s + self.smooth.profile_s();
        if self.complete { profile.min(self.rest_s() - self.longest_overlap_s()) } else { profile }
    }

    /// The commanded motion at a time that never falls; what lies before it is forgotten.
    pub(crate) fn advance(&mut self, t: f64) -> Motion {
        self.smooth.forget(t);
        let motion = self.smooth.motion(t);
        while self.pieces.len() > 1 && self.pieces.get(1).is_some_and(|(start, _)| *start <= motion.s) {
            self.pieces.pop_front();
        }
        motion
    }

    /// The piece at a place and the place on it.
    pub(crate) fn peek(&self, s: f64) -> Option<(&Piece, f64)> {
        let index = self.pieces.partition_point(|(start, _)| *start <= s).saturating_sub(1);
        self.pieces.get(index).map(|(start, piece)| (piece, (s - start).max(0.0)))
    }

    /// The first piece of those that it holds.
    pub(crate) fn first(&self) -> Option<&Piece> {
        self.pieces.front().map(|(_, piece)| piece)
    }

    /// The last piece.
    pub(crate) fn last(&self) -> Option<&Piece> {
        self.pieces.back().map(|(_, piece)| piece)
    }

    /// How many pieces it holds.
    pub(crate) fn len(&self) -> usize {
        self.pieces.len()
    }
}
