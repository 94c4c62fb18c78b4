//! The profile of a turning cycle: a subroutine that is run for its moves alone.

use super::Interpreter;
use crate::codes::{AxisUse, Code, Group, whole};
use crate::diagnostics::Diagnostic;
use crate::dialect::Leniency;
use crate::exec::turning::{Turning, is_turning};
use crate::exec::words::{AXIS_BITS, Placed};
use crate::ops::{Position, SourcedOp};
use crate::problem::Problem;
use crate::state::State;
use crate::turning::{Corner, Piece, ProfileMove, Trouble};
use lostmotion_base::span::BlockRef;

const FEED: Code = Code::g(10);

/// A profile that is being read.
#[derive(Debug)]
pub(crate) struct Collecting {
    turning: Turning,
    /// The cycle's block.
    block: BlockRef,
    /// Calls open inside the subroutine; with fewer it is over.
    depth: usize,
    /// The modes where the cycle was called.
    state: Box<State>,
    moves: Vec<ProfileMove>,
    /// Where each move stands.
    places: Vec<BlockRef>,
    /// Something is wrong with it, and has been told.
    failed: bool,
}

const fn unplaced(problem: Problem) -> Placed {
    (problem, None)
}

impl Interpreter {
    /// The subroutine of a turning cycle on the line, if it is not known yet.
    pub(crate) fn wanted_profile(&self) -> Option<String> {
        // Looked for before the cycle runs, so that its block runs once.
        let is_cycle = self
            .words
            .codes()
            .iter()
            .any(|used| is_turning(used.row.code));
        let number = if is_cycle {
            self.words.get(b'Q').and_then(whole)
        } else {
            None
        };
        number
            .map(|number| format!("{number}"))
            .filter(|name| !self.flow.subs.contains_key(name))
    }

    /// Begins to read the profile of a cycle.
    pub(crate) fn begin_profile(&mut self, turning: Turning) -> Result<(), Problem> {
        let block = BlockRef {
            span: self.span,
            call_stack: self.stack_index,
        };
        // The profile runs as a subroutine call; its blocks are collected instead of carried out.
        self.call(turning.name.clone(), Some(&[]), 1)?;
        // Kept: place, distance mode and diameter mode where the cycle was called.
        let state = Box::new(self.state.clone());
        (self.state.current[2], self.state.current[0]) = (turning.from[2], turning.from[0]);
        let depth = self.flow.frames.len();
        self.profile = Some(Box::new(Collecting {
            turning,
            block,
            depth,
            state,
            moves: Vec::new(),
            places: Vec::new(),
            failed: false,
        }));
        Ok(())
    }

    /// A block of a profile was refused.
    pub(crate) fn spoil_profile(&mut self) {
        if let Some(profile) = &mut self.profile {
            profile.failed = true;
        }
    }

    /// A line inside a profile: only G0 to G3 count, as moves; parameters are set, everything else
    /// is passed over.
    pub(crate) fn profile_line(&mut self) -> Result<(), Placed> {
        // The motion mode as G0 to G3 set it; other motion is an error, other codes are passed over.
        let mut motion = self.state.motion.filter(|code| code.tenths <= 30);
        for used in self.words.codes() {
            let code = used.row.code;
            match used.row.group {
                Group::Motion if code.tenths <= 30 => motion = Some(code),
                Group::Motion if used.row.axes == AxisUse::None => motion = None,
                Group::Motion => return Err((Problem::ProfileCode { code }, Some(used.text))),
                _ if used.row.axes != AxisUse::None && self.words.mask & AXIS_BITS != 0 => {
                    return Err((Problem::ProfileCode { code }, Some(used.text)));
                }
                _ if code
                    == (Code {
                        letter: 'M',
                        tenths: 980,
                    }) =>
                {
                    return Err((Problem::ProfileCode { code }, Some(used.text)));
                }
                _ if code
                    == (Code {
                        letter: 'M',
                        tenths: 990,
                    }) =>
                {
                    self.leave();
                    return Ok(());
                }
                _ => {}
            }
        }
        self.state.motion = motion;
        // Centre words alone make a move only in the arc modes: a full circle.
        let is_arc = motion.is_some_and(|code| matches!(code.tenths, 20 | 30));
        let moves = *b"XZUW";
        let centers = *b"IKR";
        if moves.iter().any(|&letter| self.words.has(letter))
            || (is_arc && centers.iter().any(|&letter| self.words.has(letter)))
        {
            self.profile_move(motion.filter(|_| is_arc))?;
        }
        Ok(())
    }

