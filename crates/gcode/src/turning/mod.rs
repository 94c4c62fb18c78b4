//! The turning cycles G70 to G72.2: a profile is finished, or roughed by cuts along it (G71) or
//! across it (G72).
//!
//! What the words mean is LinuxCNC's documentation. What it leaves open (the order of the moves,
//! which of them are at rapid, how a level retracts, which moves of no length there are) follows
//! recordings of its stand-alone interpreter, and the comments name what was recorded. No source of
//! another interpreter was looked at.
//!
//! All geometry is in the plane of [`piece::Frame`]: the profile goes from left to right, the
//! material lies above it.

use lostmotion_base::vec::{Vec2, cross2, distance2, sub};

mod envelope;
mod offset;
mod piece;
mod rough;

pub(crate) use offset::Corner;
pub(crate) use piece::Frame;
pub(crate) use piece::{Piece, PieceCircle};
pub(crate) use rough::{Move, Pockets, Roughing};

/// One move of a profile, Z and X.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ProfileMove {
    pub(crate) piece: Piece,
    /// A or C.
    pub(crate) corner: Option<Corner>,
}

/// What does not work with a profile. Moves are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Trouble {
    /// It has no move after the one that leads to its start.
    Empty,
    /// A move goes back.
    TurnsBack { index: usize, along_z: bool },
    /// A corner is larger than its moves.
    Corner { index: usize },
    /// The distance does not fit.
    Distance { distance: f64 },
    /// Too many moves come out.
    TooLong,
}

/// The words of G70: distances of the first and last pass, and how many.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Finishing {
    pub(crate) first: f64,
    pub(crate) last: f64,
    pub(crate) passes: u32,
    pub(crate) most: usize,
}

/// A profile in its frame, and where the cycle begins.
struct Laid {
    /// Where the tool goes first: the start, or level with the profile's if that lies behind it.
    from: Vec2,
    /// The move that leads to the profile, and the profile.
    pieces: Vec<Piece>,
}

/// The moves of G71 (along Z) or G72 (along X). `forgiven` is the rounding of a program, in its
/// units.
pub(crate) fn rough(
    profile: &[ProfileMove],
    along_z: bool,
    distance: f64,
    words: &Roughing,
    forgiven: f64,
) -> Result<(Frame, Vec<Move>), Trouble> {
    // Turn the profile so that it goes right and up; offset it by the stock; lead to it from the start.
    let frame = monotone(profile, Frame::of(along_z, ends(profile)?), forgiven)?;
    let laid = lay(profile, frame)?;
    let moved = laid.moved(distance, forgiven)?;
    let (Some(begin), Some(end)) = (
        moved.first().map(|piece| piece.start),
        moved.last().map(|piece| piece.end),
    ) else {
        return Err(Trouble::Empty);
    };
    let mut path = vec![Piece::line(laid.from, begin)];
    path.extend(moved);
    // Back up to the level where the tool came from, so that the last pocket has an end.
    if laid.from[1] > end[1] {
        path.push(Piece::line(end, [end[0], laid.from[1]]));
    }
    let mut moves = vec![Move::Rapid(laid.from)];
    moves.extend(rough::rough(&path, words).ok_or(Trouble::TooLong)?);
    Ok((frame, moves))
}

/// The moves of G70.
pub(crate) fn finish(
    profile: &[ProfileMove],
    words: &Finishing,
    forgiven: f64,
) -> Result<(Frame, Vec<Move>), Trouble> {
    let frame = frame_of_finish(profile, forgiven)?;
    let laid = lay(profile, frame)?;
    let mut moves = vec![Move::Rapid(laid.from)];
    // The offset shrinks evenly from the first pass to the last.
    for pass in (0..words.passes).rev() {
        let distance =
            f64::from(pass) * (words.first - words.last) / f64::from(words.passes) + words.last;
        let pieces = laid.moved(distance, forgiven)?;
        if pass + 1 < words.passes {
            moves.push(Move::Rapid(laid.from));
        }
        moves.extend(pieces.first().map(|piece| Move::Rapid(piece.start)));
        moves.extend(pieces.iter().map(|piece| match piece.circle {
            Some(PieceCircle { center, ccw }) => Move::Arc {
                end: piece.end,
                center,
                ccw,
            },
            None => Move::Feed(piece.end),
        }));
        if moves.len() > words.most {
            return Err(Trouble::TooLong);
        }
    }
    Ok((frame, moves))
}

