//! The polynomial between two setpoints.

use crate::signal::Reference;
use serde::{Deserialize, Serialize};

/// A setpoint with its derivatives: position in the axis' unit, derivatives at the motor; none is
/// 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Node {
    pub(super) position: f64,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
}

/// Position at the motor by the part u of the period: `base + c1 u + c2 u^2 + ... + c5 u^5`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Piece {
    base: f64,
    c: [f64; 5],
}

impl Piece {
    pub(super) fn standing(base: f64) -> Piece {
        Piece { base, c: [0.0; 5] }
    }

    /// Quintic that meets both nodes with both derivatives.
    pub(super) fn quintic(from: &Node, to: &Node, factor: f64, h: f64) -> Piece {
        let (v0, a0) = (from.velocity * h, from.acceleration * h * h);
        let position = (to.position - from.position) * factor - v0 - 0.5 * a0;
        let velocity = to.velocity * h - v0 - a0;
        let acceleration = to.acceleration * h * h - a0;
        Piece {
            base: from.position * factor,
            c: [
                v0,
                0.5 * a0,
                10.0 * position - 4.0 * velocity + 0.5 * acceleration,
                -15.0 * position + 7.0 * velocity - acceleration,
                6.0 * position - 3.0 * velocity + 0.5 * acceleration,
            ],
        }
    }

    /// Cubic over a way with a speed at both ends, both for the whole period.
    pub(super) fn hermite(base: f64, way: f64, [v0, v1]: [f64; 2]) -> Piece {
        Piece {
            base,
            c: [v0, 3.0 * way - 2.0 * v0 - v1, v0 + v1 - 2.0 * way, 0.0, 0.0],
        }
    }

    /// Straight.
    pub(super) fn line(base: f64, way: f64) -> Piece {
        Piece {
            base,
            c: [way, 0.0, 0.0, 0.0, 0.0],
        }
    }

    /// Uniform cubic B-spline between the second and the third of four control points, which are
    /// given from `base` on.
    pub(super) fn b_spline(base: f64, [q0, q1, q2, q3]: [f64; 4]) -> Piece {
        let start = (q0 + 4.0 * q1 + q2) / 6.0;
        let c = [
            0.5 * (q2 - q0),
            0.5 * (q0 + q2) - q1,
            (q3 - q0 + 3.0 * (q1 - q2)) / 6.0,
            0.0,
            0.0,
        ];
        Piece {
            base: base + start,
            c,
        }
    }

    /// Where it is at a part of the period of length `h`.
    #[inline]
    pub(super) fn at(&self, u: f64, h: f64) -> Reference {
        let [c1, c2, c3, c4, c5] = self.c;
        let way = u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))));
        Reference {
            position: self.base + way,
            velocity: (c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * (5.0 * c5))))) / h,
            acceleration: (2.0 * c2 + u * (6.0 * c3 + u * (12.0 * c4 + u * (20.0 * c5)))) / (h * h),
        }
    }
}