    fn profile_move(&mut self, arc: Option<Code>) -> Result<(), Placed> {
        let to = self.profile_target()?;
        let [x, _, z, ..] = self.state.current;
        let (from, to) = ([z, x], to);
        let mut ignored = Vec::new();
        let mut exec = self.exec(&mut ignored);
        let start = exec.state.current;
        let mut end = start;
        (end[2], end[0]) = (to[0], to[1]);
        exec.check_target(&end).map_err(unplaced)?;
        // Geometry in the plane of Z and X, checked like any other move.
        let piece = match arc {
            None => Piece::line(from, to),
            Some(code) => {
                let clockwise = code.tenths == 20;
                Piece::arc(
                    from,
                    to,
                    exec.center(&start, &end, clockwise).map_err(unplaced)?,
                    !clockwise,
                )
            }
        };
        exec.state.current = end;
        // A corner word rounds or chamfers the end of this move.
        let corner = self.profile_corner()?;
        let limit = self.config.limits.cycle_moves;
        let place = BlockRef {
            span: self.span,
            call_stack: self.stack_index,
        };
        let Some(profile) = &mut self.profile else {
            return Ok(());
        };
        // Recorded: a first move that leads nowhere does not count.
        if arc.is_none() && from == to {
            return Ok(());
        }
        if profile.moves.len() >= limit as usize {
            return Err(unplaced(Problem::CycleTooLong { limit }));
        }
        // The first move leads to the profile; an arc needs one of no length before it.
        if profile.moves.is_empty() && arc.is_some() {
            profile.moves.push(ProfileMove {
                piece: Piece::line(from, from),
                corner: None,
            });
            profile.places.push(place);
        }
        profile.moves.push(ProfileMove { piece, corner });
        profile.places.push(place);
        Ok(())
    }

    /// Where X, Z, U and W lead; U and W are increments of X and Z.
    fn profile_target(&mut self) -> Result<[f64; 2], Placed> {
        let absolute = self
            .profile
            .as_ref()
            .is_none_or(|profile| profile.state.absolute);
        // In G7 X and U are diameters.
        let scale = if self.state.diameter { 0.5 } else { 1.0 };
        let [x, _, z, ..] = self.state.current;
        let mut target = [z, x];
        // X and Z follow the distance mode that was in force at the cycle.
        for (letter, index, scale) in [(b'X', 1, scale), (b'Z', 0, 1.0)] {
            if let Some(value) = self.words.get(letter) {
                target[index] = if absolute {
                    scale * value
                } else {
                    target[index] + scale * value
                };
            }
        }
        for (letter, index, scale) in [(b'U', 1, scale), (b'W', 0, 1.0)] {
            if let Some(value) = self.words.get(letter) {
                if !absolute {
                    return Err((
                        Problem::ProfileIncrement {
                            letter: char::from(letter),
                        },
                        Some(self.words.text(letter)),
                    ));
                }
                target[index] += scale * value;
            }
        }
        Ok(target)
    }

    /// A or C.
    fn profile_corner(&self) -> Result<Option<Corner>, Placed> {
        // One corner word a move: a fillet and a chamfer exclude each other.
        let corner = match (self.words.get(b'A'), self.words.get(b'C')) {
            (Some(_), Some(value)) => {
                return Err((
                    Problem::ProfileCorner {
                        letter: 'C',
                        size: value,
                        two: true,
                    },
                    Some(self.words.text(b'C')),
                ));
            }
            (Some(radius), None) => Corner::Fillet(radius),
            (None, Some(length)) => Corner::Chamfer(length),
            (None, None) => return Ok(None),
        };
        let (letter, size) = (corner.letter(), corner.size());
        if size < 0.0 {
            return Err((
                Problem::ProfileCorner {
                    letter,
                    size,
                    two: false,
                },
                Some(self.words.text(letter as u8)),
            ));
        }
        Ok(Some(corner).filter(|_| size > 0.0))
    }

