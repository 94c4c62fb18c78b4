//! What waits for the blocks that follow: a move under cutter compensation, a corner, a NURBS.

use super::State;
use crate::ops::{ControlPoint, Position, SourcedOp};
use lostmotion_base::span::BlockRef;
use lostmotion_base::vec::Vec2;
use serde::{Deserialize, Serialize};

/// Cutter compensation in force. Lengths in program units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compensation {
    /// Distance to the left of the path; negative is to the right.
    pub(crate) left: f64,
    /// Orientation of a lathe tool's nose, 0 to 9.
    pub(crate) orientation: u8,
    /// The last offset move and where it ends; `None` before the first.
    pub(crate) last: Option<Edge>,
    /// The last move has gone out: its end is fixed.
    pub(crate) fixed: bool,
    /// Operations that wait for the end of the last move; the first is that move.
    pub(crate) held: Vec<HeldOp>,
    /// Where a profile that has been read since ends, and the tool is taken to be.
    pub(crate) strayed: Option<Vec2>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct HeldOp {
    pub(crate) sourced: SourcedOp,
    /// Its end in the plane is that of the held move.
    pub(crate) follows: bool,
}

impl Compensation {
    /// What `#<_ccomp>` shows.
    pub(crate) fn code(&self) -> f64 {
        if self.left > 0.0 { 410.0 } else { 420.0 }
    }

    /// Whether it moves the path at all.
    pub(crate) fn acts(&self) -> bool {
        self.left != 0.0
    }
}

/// What an offset move follows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Shape {
    /// A line in a direction.
    Line(Vec2),
    /// A circle.
    Arc {
        center: Vec2,
        radius: f64,
        counter_clockwise: bool,
    },
}

/// An offset move.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Edge {
    pub(crate) shape: Shape,
    /// Where it begins.
    pub(crate) start: Vec2,
    /// Where it ends, as far as is known.
    pub(crate) end: Vec2,
    /// It leads from the path to its offset.
    pub(crate) entry: bool,
    /// It leads from where the tool was taken to be, not from the path: only a corner at its end
    /// tells whether it fits.
    pub(crate) astray: bool,
    /// The programmed direction at its end.
    pub(crate) leaves: Vec2,
}

/// A move whose end waits for the direction of the next one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PendingCorner {
    pub(crate) start: Position,
    pub(crate) corner: Position,
    pub(crate) size: f64,
    pub(crate) rounds: bool,
    pub(crate) block: BlockRef,
}

/// A NURBS block that has begun.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NurbsDraft {
    pub(crate) order: u32,
    pub(crate) points: Vec<ControlPoint>,
}

/// Modes that a level of calls has saved.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Saved {
    pub(crate) modes: Option<Box<State>>,
    /// Brought back when the level is left (M73).
    pub(crate) automatic: bool,
}
