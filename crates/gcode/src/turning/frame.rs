//! The plane of a turning cycle: along the direction of travel, and the level above it.

use super::piece::{Piece, Point};

/// How Z and X lie along the travel and as level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    /// Z is the direction of travel (G71); otherwise X is (G72).
    pub(crate) along_z: bool,
    /// Signs of travel and level.
    pub(crate) signs: [f64; 2],
}

impl Frame {
    /// A place given as Z and X.
    pub(crate) fn to(&self, zx: Point) -> Point {
        let [first, second] = if self.along_z { zx } else { [zx[1], zx[0]] };
        [self.signs[0] * first, self.signs[1] * second]
    }

    /// A place as Z and X.
    pub(crate) fn from(&self, place: Point) -> Point {
        let turned = [self.signs[0] * place[0], self.signs[1] * place[1]];
        if self.along_z {
            turned
        } else {
            [turned[1], turned[0]]
        }
    }

    /// Whether it sees arcs the other way round.
    pub(crate) fn mirrors(&self) -> bool {
        (self.signs[0] * self.signs[1] > 0.0) != self.along_z
    }

    /// A piece given as Z and X.
    pub(crate) fn piece(&self, piece: &Piece) -> Piece {
        let circle = piece.circle.map(|circle| super::piece::Circle {
            center: self.to(circle.center),
            ccw: circle.ccw != self.mirrors(),
        });
        Piece {
            start: self.to(piece.start),
            end: self.to(piece.end),
            circle,
        }
    }

    /// The frame in which a profile goes forwards and up. Recorded: one that comes inwards is an
    /// inside one, wherever the tool is, and one that ends level with its start goes towards the
    /// smaller values.
    pub(crate) fn of(along_z: bool, [first, last]: [Point; 2]) -> Frame {
        let axis = usize::from(!along_z);
        let level = 1 - axis;
        let sign = |negative: bool| if negative { -1.0 } else { 1.0 };
        Frame {
            along_z,
            signs: [
                sign(last[axis] <= first[axis]),
                sign(last[level] < first[level]),
            ],
        }
    }
}
