//! A and C words of a profile: rounded and chamfered corners.

use super::crossing::crossings;
use super::piece::{Piece, Point, along, cross, distance, dot, minus};

/// A corner between a piece and the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Corner {
    /// A: the radius.
    Fillet(f64),
    /// C: from where a fillet of this radius would begin straight to where it would end.
    Chamfer(f64),
}

impl Corner {
    /// Its word.
    pub(crate) const fn letter(self) -> char {
        match self {
            Corner::Fillet(_) => 'A',
            Corner::Chamfer(_) => 'C',
        }
    }

    pub(crate) const fn size(self) -> f64 {
        match self {
            Corner::Fillet(size) | Corner::Chamfer(size) => size,
        }
    }
}

/// Shortens two pieces so that a corner fits between them, and gives the corner. None where it does
/// not fit. Pieces that go on in the same direction have no corner.
pub(crate) fn corner(
    before: &mut Piece,
    after: &mut Piece,
    corner: Corner,
) -> Option<Option<Piece>> {
    let (leaves, enters) = (before.heading(before.end), after.heading(after.start));
    let turn = cross(leaves, enters);
    if turn.abs() < 1e-9 {
        return if dot(leaves, enters) > 0.0 {
            Some(None)
        } else {
            None
        };
    }
    let radius = corner.size();
    let side = if turn > 0.0 { radius } else { -radius };
    let center = nearest(
        crossings(&before.offset(side)?, &after.offset(side)?, 0.0)?,
        before.end,
    );
    let (from, to) = (foot(before, center), foot(after, center));
    if !within(before, from) || !within(after, to) {
        return None;
    }
    (before.end, after.start) = (from, to);
    Some(Some(match corner {
        Corner::Fillet(_) => Piece::arc(from, to, center, turn > 0.0),
        Corner::Chamfer(_) => Piece::line(from, to),
    }))
}

fn nearest([first, second]: [Point; 2], to: Point) -> Point {
    if distance(first, to) <= distance(second, to) {
        first
    } else {
        second
    }
}

/// The place of a piece that is nearest to another place.
fn foot(piece: &Piece, place: Point) -> Point {
    let Some(circle) = piece.circle else {
        let way = piece.heading(piece.start);
        return along(piece.start, way, dot(minus(place, piece.start), way));
    };
    let out = minus(place, circle.center);
    let length = distance(circle.center, place);
    let radius = piece.radius().unwrap_or_default();
    if length > 0.0 {
        along(circle.center, [out[0] / length, out[1] / length], radius)
    } else {
        piece.start
    }
}

fn within(piece: &Piece, place: Point) -> bool {
    match piece.circle {
        Some(_) => piece.turned(place) <= piece.sweep() + 1e-9,
        None => {
            let way = minus(piece.end, piece.start);
            let along = dot(minus(place, piece.start), way);
            let length = dot(way, way);
            along >= -1e-9 * length && along <= length * (1.0 + 1e-9)
        }
    }
}
