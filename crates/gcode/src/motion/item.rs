//! Motion, one item after the other.

use crate::ops::Plane;
use lostmotion_base::Coords;
use lostmotion_base::span::BlockRef;
use serde::{Deserialize, Serialize};

/// How fast a move is to be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Feed {
    /// As fast as the machine can.
    Rapid,
    /// Speed of X Y Z along the path; of U V W if those stand still.
    MmPerMin(f64),
    /// Speed of A B C together, if no linear axis moves.
    RadPerMin(f64),
}

/// How closely the path is followed where moves meet, mm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum PathMode {
    /// G61: the exact path, a stop only where it has a corner.
    ExactPath,
    /// G61.1: a stop after every move.
    ExactStop,
    /// G64: corners may be rounded.
    Continuous {
        /// Allowed deviation; `None` if no bound was programmed.
        tolerance_mm: Option<f64>,
        /// Short moves may be merged within this; 0 is off.
        merge_mm: f64,
    },
}

/// The circle of an arc.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Circle {
    /// Plane of the circle.
    pub plane: Plane,
    /// Centre in the order of [`Plane::axes`], machine frame.
    pub center_mm: [f64; 2],
    /// Positive counter-clockwise about the plane's normal; counts turns begun.
    pub turns: i32,
}

/// A curve that is no circle: the polynomial of degree five in each of X, Y and Z with these
/// derivatives by length at its ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bend {
    /// Unit vectors along the curve at its start and its end, machine frame.
    pub tangents: [[f64; 3]; 2],
    /// Second derivatives by length there.
    pub curvatures_per_mm: [[f64; 3]; 2],
    /// Length of the curve, mm.
    pub length_mm: f64,
}

/// One move.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Where it begins, mm and rad.
    pub start: Coords,
    /// Where it ends, mm and rad. May be the same as the start.
    pub end: Coords,
    /// Its circle; `None` for a move that is straight or bends otherwise.
    pub circle: Option<Circle>,
    /// How it bends as part of a spline.
    pub bend: Option<Bend>,
    /// Its speed.
    pub feed: Feed,
    /// In inverse time (G93): how long it is to take, s. The feed says the same.
    pub duration_s: Option<f64>,
    /// Whether the operator's feed override changes it: not under M49 and M50 P0, nor in step with
    /// the spindle. A rapid move has an override of its own.
    pub feed_override: bool,
    /// How it joins the next one.
    pub path: PathMode,
    /// Offset of the tool in force, mm and rad.
    pub tool_offset: Coords,
    /// Where the program's zero lies in the machine frame (work coordinate system and G92), mm and
    /// rad.
    pub origin: Coords,
    /// Its block.
    pub block: BlockRef,
}

/// What a program makes the machine do, in order. Most items are moves, so that boxing them would
/// only cost.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum MotionItem {
    /// A move.
    Move(Motion),
    /// A pause.
    Dwell {
        /// How long, s.
        seconds: f64,
        /// Its block.
        block: BlockRef,
    },
    /// The machine stops for another tool.
    ToolChange {
        /// The tool.
        tool: i32,
        /// The block that asked for it.
        block: BlockRef,
    },
    /// The machine stops until told to go on.
    Stop {
        /// Only if the operator wants it.
        optional: bool,
        /// The block that asked for it.
        block: BlockRef,
    },
    /// The end of the program.
    End {
        /// The block that asked for it.
        block: BlockRef,
    },
}
