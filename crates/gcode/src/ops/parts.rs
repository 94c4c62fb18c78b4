//! What canonical operations are made of: positions, units, arcs, curves, turned coordinates.

use lostmotion_base::units::{MM_PER_INCH, rad};
use lostmotion_base::{Plane, math};
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

/// A rotation of X Y Z and a shift: place = origin + rows * program. Lengths in program units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tilt {
    /// Where the turned coordinates' zero lies.
    pub origin: [f64; 3],
    /// Rotation matrix by rows.
    pub rows: [[f64; 3]; 3],
}

/// Entries of a rotation smaller than this are rounding.
const ROTATION_ROUNDING: f64 = 1e-15;

impl Tilt {
    /// G68: about a point of the XY plane, counter-clockwise, degrees.
    pub fn in_plane(center: [f64; 2], degrees: f64) -> Tilt {
        let rows = about_z(degrees);
        // Shifted so that the centre stays where it is.
        let turned = turn(&rows, [center[0], center[1], 0.0]);
        Tilt {
            origin: [center[0] - turned[0], center[1] - turned[1], 0.0],
            rows,
        }
    }

    /// G68.2: the Euler angles I about Z, J about the new X, K about the new Z, degrees.
    pub fn in_space(origin: [f64; 3], euler_deg: [f64; 3]) -> Tilt {
        let [i, j, k] = euler_deg;
        Tilt {
            origin,
            rows: times(&times(&about_z(i), &about_x(j)), &about_z(k)),
        }
    }

    /// Turned coordinates to those of the workpiece.
    pub fn apply(&self, position: &mut Position) {
        let place = turn(&self.rows, [position[0], position[1], position[2]]);
        for axis in 0..3 {
            position[axis] = place[axis] + self.origin[axis];
        }
    }

    /// Coordinates of the workpiece to turned ones.
    pub fn undo(&self, position: &mut Position) {
        // The inverse of a rotation is its transpose.
        let away: [f64; 3] = std::array::from_fn(|axis| position[axis] - self.origin[axis]);
        for (axis, coordinate) in position.iter_mut().take(3).enumerate() {
            *coordinate = (0..3).map(|row| self.rows[row][axis] * away[row]).sum();
        }
    }

    /// Whether the XY plane stays what it is, so that its arcs stay arcs of the machine.
    pub fn keeps_plane(&self) -> bool {
        self.rows[2][2] == 1.0
    }

    /// The same with lengths in other units.
    #[must_use]
    pub fn convert(&self, from: Units, to: Units) -> Tilt {
        Tilt {
            origin: self.origin.map(|length| from.convert(length, to)),
            ..*self
        }
    }
}

fn about_z(degrees: f64) -> [[f64; 3]; 3] {
    let (sin, cos) = exact(degrees);
    [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]
}

fn about_x(degrees: f64) -> [[f64; 3]; 3] {
    let (sin, cos) = exact(degrees);
    [[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]]
}

/// Sine and cosine whose zeros are zeros.
fn exact(degrees: f64) -> (f64, f64) {
    let (sin, cos) = math::sin_cos(rad(degrees));
    // cos 90 degrees is 6e-17 in floating point, which would tilt planes that are not tilted.
    let clean = |value: f64| {
        if value.abs() < ROTATION_ROUNDING {
            0.0
        } else {
            value
        }
    };
    (clean(sin), clean(cos))
}

fn turn(rows: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    rows.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn times(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    a.map(|row| std::array::from_fn(|column| (0..3).map(|k| row[k] * b[k][column]).sum()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_plane_stood_upright_has_its_y_along_z() {
        let mut place = [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        Tilt::in_space([10.0, 20.0, 30.0], [0.0, 90.0, 0.0]).apply(&mut place);
        assert_eq!(place[..3], [11.0, 17.0, 32.0]);
    }

    proptest! {
        #[test]
        fn undoing_brings_back_and_lengths_stay(euler in [-180.0..180.0_f64, -180.0..180.0_f64, -180.0..180.0_f64], at in [-99.0..99.0_f64, -99.0..99.0_f64, -99.0..99.0_f64]) {
            let tilt = Tilt::in_space([5.0, -6.0, 7.0], euler);
            let mut place = [at[0], at[1], at[2], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
            tilt.apply(&mut place);
            let square: f64 = (0..3).map(|i| (place[i] - tilt.origin[i]) * (place[i] - tilt.origin[i])).sum();
            prop_assert!((square - at.iter().map(|v| v * v).sum::<f64>()).abs() < 1e-8);
            tilt.undo(&mut place);
            for axis in 0..3 {
                prop_assert!((place[axis] - at[axis]).abs() < 1e-10);
            }
        }
    }
}
