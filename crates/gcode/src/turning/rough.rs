//! Roughing: the material above the profile is taken off level by level.

use super::piece::{MonotonePart, Piece};
use lostmotion_base::vec::{Vec2, distance2};

/// Largest distance at which a level counts as reached, program units. Derived: far above the
/// rounding of coordinates (1e-13 at 1000 units), far below any programmed digit.
const LEVEL_SLACK: f64 = 1e-9;
/// Most parts looked at in the search for the ends of levels: bounds the time of one cycle.
const MOST_WORK: u64 = 200_000_000;

/// One move of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Move {
    Rapid(Vec2),
    Feed(Vec2),
    Arc { end: Vec2, center: Vec2, ccw: bool },
}

/// Which pockets are cleared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pockets {
    /// G71, G72.
    All,
    /// G71.1, G72.1: only the one that the tool comes from; later ones are passed over.
    First,
    /// G71.2, G72.2: only those after it.
    Later,
}

/// Depth of cut, retraction, which pockets, and how many moves may come out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Roughing {
    pub(crate) depth: f64,
    pub(crate) retract: f64,
    pub(crate) pockets: Pockets,
    pub(crate) most: usize,
}

/// Roughing under way.
struct Rougher<'a> {
    words: &'a Roughing,
    path: &'a [Piece],
    moves: Vec<Move>,
    /// Level from which the levels are counted: the highest place that the path has led over.
    top: f64,
    /// Cuts made from there.
    cuts: f64,
    work: u64,
}

/// The moves that rough a path. Its first piece leads from where the tool is to the moved profile:
/// above the material it is passed at rapid, and it and all that falls on after it belong to the
/// first pocket. `None` if there are too many.
pub(crate) fn rough(path: &[Piece], words: &Roughing) -> Option<Vec<Move>> {
    // Levels count from where the tool is; for later pockets from the first place that the path
    // rises to.
    let top = match (words.pockets, path.first()) {
        (Pockets::Later, _) | (_, None) => f64::NEG_INFINITY,
        (_, Some(entry)) => entry.start[1],
    };
    let mut rougher = Rougher {
        words,
        path,
        moves: Vec::new(),
        top,
        cuts: 0.0,
        work: 0,
    };
    // The first pocket lasts as long as the path falls from its start.
    let mut falling = true;
    let mut bridge = None;
    for (index, piece) in path.iter().enumerate() {
        let (stretches, count) = piece.stretches();
        let mut from = piece.start;
        for (at, stretch) in stretches.iter().take(count).enumerate() {
            // Recorded: a place from which an arc falls at once does not end the first pocket.
            if falling && distance2(stretch.from, stretch.to) < LEVEL_SLACK {
                continue;
            }
            falling = falling && !stretch.rises;
            if words.pockets == Pockets::First && !falling {
                rougher.over(piece, stretch, &mut bridge);
                continue;
            }
            // Cut all levels that begin on this part, then follow the profile down.
            from = rougher.levels((index, at), piece, stretch, from)?;
            if words.pockets == Pockets::First {
                rougher.along(piece, from, stretch.to, is_rapid(index, piece));
                from = stretch.to;
            }
        }
        if words.pockets != Pockets::First {
            rougher.along(piece, from, piece.end, is_rapid(index, piece));
        }
        if rougher.moves.len() > words.most || rougher.work > MOST_WORK {
            return None;
        }
    }
    Some(rougher.moves)
}

