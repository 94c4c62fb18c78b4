//! The profile at a distance above itself, what is left for finishing; and its corners, rounded or
//! chamfered (A and C words).

use super::envelope::envelope;
use super::piece::{Piece, crossings, joints};
use lostmotion_base::vec::{Vec2, along, cross2, distance2, dot, sub};

/// Largest turn that counts as no corner, rad. A choice: about what rounding to three decimals
/// turns a move of a millimetre by (7e-4).
const SMOOTH_TURN_RAD: f64 = 1e-3;
/// Rounded corners that would be shorter than this along the travel are left as points, where the
/// moves prolonged meet: recorded at all directions and distances tried.
const SHORT_ROUNDING: f64 = 0.01;
/// Cosine of the largest turn at which that is done. Recorded: 60 degrees.
const BLUNT_TURN_COS: f64 = 0.5;
/// Largest distance of a touching joint from where the pieces meet, in parts of their length. A
/// choice: larger takes a far crossing of the same curves for the joint, smaller misses joints at
/// flat angles.
const JOINT_REACH: f64 = 0.1;

/// How one piece goes on into the next.
enum Joint {
    /// Rounded about the corner.
    Rounded,
    /// Both end here.
    At(Vec2),
    /// They do not meet.
    None,
}

/// The profile moved up by a distance, corners that stick out rounded. `forgiven` is by how much
/// ends of arcs may miss one another, which they do by the rounding of the program. `None` if the
/// distance does not fit into the profile.
pub(crate) fn offset(profile: &[Piece], by: f64, forgiven: f64) -> Option<Vec<Piece>> {
    if by == 0.0 {
        return Some(profile.to_vec());
    }
    // Joining neighbours is exact and usual; the envelope copes with pieces that vanish.
    adjacent(profile, by, forgiven).or_else(|| envelope(profile, by, forgiven))
}

/// Each piece joined with its neighbour. `None` if a piece vanishes.
fn adjacent(profile: &[Piece], by: f64, forgiven: f64) -> Option<Vec<Piece>> {
    let mut moved: Vec<Piece> = Vec::with_capacity(2 * profile.len());
    let mut last: Option<(&Piece, Piece)> = None;
    for piece in profile {
        // The held piece gets its end, the new one its start, where the two offsets meet.
        let mut next = piece.offset(by)?;
        if let Some((before, mut held)) = last.take() {
            match joint(before, &held, piece, &next, forgiven) {
                Joint::Rounded => {
                    moved.push(held);
                    moved.push(Piece::arc(held.end, next.start, before.end, false));
                }
                Joint::At(place) => {
                    (held.end, next.start) = (place, place);
                    moved.push(held);
                }
                Joint::None => return None,
            }
        }
        last = Some((piece, next));
    }
    moved.extend(last.map(|(_, held)| held));
    // A piece that now goes backwards has vanished between its neighbours.
    let forward = moved.iter().all(|piece| piece.advances(forgiven + 1e-9));
    (forward && keeps_directions(profile, &moved)).then_some(moved)
}

/// Lines have to go the way they went: each one of the moved profile follows its original's
/// direction.
fn keeps_directions(profile: &[Piece], moved: &[Piece]) -> bool {
    let lines = |pieces: &[Piece]| {
        pieces
            .iter()
            .filter(|piece| piece.circle.is_none())
            .copied()
            .collect::<Vec<_>>()
    };
    lines(profile).iter().zip(&lines(moved)).all(|(was, is)| {
        let way = [is.end[0] - is.start[0], is.end[1] - is.start[1]];
        dot(was.heading(was.start), way) >= -1e-9
    })
}

