//! What operations are made of.

use lostmotion_base::Plane;
use lostmotion_base::units::MM_PER_INCH;
use serde::{Deserialize, Serialize};

/// Coordinates of X Y Z A B C U V W in program units and degrees.
pub type Position = [f64; 9];

/// Length units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Units {
    /// G21.
    #[default]
    Mm,
    /// G20.
    Inch,
}

impl Units {
    /// Millimetres per unit.
    pub const fn mm(self) -> f64 {
        match self {
            Units::Mm => 1.0,
            Units::Inch => MM_PER_INCH,
        }
    }

    /// Short name.
    pub const fn name(self) -> &'static str {
        match self {
            Units::Mm => "mm",
            Units::Inch => "in",
        }
    }

    /// A length in other units, unchanged if the units are the same.
    pub fn convert(self, length: f64, to: Units) -> f64 {
        match (self, to) {
            (Units::Mm, Units::Inch) => length / MM_PER_INCH,
            (Units::Inch, Units::Mm) => length * MM_PER_INCH,
            _ => length,
        }
    }
}

/// Which way a spindle turns to an angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OrientWay {
    /// The shorter one.
    Shortest,
    /// Clockwise.
    Clockwise,
    /// Counter-clockwise.
    CounterClockwise,
}

impl OrientWay {
    /// P of M19.
    pub const fn number(self) -> u8 {
        match self {
            OrientWay::Shortest => 0,
            OrientWay::Clockwise => 1,
            OrientWay::CounterClockwise => 2,
        }
    }
}

/// How closely the path is followed at corners.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum PathControl {
    /// G61: the programmed path, stopping only where it has a corner.
    ExactPath,
    /// G61.1: a stop at the end of every move.
    ExactStop,
    /// G64: corners may be rounded.
    Continuous {
        /// Allowed deviation in program units; 0 means no bound was given.
        tolerance: f64,
    },
}

/// An arc, helix or spiral about an axis of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArcFeed {
    /// Plane of the circle; its axes give the order of the pairs below.
    pub plane: Plane,
    /// End in the plane's first and second axis.
    pub end: [f64; 2],
    /// Centre in the plane's first and second axis.
    pub center: [f64; 2],
    /// Positive counter-clockwise about the plane's normal; the number counts turns begun.
    pub turns: i32,
    /// End along the plane's normal.
    pub axis_end: f64,
    /// Ends of A B C U V W.
    pub others: [f64; 6],
}

impl ArcFeed {
    /// Where the arc ends.
    pub fn position(&self) -> Position {
        let mut end = [0.0; 9];
        let [first, second, normal] = self.plane.axes();
        end[first] = self.end[0];
        end[second] = self.end[1];
        end[normal] = self.axis_end;
        end[3..].copy_from_slice(&self.others);
        end
    }
}

/// A control point of a curve, in the plane's first and second axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControlPoint {
    /// Where it is.
    pub at: [f64; 2],
    /// How strongly it draws the curve.
    pub weight: f64,
}

/// A rational B-spline from the first to the last control point, on the clamped uniform knot
/// vector.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NurbsFeed {
    /// Plane of the curve.
    pub plane: Plane,
    /// Degree plus one.
    pub order: u32,
    /// At least as many as the order. The first is where the move begins.
    pub points: Vec<ControlPoint>,
    /// Where it ends.
    pub end: Position,
}

/// Motion at the feed rate until the probe's signal changes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StraightProbe {
    /// Where it ends if the signal does not change.
    pub end: Position,
    /// Where the machine is taken to have stopped.
    pub stop: Position,
    /// Away from contact (G38.4, G38.5); otherwise towards it.
    pub away: bool,
    /// Whether it is an error if the signal does not change (G38.2, G38.4).
    pub must: bool,
}

/// An output of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum OutputValue {
    /// On or off.
    Digital(bool),
    /// A number.
    Analog(f64),
}

/// What M66 waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum WaitFor {
    /// Nothing: the input is read at once.
    Now,
    /// The input goes on.
    Rise,
    /// The input goes off.
    Fall,
    /// The input is on.
    High,
    /// The input is off.
    Low,
}

/// What becomes of a text in a comment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TextKind {
    /// A plain comment.
    Comment,
    /// `(MSG,...)` and `(DEBUG,...)`: to be shown to the operator.
    Message,
    /// `(PRINT,...)`.
    Print,
    /// `(LOG,...)`.
    Log,
}