    /// Makes the moves of a cycle whose profile has been read.
    pub(crate) fn end_profile(&mut self, out: &mut Vec<SourcedOp>) {
        let depth = self.flow.frames.len();
        let Some(profile) = self.profile.take_if(|profile| depth < profile.depth) else {
            return;
        };
        // After the cycle the motion mode is G1.
        self.state.motion = Some(FEED);
        self.words.clear();
        if profile.failed {
            return;
        }
        // Back to where the cycle was called; the moves start there.
        let read_to = self.state.current;
        (self.state.current, self.state.diameter) = (profile.state.current, profile.state.diameter);
        let mut exec = self.exec(out);
        exec.block = profile.block;
        // LinuxCNC 2.9 goes to the profile's end first, under cutter compensation.
        let strays = exec.stray_to(&read_to);
        let code = profile.turning.code;
        let problem = match exec.turning_moves(&profile.turning, &profile.moves) {
            Ok((frame, moves)) => exec
                .make_moves(code, &frame, &moves)
                .err()
                .map(|problem| (problem, profile.block)),
            Err(trouble) => Some(self.profile_problem(&profile, trouble)),
        };
        if strays {
            self.tell_detour(&profile, &read_to);
        }
        if let Some((problem, place)) = problem {
            // What follows is judged from where the profile was to end.
            if let Some(last) = profile.moves.last() {
                (self.state.current[2], self.state.current[0]) =
                    (last.piece.end[0], last.piece.end[1]);
            }
            self.diagnostics.push(Diagnostic { problem, place });
        }
    }

    /// Says once that the tool strays to the end of a profile.
    fn tell_detour(&mut self, profile: &Collecting, to: &Position) {
        if !self.told.has(Leniency::FinishDetour) {
            self.told = self.told.with(Leniency::FinishDetour);
            let x = if self.state.diameter {
                2.0 * to[0]
            } else {
                to[0]
            };
            let problem = Problem::FinishDetour {
                code: profile.turning.code,
                x,
                z: to[2],
            };
            self.diagnostics.push(Diagnostic {
                problem,
                place: profile.block,
            });
        }
    }

    fn profile_problem(&self, profile: &Collecting, trouble: Trouble) -> (Problem, BlockRef) {
        let code = profile.turning.code;
        let of = |index: usize| {
            (
                profile.moves.get(index),
                profile.places.get(index).copied().unwrap_or(profile.block),
            )
        };
        match trouble {
            Trouble::Empty => (
                Problem::ProfileEmpty {
                    code,
                    name: profile.turning.name.clone(),
                },
                profile.block,
            ),
            Trouble::TooLong => (
                Problem::CycleTooLong {
                    limit: self.config.limits.cycle_moves,
                },
                profile.block,
            ),
            Trouble::Distance { distance } => {
                (Problem::ProfileDistance { code, distance }, profile.block)
            }
            Trouble::Corner { index } => {
                let (found, place) = of(index);
                let corner = found
                    .and_then(|found| found.corner)
                    .unwrap_or(Corner::Fillet(0.0));
                (
                    Problem::ProfileCorner {
                        letter: corner.letter(),
                        size: corner.size(),
                        two: false,
                    },
                    place,
                )
            }
            Trouble::TurnsBack { index, along_z } => {
                let (found, place) = of(index);
                let [from, to] = found.map_or([0.0; 2], |found| {
                    // Moves are stored as Z and X.
                    let axis = usize::from(!along_z);
                    [found.piece.start[axis], found.piece.end[axis]]
                });
                (
                    Problem::ProfileTurnsBack {
                        code,
                        axis: if along_z { 'Z' } else { 'X' },
                        from,
                        to,
                    },
                    place,
                )
            }
        }
    }
}