/// Start and end of the profile.
fn ends(profile: &[ProfileMove]) -> Result<[Vec2; 2], Trouble> {
    match profile {
        [entry, .., last] => Ok([entry.piece.end, last.piece.end]),
        _ => Err(Trouble::Empty),
    }
}

/// The frame of G70. Recorded: it goes along Z, and towards larger Z only if the profile does so
/// after its first move; along X where it would turn back in that.
fn frame_of_finish(profile: &[ProfileMove], forgiven: f64) -> Result<Frame, Trouble> {
    let ends = ends(profile)?;
    let along_z = Frame::of(true, ends);
    // The direction along Z as recorded, then along X; if neither is monotone, the fault along Z
    // is told.
    let mut recorded = along_z;
    if let Some(first) = profile.get(1) {
        recorded.signs[0] = Frame::of(true, [first.piece.end, ends[1]]).signs[0];
    }
    let tried = [recorded, Frame::of(false, ends)]
        .into_iter()
        .find_map(|frame| monotone(profile, frame, forgiven).ok());
    tried.map_or_else(|| monotone(profile, along_z, forgiven), Ok)
}

/// A frame, if the profile never turns back in it.
fn monotone(profile: &[ProfileMove], frame: Frame, forgiven: f64) -> Result<Frame, Trouble> {
    let back = |entry: &ProfileMove| !frame.piece(&entry.piece).advances(forgiven);
    match profile.iter().skip(1).position(back) {
        Some(index) => Err(Trouble::TurnsBack {
            index: index + 1,
            along_z: frame.along_z,
        }),
        None => Ok(frame),
    }
}

fn lay(profile: &[ProfileMove], frame: Frame) -> Result<Laid, Trouble> {
    let mut pieces: Vec<Piece> = Vec::with_capacity(profile.len());
    let mut open: Option<(usize, Corner)> = None;
    for (index, entry) in profile.iter().enumerate() {
        let mut piece = frame.piece(&entry.piece);
        if index == 0 {
            // A tool that stands behind the profile's start first goes level with it.
            piece.start[0] = piece.start[0].min(piece.end[0]);
        }
        // A corner belongs to the end of its move and is made when the next one is known.
        if let (Some((at, corner)), Some(before)) = (open.take(), pieces.last_mut()) {
            let made =
                offset::corner(before, &mut piece, corner).ok_or(Trouble::Corner { index: at })?;
            pieces.extend(made);
        }
        pieces.push(piece);
        open = entry.corner.map(|corner| (index, corner));
    }
    let from = pieces
        .first()
        .map(|piece| piece.start)
        .ok_or(Trouble::Empty)?;
    // What a corner has taken whole is left out.
    let mut kept = 0;
    pieces.retain(|piece| {
        kept += 1;
        kept == 1 || distance2(piece.start, piece.end) > 0.0
    });
    Ok(Laid { from, pieces })
}

impl Laid {
    /// The profile at a distance, towards where the tool is. Recorded: that is told by the line
    /// from the profile's start to where its last move begins; a profile of one move is always
    /// offset upwards.
    fn moved(&self, distance: f64, forgiven: f64) -> Result<Vec<Piece>, Trouble> {
        let profile = self.pieces.get(1..).unwrap_or_default();
        let below = profile
            .first()
            .zip(profile.last())
            .is_some_and(|(first, last)| {
                let side = cross2(sub(last.start, first.start), sub(self.from, first.start));
                side < -1e-9
            });
        let moved = if !below {
            offset::offset(profile, distance, forgiven)
        } else {
            // An offset downwards is that of the mirrored profile upwards.
            let mirrored: Vec<Piece> = profile.iter().map(Piece::mirrored).collect();
            let moved = offset::offset(&mirrored, distance, forgiven);
            moved.map(|pieces| pieces.iter().map(Piece::mirrored).collect())
        };
        moved.ok_or(Trouble::Distance { distance })
    }
}