fn joint(before: &Piece, held: &Piece, piece: &Piece, next: &Piece, forgiven: f64) -> Joint {
    let (leaves, enters) = (before.heading(before.end), piece.heading(piece.start));
    let turn = cross2(leaves, enters);
    let onwards = dot(leaves, enters) > 0.0;
    // Straight on: the offsets touch.
    if onwards && turn.abs() < SMOOTH_TURN_RAD {
        return Joint::At(touching(held, next, forgiven));
    }
    // Of two crossings the joint is the one nearer to the corner of the profile.
    let near = |places: [Vec2; 2]| {
        let [first, second] = places;
        if distance2(first, before.end) <= distance2(second, before.end) {
            first
        } else {
            second
        }
    };
    let met = joints(held, next, 0.0).map(near);
    // A corner that sticks out is rounded; short roundings are left as points.
    if turn < 0.0 || (turn.abs() < SMOOTH_TURN_RAD && leaves[1] > 0.0) {
        let short = (next.start[0] - held.end[0]).abs() < SHORT_ROUNDING
            && dot(leaves, enters) > BLUNT_TURN_COS;
        return met.filter(|_| short).map_or(Joint::Rounded, Joint::At);
    }
    met.map_or(Joint::None, Joint::At)
}

/// Where pieces that go on in the same direction meet. They miss each other by the rounding of the
/// program; of two crossings the tool takes the first, as the recordings show where one arc turns
/// into another.
fn touching(held: &Piece, next: &Piece, forgiven: f64) -> Vec2 {
    if distance2(held.end, next.start) < 1e-9 || (held.circle.is_none() && next.circle.is_none()) {
        return held.end;
    }
    // Touching curves cross far away, too: only near joints count.
    let reach = JOINT_REACH * distance2(held.start, held.end).min(distance2(next.start, next.end));
    let places = joints(held, next, forgiven).into_iter().flatten();
    let close = places.filter(|place| distance2(*place, held.end) <= reach);
    close
        .min_by(|a, b| a[0].total_cmp(&b[0]))
        .unwrap_or(held.end)
}

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
    let turn = cross2(leaves, enters);
    if turn.abs() < 1e-9 {
        return if dot(leaves, enters) > 0.0 {
            Some(None)
        } else {
            None
        };
    }
    let radius = corner.size();
    let side = if turn > 0.0 { radius } else { -radius };
    // The centre of the fillet has the radius as its distance from both pieces.
    let center = nearest(
        crossings(&before.offset(side)?, &after.offset(side)?, 0.0)?,
        before.end,
    );
    let (from, to) = (foot(before, center), foot(after, center));
    if !within(before, from) || !within(after, to) {
        return None;
    }
    // Both pieces end at their foot points of the centre, where the fillet is tangent.
    (before.end, after.start) = (from, to);
    Some(Some(match corner {
        Corner::Fillet(_) => Piece::arc(from, to, center, turn > 0.0),
        Corner::Chamfer(_) => Piece::line(from, to),
    }))
}

fn nearest([first, second]: [Vec2; 2], to: Vec2) -> Vec2 {
    if distance2(first, to) <= distance2(second, to) {
        first
    } else {
        second
    }
}

/// The place of a piece that is nearest to another place.
fn foot(piece: &Piece, place: Vec2) -> Vec2 {
    let Some(circle) = piece.circle else {
        let way = piece.heading(piece.start);
        return along(piece.start, way, dot(sub(place, piece.start), way));
    };
    // On a circle the foot point lies on the ray through the place.
    let out = sub(place, circle.center);
    let length = distance2(circle.center, place);
    let radius = piece.radius().unwrap_or_default();
    if length > 0.0 {
        along(circle.center, [out[0] / length, out[1] / length], radius)
    } else {
        piece.start
    }
}

fn within(piece: &Piece, place: Vec2) -> bool {
    match piece.circle {
        Some(_) => piece.turned(place) <= piece.sweep() + 1e-9,
        None => {
            let way = sub(piece.end, piece.start);
            let along = dot(sub(place, piece.start), way);
            let length = dot(way, way);
            along >= -1e-9 * length && along <= length * (1.0 + 1e-9)
        }
    }
}
