//! G0, G1 and G53.

use super::Exec;
use crate::code::Code;
use crate::codes::row::bit;
use crate::ops::{CanonicalOp, Position};
use crate::problem::Problem;
use crate::state::{FeedMode, TipControl};
use crate::syntax::special::{CORNER_CHAMFER, CORNER_RADIUS};

/// Slowest feed that inverse time results in, units per minute (LinuxCNC).
const LEAST_RATE: f64 = 0.1;

/// Bits of `,R` and `,C`.
pub(crate) const CORNERS: u32 = bit(CORNER_RADIUS) | bit(CORNER_CHAMFER);

/// G0.
pub(crate) fn traverse(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.motion = Some(code);
    let end = exec.target()?;
    let start = exec.state.current;
    exec.state.current = end;
    exec.straight(&start, end, false)
}

/// G1.
pub(crate) fn feed(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.motion = Some(code);
    let end = exec.target()?;
    let start = exec.state.current;
    exec.state.current = end;
    exec.check_feed(code)?;
    exec.inverse_time(|| straight_length(&start, &end));
    if exec.words.mask & CORNERS != 0 && exec.hold_corner(&start, end)? {
        return Ok(());
    }
    exec.straight(&start, end, true)
}

/// G53: the motion itself asks for it; alone it means nothing.
pub(crate) fn machine_coordinates(exec: &mut Exec<'_>, _: Code) -> Result<(), Problem> {
    match exec.words.motion {
        Some(row) if row.code.tenths <= 10 => {}
        _ => return Err(Problem::G53WithoutMotion),
    }
    if exec.state.absolute {
        Ok(())
    } else {
        Err(Problem::G53Incremental)
    }
}

/// What the feed rate is measured along: X Y Z, or U V W if those stand still, or degrees of A B C.
pub(crate) fn straight_length(start: &Position, end: &Position) -> f64 {
    let norm = |from: usize| {
        (from..from + 3)
            .map(|i| (end[i] - start[i]) * (end[i] - start[i]))
            .sum::<f64>()
            .sqrt()
    };
    [0, 6, 3]
        .into_iter()
        .map(norm)
        .find(|length| *length > 0.0)
        .unwrap_or(0.0)
}

/// Bits of the tool's direction (G43.5).
const VECTOR: u32 = bit(b'I') | bit(b'J') | bit(b'K');

impl Exec<'_> {
    /// Where the axis words lead to.
    pub(crate) fn target(&self) -> Result<Position, Problem> {
        let in_machine = self.words.has_g(530);
        let mut end = if in_machine {
            self.state.machine()
        } else {
            self.state.current
        };
        let absolute = in_machine || self.state.absolute;
        for (axis, coordinate) in end.iter_mut().enumerate() {
            if let Some(value) = self.axis_word(axis) {
                *coordinate = if absolute { value } else { *coordinate + value };
            }
        }
        self.polar(&mut end)?;
        if in_machine {
            end = self.state.offsets.to_program(&end);
        }
        self.check_target(&end)?;
        Ok(end)
    }

    /// A straight move, compensated for the cutter if that is on.
    pub(crate) fn straight(
        &mut self,
        start: &Position,
        end: Position,
        feed: bool,
    ) -> Result<(), Problem> {
        self.state.arc_not_allowed = false;
        if self.words.mask & VECTOR != 0 && self.state.tip_control == TipControl::WithVector {
            self.tool_vector()?;
        }
        if self
            .state
            .compensation
            .as_ref()
            .is_some_and(|compensation| compensation.acts())
        {
            return self.compensated_line(start, end, feed);
        }
        self.emit(if feed {
            CanonicalOp::StraightFeed(end)
        } else {
            CanonicalOp::StraightTraverse(end)
        });
        Ok(())
    }

    /// Refuses motion at a feed that is not known.
    pub(crate) fn check_feed(&mut self, code: Code) -> Result<(), Problem> {
        match self.state.feed_mode {
            FeedMode::InverseTime => match self.word(b'F') {
                Some(f) if f > 0.0 => Ok(()),
                _ => Err(Problem::NoInverseTimeFeed { code }),
            },
            FeedMode::PerRevolution
                if self.state.spindle.speed == 0.0 && !self.state.feed_missed =>
            {
                self.state.feed_missed = true;
                match code.tenths {
                    10 => Err(Problem::NoRevolutions { code: "G1" }),
                    20 => Err(Problem::NoRevolutions { code: "G2" }),
                    30 => Err(Problem::NoRevolutions { code: "G3" }),
                    _ => Ok(()),
                }
            }
            _ if self.state.feed > 0.0 || self.state.feed_missed => Ok(()),
            _ => {
                // Said once: the following moves lack the same F.
                self.state.feed_missed = true;
                Err(Problem::NoFeed { code })
            }
        }
    }

    /// In inverse time, the rate that does a length in 1/F minutes. Under cutter compensation, and
    /// on the move that leaves it, the path has another length than what was programmed; it is the
    /// rate that then holds (as recorded), also for the arcs at corners.
    pub(crate) fn inverse_time(&mut self, length: impl FnOnce() -> f64) {
        if self.state.feed_mode == FeedMode::InverseTime {
            let per_minute = self.word(b'F').unwrap_or_default();
            let acts = self
                .state
                .compensation
                .as_ref()
                .is_some_and(|compensation| compensation.acts());
            let differs = acts || self.state.arc_not_allowed;
            self.set_feed(
                (length() * per_minute).max(LEAST_RATE),
                Some(per_minute).filter(|_| !differs),
            );
        }
    }
}
