//! G70 to G72.2: the words of the turning cycles, and their moves as operations.

use super::{Exec, Jump};
use crate::codes::Code;
use crate::exec::words::whole_within;
use crate::ops::{ArcFeed, CanonicalOp, Plane, Position};
use crate::problem::Problem;
use crate::state::FeedMode;
use crate::turning::{self, Finishing, Frame, Move, Pockets, ProfileMove, Roughing, Trouble};

/// I and R where they are not given (LinuxCNC: 1 and 0.5, whatever the units).
const DEFAULT_DEPTH: f64 = 1.0;
const DEFAULT_RETRACT: f64 = 0.5;
/// By how much ends of arcs may miss each other and a profile turn back, mm: the rounding of
/// programs.
const ROUNDING_MM: f64 = 0.002;
/// Most passes of G70.
const MOST_PASSES: f64 = 10_000.0;

/// A turning cycle whose profile is being read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Turning {
    pub(crate) code: Code,
    /// Q: the subroutine.
    pub(crate) name: String,
    kind: Kind,
    /// Where the tool is taken to be when it begins.
    pub(crate) from: Position,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// D, E and P.
    Finish { first: f64, last: f64, passes: u32 },
    /// D, I, R, along Z or X, which pockets.
    Rough {
        distance: f64,
        depth: f64,
        retract: f64,
        along_z: bool,
        pockets: Pockets,
    },
}

/// Whether a code is a turning cycle.
pub(crate) const fn is_turning(code: Code) -> bool {
    code.letter == 'G' && matches!(code.tenths, 700 | 710..=712 | 720..=722)
}

/// G70 to G72.2: goes to X and Z at rapid and asks for the profile, the subroutine Q. The rest is
/// made when that has been read.
pub(crate) fn cycle(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    if exec.state.plane != Plane::Zx {
        return Err(Problem::TurningPlane {
            code,
            plane: exec.state.plane.name(),
        });
    }
    if exec.state.feed_mode == FeedMode::InverseTime {
        return Err(Problem::Cycle {
            message: "a turning cycle in inverse time feed (G93)",
        });
    }
    let end = exec.target()?;
    let turning = exec.turning(code, &end)?;
    let start = exec.state.current;
    // The programmed place first: the move under compensation starts from the old one.
    exec.state.current = end;
    // Recorded: also where neither X nor Z is given.
    exec.straight(&start, end, false)?;
    *exec.jump = Some(Jump::Profile(Box::new(turning)));
    Ok(())
}

impl Exec<'_> {
    fn turning(&self, code: Code, end: &Position) -> Result<Turning, Problem> {
        let value = self.need(
            b'Q',
            code,
            "Q, the number of the subroutine with the profile",
        )?;
        let number = whole_within((code, b'Q'), value, 0.0.., "the number of a subroutine")?;
        let distance = self.not_negative(code, b'D', 0.0)?;
        let kind = if code.tenths == 700 {
            Kind::Finish {
                first: distance,
                last: self.not_negative(code, b'E', 0.0)?,
                passes: self.passes_of_finishing(code)?,
            }
        } else {
            let depth = self.word(b'I').unwrap_or(DEFAULT_DEPTH);
            if depth <= 0.0 {
                return Err(Problem::WordOutOfRange {
                    code,
                    letter: 'I',
                    value: depth,
                    allowed: "greater than zero",
                });
            }
            // G71.1 cuts the first pocket only, G71.2 those after it, G71 all.
            let pockets = match code.tenths % 10 {
                1 => Pockets::First,
                2 => Pockets::Later,
                _ => Pockets::All,
            };
            Kind::Rough {
                distance,
                depth,
                retract: self.not_negative(code, b'R', DEFAULT_RETRACT)?,
                along_z: code.tenths < 720,
                pockets,
            }
        };
        // Where the profile is entered: LinuxCNC 2.9 differs under cutter compensation.
        let from = if self.strays() {
            self.place_for_profile(end)
        } else {
            *end
        };
        Ok(Turning {
            code,
            name: format!("{number}"),
            kind,
            from,
        })
    }

    fn not_negative(&self, code: Code, letter: u8, otherwise: f64) -> Result<f64, Problem> {
        let value = self.word(letter).unwrap_or(otherwise);
        let allowed = "zero or more";
        if value >= 0.0 {
            Ok(value)
        } else {
            Err(Problem::WordOutOfRange {
                code,
                letter: char::from(letter),
                value,
                allowed,
            })
        }
    }

    fn passes_of_finishing(&self, code: Code) -> Result<u32, Problem> {
        let value = self.word(b'P').unwrap_or(1.0);
        whole_within(
            (code, b'P'),
            value,
            1.0..=MOST_PASSES,
            "a whole number from 1 to 10000",
        )
        .map(|number| number as u32)
    }

    /// The moves of a cycle whose profile is known, in its frame.
    pub(crate) fn turning_moves(
        &self,
        turning: &Turning,
        profile: &[ProfileMove],
    ) -> Result<(Frame, Vec<Move>), Trouble> {
        // Tolerances are in mm, the profile in program units.
        let forgiven = ROUNDING_MM / self.state.units.mm();
        let most = self.config.limits.cycle_moves as usize;
        match turning.kind {
            Kind::Finish {
                first,
                last,
                passes,
            } => turning::finish(
                profile,
                &Finishing {
                    first,
                    last,
                    passes,
                    most,
                },
                forgiven,
            ),
            Kind::Rough {
                distance,
                depth,
                retract,
                along_z,
                pockets,
            } => turning::rough(
                profile,
                along_z,
                distance,
                &Roughing {
                    depth,
                    retract,
                    pockets,
                    most,
                },
                forgiven,
            ),
        }
    }

    /// Carries the moves out.
    pub(crate) fn make_moves(
        &mut self,
        code: Code,
        frame: &Frame,
        moves: &[Move],
    ) -> Result<(), Problem> {
        // Back from the frame of the profile to X and Z; limits and feed as for any move.
        for step in moves {
            let (place, feed) = match *step {
                Move::Rapid(place) => (place, false),
                Move::Feed(place) | Move::Arc { end: place, .. } => (place, true),
            };
            // The frame has the cutting direction as its first axis.
            let [z, x] = frame.from(place);
            let start = self.state.current;
            let mut end: Position = start;
            (end[0], end[2]) = (x, z);
            self.check_target(&end)?;
            if feed {
                self.check_feed(code)?;
            }
            self.state.current = end;
            if let Move::Arc { center, ccw, .. } = *step {
                self.turn_arc(&start, &end, frame.from(center), ccw != frame.mirrors())?;
            } else {
                self.straight(&start, end, feed)?;
            }
        }
        Ok(())
    }

    fn turn_arc(
        &mut self,
        start: &Position,
        end: &Position,
        center: [f64; 2],
        ccw: bool,
    ) -> Result<(), Problem> {
        let [x, y, z, others @ ..] = *end;
        let turns = if ccw { 1 } else { -1 };
        let arc = ArcFeed {
            plane: Plane::Zx,
            end: [z, x],
            center,
            turns,
            axis_end: y,
            others,
        };
        if self
            .state
            .compensation
            .as_ref()
            .is_some_and(|compensation| compensation.acts())
        {
            return self.compensated_arc(start, arc);
        }
        self.emit(CanonicalOp::ArcFeed(arc));
        Ok(())
    }
}
