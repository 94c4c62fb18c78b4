//! The moved profile where pieces vanish: everything that keeps the distance from all of the
//! profile.

use super::piece::{MonotonePart, Piece, crossings};
use lostmotion_base::vec::{Vec2, cross2, distance2, dot};

/// Most comparisons of one profile: bounds the time of one cycle.
const MOST_COMPARISONS: usize = 1_000_000;

/// The pieces at a distance above the profile, cut where they cross each other, without those parts
/// that come nearer to it. `None` if what is left has gaps, or the profile is too long.
pub(crate) fn envelope(profile: &[Piece], by: f64, forgiven: f64) -> Option<Vec<Piece>> {
    // 1. Offset every piece and round the outside corners.
    let raw = candidates(profile, by);
    let scale = 1.0
        + by
        + raw
            .iter()
            .map(|piece| piece.end[0].abs().max(piece.end[1].abs()))
            .fold(0.0, f64::max);
    // Rounding grows with the coordinates, so that the tolerance scales with them.
    let close = 1e-9 * scale;
    let reaches: Vec<[f64; 2]> = raw.iter().map(|piece| piece.reach(0)).collect();
    let mut work = 0;
    let mut kept: Vec<(usize, Piece)> = Vec::new();
    for (index, (piece, &[low, high])) in raw.iter().zip(&reaches).enumerate() {
        // 2. Cut each piece where others cross it; a sweep along the travel skips pieces that are apart.
        let mut cuts = vec![0.0, 1.0];
        for (other, (with, &[from, to])) in raw.iter().zip(&reaches).enumerate() {
            if other == index || from > high + close || to < low - close {
                continue;
            }
            work += 1;
            let places = crossings(piece, with, close).into_iter().flatten();
            cuts.extend(places.filter_map(|place| {
                share(piece, place, close).filter(|_| share(with, place, close).is_some())
            }));
        }
        // 3. Keep the parts whose middle has the full distance from the whole profile.
        cuts.sort_by(f64::total_cmp);
        for pair in cuts.windows(2) {
            let &[from, to] = pair else { continue };
            work += profile.len();
            if work > MOST_COMPARISONS {
                return None;
            }
            if to - from > 1e-9
                && is_free(profile, piece.at(0.5 * (from + to)), by - forgiven - close)
            {
                push(
                    &mut kept,
                    index,
                    Piece {
                        start: piece.at(from),
                        end: piece.at(to),
                        circle: piece.circle,
                    },
                    close,
                );
            }
        }
    }
    // 4. Order the parts along the travel and join them.
    kept.sort_by(|(i, a), (j, b)| {
        let [u, v] = [a, b].map(|piece| 0.5 * (piece.start[0] + piece.end[0]));
        if (u - v).abs() > close {
            u.total_cmp(&v)
        } else {
            i.cmp(j)
        }
    });
    chain(kept, close, 10.0 * forgiven + 1e3 * close)
}

/// All pieces moved, and the corners that stick out rounded.
fn candidates(profile: &[Piece], by: f64) -> Vec<Piece> {
    let mut raw: Vec<Piece> = Vec::with_capacity(2 * profile.len());
    for (index, piece) in profile.iter().enumerate() {
        let next = piece.offset(by);
        if let Some(before) = index.checked_sub(1).and_then(|before| profile.get(before)) {
            let (leaves, enters) = (before.heading(before.end), piece.heading(piece.start));
            // A turn to the right, away from the material, opens a gap: an arc about the corner
            // fills it.
            let turn = cross2(leaves, enters);
            if turn < -1e-9 || (turn.abs() <= 1e-9 && dot(leaves, enters) < 0.0 && leaves[1] > 0.0)
            {
                let out = |way: Vec2| [before.end[0] - by * way[1], before.end[1] + by * way[0]];
                raw.push(Piece::arc(out(leaves), out(enters), before.end, false));
            }
        }
        raw.extend(next);
    }
    raw
}

