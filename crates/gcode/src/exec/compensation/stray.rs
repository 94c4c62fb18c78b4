//! Where LinuxCNC 2.9 takes the tool to be once it has read a profile (G70) under cutter
//! compensation: at the profile's end.
//!
//! Found from outside, by recordings of some hundred variants of one program. What its interpreter
//! remembers of the move before is the compensated place and the programmed one; reading the
//! profile overwrites the former. So until the next real move it goes to the profile's end, and the
//! corner with that move is made as if the tool stood there: the direction of the move before is
//! taken to be square to the way from the programmed place to the profile's end. The axes that the
//! cycle does not name begin at the compensated place instead of the programmed one. Later versions
//! do not do this (LinuxCNC issue 1785, pull request 3012).

use super::geometry::{CornerKind, in_plane};
use crate::dialect::Leniency;
use crate::exec::Exec;
use crate::ops::Position;
use crate::problem::Problem;
use crate::state::{Edge, Shape};
use lostmotion_base::vec::{Vec2, along, cross2, direction2, dot, left_of, sub};

const NOT_BESIDE: Problem = Problem::Compensation {
    message: "the tool does not fit between this move and the one before it: it would gouge",
};

impl Exec<'_> {
    /// Whether the tool strays as it does there.
    pub(crate) fn strays(&self) -> bool {
        self.config.leniencies.has(Leniency::FinishDetour)
            && self
                .state
                .compensation
                .as_ref()
                .is_some_and(|compensation| compensation.acts())
    }

    /// The place at which a cycle that leads to `end` begins to read its profile: the axes that it
    /// does not name are where the tool is.
    pub(crate) fn place_for_profile(&self, end: &Position) -> Position {
        let mut place = *end;
        let plane = self.state.plane;
        let Some(last) = self
            .state
            .compensation
            .as_ref()
            .and_then(|compensation| compensation.last)
        else {
            return place;
        };
        // As recorded: named axes begin at their word, the others at the compensated place.
        for (axis, value) in plane.axes().into_iter().zip(last.end) {
            if self
                .word(b"XYZ".get(axis).copied().unwrap_or_default())
                .is_none()
            {
                place[axis] = value;
            }
        }
        place
    }

    /// A profile that ends at a place has been read. True if that makes the tool stray.
    pub(crate) fn stray_to(&mut self, place: &Position) -> bool {
        let place = in_plane(self.state.plane, place);
        if !self.strays() {
            return false;
        }
        let Some(compensation) = self
            .state
            .compensation
            .as_mut()
            .filter(|compensation| compensation.last.is_some())
        else {
            return false;
        };
        compensation.strayed = Some(place);
        true
    }
}

impl Edge {
    /// The direction that the held move is taken to have had, the tool having strayed from the
    /// programmed `corner`.
    pub(super) fn astray(self, place: Vec2, corner: Vec2, left: f64) -> Edge {
        // Square to the way from the programmed corner to the profile's end, to the tool's side.
        let away = direction2(corner, place).unwrap_or([1.0, 0.0]);
        let [first, second] = left_of(away);
        Edge {
            leaves: if left > 0.0 {
                [-first, -second]
            } else {
                [first, second]
            },
            ..self
        }
    }

    /// Where the held move ends then; `corner` is where it was programmed to. None where the moves
    /// just go on. Refused, if it is a move of entry, where that is not on the tool's side of it.
    pub(super) fn end_astray(
        &self,
        place: Vec2,
        corner: Vec2,
        joint: CornerKind,
        enters: Vec2,
        left: f64,
    ) -> Result<Option<Vec2>, Problem> {
        let end = match joint {
            CornerKind::Smooth => return Ok(None),
            CornerKind::Outside => place,
            CornerKind::Inside => {
                // tan(a / 2) = sin a / (1 + cos a): what an inside corner of this angle takes off
                // the move.
                let tangent_of_half =
                    cross2(self.leaves, enters).abs() / (1.0 + dot(self.leaves, enters));
                along(place, self.leaves, -left.abs() * tangent_of_half)
            }
        };
        match self.shape {
            Shape::Line(way) if self.entry && cross2(way, sub(end, corner)) * left < 0.0 => {
                Err(NOT_BESIDE)
            }
            _ => Ok(Some(end)),
        }
    }
}