impl Rougher<'_> {
    /// Level of the next cut.
    fn level(&self) -> f64 {
        self.top - self.cuts * self.words.depth
    }

    /// Follows a stretch as far as levels begin on it, and cuts those. Gives the place it has come
    /// to.
    fn levels(
        &mut self,
        at: (usize, usize),
        piece: &Piece,
        stretch: &MonotonePart,
        mut from: Vec2,
    ) -> Option<Vec2> {
        if stretch.rises {
            self.rise(stretch.to[1]);
        }
        let rapid = is_rapid(at.0, piece);
        // Recorded: an arc is divided at its highest place, not at its lowest.
        if stretch.rises && piece.circle.is_some() && stretch.to != piece.end {
            self.along(piece, from, stretch.to, rapid);
            from = stretch.to;
        }
        // Wherever the path falls below the next level, a cut begins.
        while stretch.to[1] < self.level() - LEVEL_SLACK {
            let level = self.level();
            let place = if level >= stretch.from[1] {
                stretch.from
            } else {
                piece.at_level(stretch, level)
            };
            self.along(piece, from, place, rapid);
            from = place;
            self.cut(at, place, rapid);
            self.cuts += 1.0;
            if self.moves.len() > self.words.most || self.work > MOST_WORK {
                return None;
            }
        }
        Some(from)
    }

    /// The path has come up to a level: what it leads down from there is cut from there, or from
    /// the levels of the pocket that it rises in.
    fn rise(&mut self, to: f64) {
        if to > self.top {
            // Recorded: above where the cycle begins there is nothing to cut.
            if self.words.pockets == Pockets::Later {
                self.top = to;
            }
            self.cuts = 0.0;
        } else if to > self.level() {
            self.cuts = ((self.top - to) / self.words.depth - LEVEL_SLACK)
                .ceil()
                .max(0.0);
        }
    }

    /// A part of a piece. Parts of arcs that have no length are left out, those of lines are not
    /// (as recorded).
    fn along(&mut self, piece: &Piece, from: Vec2, to: Vec2, rapid: bool) {
        match piece.circle {
            Some(_) if distance2(from, to) < LEVEL_SLACK => {}
            Some(circle) => self.moves.push(Move::Arc {
                end: to,
                center: circle.center,
                ccw: circle.ccw,
            }),
            None if rapid => self.moves.push(Move::Rapid(to)),
            None => self.moves.push(Move::Feed(to)),
        }
    }

    /// Cuts a level from a place of the path to where the path comes up again, and goes back: away
    /// from the material by R at 45 degrees, but no further than half way, back along the level and
    /// down to the path.
    fn cut(&mut self, (index, stretch): (usize, usize), from: Vec2, rapid: bool) {
        let to = self.end_of_level(index, stretch, from);
        if to - from[0] < LEVEL_SLACK {
            return;
        }
        // A short cut retracts no further than half of it, so that the way back does not cross
        // itself.
        let away = self.words.retract.min(0.5 * (to - from[0]));
        let level = from[1];
        // Cut along the level, retract at 45 degrees, go back at rapid, return to the profile.
        self.moves.push(Move::Feed([to, level]));
        self.moves.push(Move::Rapid([to - away, level + away]));
        self.moves.push(Move::Rapid([from[0] + away, level + away]));
        self.moves.push(if rapid {
            Move::Rapid(from)
        } else {
            Move::Feed(from)
        });
    }

    /// Where the path comes up to a level again after a stretch on which it falls below; at the
    /// latest at its end.
    fn end_of_level(&mut self, index: usize, after: usize, from: Vec2) -> f64 {
        let mut skip = after + 1;
        for piece in self.path.iter().skip(index) {
            let (stretches, count) = piece.stretches();
            for stretch in stretches.iter().take(count).skip(skip) {
                self.work += 1;
                // The first rise to the level ends the cut.
                if stretch.rises && stretch.to[1] >= from[1] - LEVEL_SLACK {
                    return piece.at_level(stretch, from[1].min(stretch.to[1]))[0].max(from[0]);
                }
            }
            skip = 0;
        }
        self.path
            .last()
            .map_or(from[0], |piece| piece.end[0].max(from[0]))
    }

    /// Goes over pockets: only those parts of a piece that rise above all before it are followed,
    /// and a straight feed leads to each of them, even where it has no length (as recorded).
    fn over(&mut self, piece: &Piece, stretch: &MonotonePart, bridge: &mut Option<Bridge>) {
        self.work += 1;
        let MonotonePart { from, to, rises } = *stretch;
        // The first stretch that is passed over sets the level of the way.
        let held = *bridge.get_or_insert(Bridge {
            base: from[1],
            rise: 0.0,
        });
        let slack = if piece.circle.is_some() {
            LEVEL_SLACK
        } else {
            0.0
        };
        if !rises || to[1] - held.base < held.rise - slack {
            return;
        }
        // Only what rises above everything so far is followed.
        let level = held.base + held.rise;
        let place = if from[1] >= level {
            from
        } else {
            piece.at_level(stretch, level)
        };
        self.moves.push(Move::Feed(place));
        self.along(piece, place, to, false);
        *bridge = Some(Bridge::over(piece, to));
    }
}

/// The level of the way over pockets. The highest place of an arc is kept as its radius above its
/// centre: a flat line that goes on there has the same level but for rounding, and rounding decides
/// (as recorded) whether a move of no length leads to it.
#[derive(Clone, Copy, Debug)]
struct Bridge {
    base: f64,
    rise: f64,
}

impl Bridge {
    fn over(piece: &Piece, to: Vec2) -> Bridge {
        match (piece.circle, piece.radius()) {
            (Some(circle), Some(radius))
                if (circle.center[1] + radius - to[1]).abs() < LEVEL_SLACK =>
            {
                Bridge {
                    base: circle.center[1],
                    rise: radius,
                }
            }
            _ => Bridge {
                base: to[1],
                rise: 0.0,
            },
        }
    }
}

/// The first piece is passed at rapid where it leads down to the profile.
fn is_rapid(index: usize, piece: &Piece) -> bool {
    index == 0 && piece.end[1] < piece.start[1]
}