/// Where on a piece a place lies, from 0 to 1; `None` if it is beyond its ends.
fn share(piece: &Piece, place: Vec2, close: f64) -> Option<f64> {
    let share = if piece.circle.is_some() {
        // The share of the sweep; just before the start counts as the start.
        let turned = piece.turned(place);
        let sweep = piece.sweep();
        let over = close / piece.radius().unwrap_or(1.0).max(close);
        if std::f64::consts::TAU - turned <= over {
            0.0
        } else if turned <= sweep + over {
            turned / sweep
        } else {
            return None;
        }
    } else {
        // Projection onto the line, in parts of its length.
        let way = [piece.end[0] - piece.start[0], piece.end[1] - piece.start[1]];
        let length = dot(way, way).max(f64::MIN_POSITIVE);
        let share = dot([place[0] - piece.start[0], place[1] - piece.start[1]], way) / length;
        let over = close / length.sqrt();
        if share < -over || share > 1.0 + over {
            return None;
        }
        share
    };
    Some(share.clamp(0.0, 1.0))
}

/// Whether a place keeps the distance from the profile and lies above it.
fn is_free(profile: &[Piece], place: Vec2, by: f64) -> bool {
    let mut ground = f64::NEG_INFINITY;
    for piece in profile {
        // Nearer than the distance to any piece: the cut would take off finishing stock.
        if piece.away(place) < by {
            return false;
        }
        let (stretches, count) = piece.stretches();
        for stretch in stretches.iter().take(count) {
            ground = ground.max(height(piece, stretch, place[0]));
        }
    }
    place[1] > ground
}

/// How high a stretch is at a place along the travel; of an upright one the lower end.
fn height(piece: &Piece, stretch: &MonotonePart, at: f64) -> f64 {
    let [from, to] = [stretch.from, stretch.to];
    if !(from[0].min(to[0])..=from[0].max(to[0])).contains(&at) {
        return f64::NEG_INFINITY;
    }
    if let (Some(circle), Some(radius)) = (piece.circle, piece.radius()) {
        // Height of the circle above its centre at this abscissa, on the stretch's own half.
        let across = at - circle.center[0];
        let half = (radius * radius - across * across).max(0.0).sqrt();
        return circle.center[1]
            + if from[1] + to[1] > 2.0 * circle.center[1] {
                half
            } else {
                -half
            };
    }
    let run = to[0] - from[0];
    if run.abs() < 1e-12 {
        from[1].min(to[1])
    } else {
        from[1] + (at - from[0]) / run * (to[1] - from[1])
    }
}

/// Adds a part, to the last one if it goes on with that.
fn push(kept: &mut Vec<(usize, Piece)>, index: usize, part: Piece, close: f64) {
    if let Some((last, before)) = kept.last_mut()
        && *last == index
        && distance2(before.end, part.start) <= close
    {
        before.end = part.end;
        return;
    }
    kept.push((index, part));
}

/// The parts in their order, joined; `None` if there is a gap. Parts that nearly touch are joined
/// where they cross.
fn chain(kept: Vec<(usize, Piece)>, close: f64, gap: f64) -> Option<Vec<Piece>> {
    let mut chain: Vec<Piece> = Vec::with_capacity(kept.len());
    for (_, mut piece) in kept {
        if let Some(before) = chain.last_mut() {
            let apart = distance2(before.end, piece.start);
            if apart > gap {
                return None;
            }
            // Small gaps come from rounding: the neighbours are prolonged to where they cross.
            if apart > close {
                let places = crossings(before, &piece, 0.0).into_iter().flatten();
                let near = places.min_by(|a, b| {
                    distance2(*a, piece.start).total_cmp(&distance2(*b, piece.start))
                });
                before.end = near
                    .filter(|place| distance2(*place, piece.start) <= gap)
                    .unwrap_or(piece.start);
            }
            piece.start = before.end;
        }
        chain.push(piece);
    }
    if chain.is_empty() { None } else { Some(chain) }
}
