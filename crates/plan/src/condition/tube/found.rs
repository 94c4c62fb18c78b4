//! A curve inside the tube with the moves under it.

use crate::piece::Piece;
use lostmotion_base::vec::{along, dot, norm};
use lostmotion_path::{Curve, HermiteEnd};
use std::ops::Range;

/// A curve that was found and proven.
#[derive(Clone, Debug)]
pub(in crate::condition) struct Found {
    pub(in crate::condition) pieces: Vec<Piece>,
    /// The state at the end of each piece.
    pub(in crate::condition) ends: Vec<HermiteEnd>,
    /// Line and parameter on it at the end of each piece.
    pub(in crate::condition) places: Vec<(usize, f64)>,
    /// By piece, the speed at both ends of the motion as which it was found, mm/s; none where that was at
    /// a steady pace.
    pub(in crate::condition) speeds: Vec<Option<[f64; 2]>>,
}

impl Found {
    /// The curvature where some of its pieces end, 1/mm.
    pub(in crate::condition) fn bend(&self, pieces: usize) -> f64 {
        let Some(end) = pieces.checked_sub(1).and_then(|last| self.ends.get(last)) else {
            return f64::INFINITY;
        };
        let (d1, d2) = (end.d1.linear(), end.d2.linear());
        let square = dot(d1, d1);
        norm(along(d2, d1, -dot(d1, d2) / square)) / square
    }

    /// Whether some of it was found as a motion.
    pub(in crate::condition) fn has_motion(&self) -> bool {
        self.speeds.iter().any(Option::is_some)
    }

    /// Its pieces; those of a motion straight, with its speeds as feeds.
    pub(in crate::condition) fn straightened(&self) -> impl Iterator<Item = Piece> {
        let pieces = self.pieces.iter().zip(&self.speeds);
        pieces.map(|(piece, speeds)| match speeds {
            None => piece.clone(),
            Some([from, to]) => Piece {
                feed: piece.feed.min(from.max(*to)),
                curve: Curve::line(piece.curve.start(), piece.curve.end()),
                ..piece.clone()
            },
        })
    }

    /// Keeps so many pieces, and returns those behind, whose lines are counted from that on which they begin.
    pub(in crate::condition) fn split_off(&mut self, pieces: usize) -> Found {
        let first = self.places[pieces - 1].0;
        let places = self.places.split_off(pieces).into_iter();
        Found {
            pieces: self.pieces.split_off(pieces),
            ends: self.ends.split_off(pieces),
            places: places.map(|(line, s)| (line - first, s)).collect(),
            speeds: self.speeds.split_off(pieces),
        }
    }

    /// Puts a motion in the place of some of its pieces.
    pub(super) fn replace(&mut self, pieces: Range<usize>, motion: Found) {
        self.pieces.splice(pieces.clone(), motion.pieces);
        self.ends.splice(pieces.clone(), motion.ends);
        self.places.splice(pieces.clone(), motion.places);
        self.speeds.splice(pieces, motion.speeds);
    }
}
