//! Straight in all axes.

use crate::derivs::within;
use crate::{Bounds, CurveDerivs, Foot};
use lostmotion_base::vec::{dot, norm, sub};
use lostmotion_base::{Coords, units};
use serde::{Deserialize, Serialize};

/// Straight in all axes.
///
/// Its length follows the feed rule of RS274: millimetres of X Y Z if they move, else of U V W if
/// they move, else degrees of A B C. The other axes are linear in `s`. Nothing moves: length 0, all
/// derivatives 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    start: Coords,
    end: Coords,
    direction: Coords,
    length: f64,
}

impl Line {
    /// From one point to another, mm and rad.
    pub fn new(start: Coords, end: Coords) -> Line {
        let delta = end - start;
        // The first of X Y Z, U V W and A B C that moves at all gives the length.
        let [.., u, v, w] = delta.0;
        let lengths = [
            delta.linear_norm(),
            norm([u, v, w]),
            units::deg(norm(delta.rotary())),
        ];
        let length = lengths
            .into_iter()
            .find(|length| *length != 0.0)
            .unwrap_or(0.0);
        let direction = if length > 0.0 {
            delta.map(|c| c / length)
        } else {
            Coords::ZERO
        };
        Line {
            start,
            end,
            direction,
            length,
        }
    }

    /// Where it begins.
    pub const fn start(&self) -> Coords {
        self.start
    }

    /// Where it ends.
    pub const fn end(&self) -> Coords {
        self.end
    }

    /// Its length, mm, or degrees where only rotary axes move.
    pub const fn length(&self) -> f64 {
        self.length
    }

    /// The derivative of all axes by s.
    pub const fn direction(&self) -> Coords {
        self.direction
    }

    /// The point at s; s is held within the line.
    pub fn point(&self, s: f64) -> Coords {
        // The programmed end itself, not start + direction * length with its rounding.
        if s >= self.length {
            self.end
        } else {
            self.start + self.direction * s.max(0.0)
        }
    }

    /// Point and derivatives at s.
    pub fn eval(&self, s: f64) -> CurveDerivs {
        CurveDerivs {
            p: self.point(s),
            d1: self.direction,
            ..CurveDerivs::default()
        }
    }

    /// The nearest point in closed form.
    pub fn nearest(&self, point: [f64; 3], range: (f64, f64)) -> Foot {
        let direction = self.direction.linear();
        let square = dot(direction, direction);
        let offset = sub(point, self.start.linear());
        // Projection of the offset on the line. Where X Y Z stand still every s is as near.
        let along = if square > 0.0 {
            dot(offset, direction) / square
        } else {
            range.0
        };
        let s = within(along, range.0, range.1);
        Foot {
            s,
            distance: norm(sub(self.point(s).linear(), point)),
        }
    }

    /// The stretch from `s0` to `s1`.
    pub fn sub(&self, s0: f64, s1: f64) -> Line {
        let (s0, s1) = (within(s0, 0.0, self.length), within(s1, 0.0, self.length));
        Line {
            start: self.point(s0),
            end: self.point(s1),
            direction: self.direction,
            length: (s1 - s0).max(0.0),
        }
    }

    /// The box around it.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.start, self.end)
    }
}
