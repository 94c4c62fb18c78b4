//! `,R` and `,C`: a corner between two straight moves rounded or chamfered.

use super::Exec;
use crate::codes::{Code, Group};
use crate::ops::{ArcFeed, CanonicalOp, Position, SourcedOp};
use crate::problem::Problem;
use crate::state::PendingCorner;
use crate::syntax::special::{CORNER_CHAMFER, CORNER_RADIUS};
use lostmotion_base::math;

/// G0 and G1.
pub(crate) const fn is_straight(code: Code) -> bool {
    code.letter == 'G' && code.tenths <= 10
}

fn failed(message: &'static str) -> Problem {
    Problem::Corner { message }
}

impl Exec<'_> {
    /// Holds a straight feed whose block has `,R` or `,C`; false if it has neither.
    pub(crate) fn hold_corner(
        &mut self,
        start: &Position,
        corner: Position,
    ) -> Result<bool, Problem> {
        let (size, rounds) = match (self.word(CORNER_RADIUS), self.word(CORNER_CHAMFER)) {
            (None, None) => return Ok(false),
            (Some(_), Some(_)) => return Err(failed("is given with both ,R and ,C")),
            (Some(radius), None) => (radius, true),
            (None, Some(length)) => (length, false),
        };
        if size <= 0.0 {
            return Err(failed("needs a size greater than zero"));
        }
        if self.state.compensation.is_some() {
            return Err(failed("cannot be made under cutter compensation"));
        }
        // After another corner the move starts where that has ended, not at the programmed vertex.
        let start = self.state.corner_exit.take().unwrap_or(*start);
        self.state.corner = Some(Box::new(PendingCorner {
            start,
            corner,
            size,
            rounds,
            block: self.block,
            named: self.named(&CanonicalOp::StraightFeed(corner)),
        }));
        Ok(true)
    }

    /// Makes the corner before the block that follows it.
    #[cold]
    pub(crate) fn turn_corner(&mut self) -> Result<(), Problem> {
        let Some(pending) = self.state.corner.take() else {
            return Ok(());
        };
        let result = self.make_corner(&pending);
        // The held move is made in any case.
        if result.is_err() {
            self.out.push(SourcedOp {
                op: CanonicalOp::StraightFeed(pending.corner),
                block: pending.block,
                named: pending.named,
            });
        }
        result
    }

    fn make_corner(&mut self, pending: &PendingCorner) -> Result<(), Problem> {
        // The corner needs the next direction, so that only a plain straight feed may follow.
        let plain = self
            .words
            .codes()
            .iter()
            .all(|used| used.row.group == Group::Motion);
        let straight = self
            .words
            .motion
            .is_some_and(|row| row.code.tenths == 10 && row.code.letter == 'G');
        if !(plain && straight) {
            return Err(failed("needs a G1 after it, without other codes"));
        }
        let end = self.target()?;
        let plane = self.state.plane;
        let [first, second, normal] = plane.axes();
        // Both moves lie in the plane: all other axes stand still.
        let flat = |a: &Position, b: &Position| {
            (0..9).all(|axis| axis == first || axis == second || a[axis] == b[axis])
        };
        if !flat(&pending.start, &pending.corner) || !flat(&pending.corner, &end) {
            return Err(failed("can only be made between moves in the plane"));
        }
        let way = |to: &Position| {
            [
                to[first] - pending.corner[first],
                to[second] - pending.corner[second],
            ]
        };
        // Vectors from the corner back along the held move, and on along the next one.
        let (back, on) = (way(&pending.start), way(&end));
        let lengths = [math::hypot(back[0], back[1]), math::hypot(on[0], on[1])];
        // Interior angle at the vertex; straight on or straight back there is no corner to round.
        let sine = back[0] * on[1] - back[1] * on[0];
        let angle = math::atan2(sine.abs(), back[0] * on[0] + back[1] * on[1]);
        if !(angle > 1e-9 && angle < std::f64::consts::PI - 1e-9) {
            return Err(failed("needs two directions"));
        }
        // Length that the corner takes off both moves.
        let cut = if pending.rounds {
            pending.size / math::tan(0.5 * angle)
        } else {
            pending.size
        };
        if cut > lengths[0] || cut > lengths[1] {
            return Err(failed("is larger than its moves are long"));
        }
        let along = |way: [f64; 2], length: f64| {
            let mut place = pending.corner;
            place[first] += way[0] * cut / length;
            place[second] += way[1] * cut / length;
            place
        };
        // Where the held move ends and the next one begins.
        let (from, to) = (along(back, lengths[0]), along(on, lengths[1]));
        self.out.push(SourcedOp {
            op: CanonicalOp::StraightFeed(from),
            block: pending.block,
            named: pending.named,
        });
        let op = if pending.rounds {
            // From the vertex through the middle of the chord: the bisector.
            let middle = [
                0.5 * (from[first] + to[first]),
                0.5 * (from[second] + to[second]),
            ];
            let out = [
                middle[0] - pending.corner[first],
                middle[1] - pending.corner[second],
            ];
            // The centre lies on the bisector, at the radius over the sine of half the angle.
            let scale = (pending.size / math::sin(0.5 * angle)) / (cut * math::cos(0.5 * angle));
            let center = [
                pending.corner[first] + out[0] * scale,
                pending.corner[second] + out[1] * scale,
            ];
            let [_, _, _, others @ ..] = to;
            // The arc turns the way that the path turns at the vertex.
            let turns = if sine < 0.0 { 1 } else { -1 };
            CanonicalOp::ArcFeed(ArcFeed {
                plane,
                end: [to[first], to[second]],
                center,
                turns,
                axis_end: to[normal],
                others,
            })
        } else {
            CanonicalOp::StraightFeed(to)
        };
        self.out.push(SourcedOp {
            op,
            block: pending.block,
            named: 0,
        });
        self.state.corner_exit = Some(to);
        Ok(())
    }
}
