//! Rotations of vectors: about a fixed axis, by a matrix, by roll, pitch and yaw.

use lostmotion_base::Real;
use lostmotion_base::vec::{Vec3, constant, cross, dot};

/// Largest difference per coordinate at which a direction counts as a coordinate axis: a few units
/// in the last place of 1, the rounding of normalising a parsed direction.
const AXIS_TOLERANCE: f64 = 1e-15;

/// Cosine of the pitch below which the frame's X points straight up or down, where roll and yaw
/// turn about one axis. Derived: below it rounding (1e-16) leaves roll and yaw fewer than four
/// digits.
const UPRIGHT_COSINE: f64 = 1e-12;

/// Turning about a fixed direction through zero, right-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turning {
    pub(crate) u: [f64; 3],
    /// The two coordinates that it mixes, in right-handed order, if it is along a coordinate axis.
    mixes: Option<(usize, usize)>,
}

impl Turning {
    /// About a unit vector.
    pub(crate) fn about(u: [f64; 3]) -> Turning {
        // A direction along a coordinate axis is made exact: turning about it mixes two coordinates
        // and leaves the third to the bit.
        for axis in 0..3 {
            if u[axis].abs() > 0.5
                && (u[axis].abs() - 1.0).abs() <= AXIS_TOLERANCE
                && (1..3).all(|k| u[(axis + k) % 3].abs() <= AXIS_TOLERANCE)
            {
                let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut exact = [0.0; 3];
                exact[axis] = u[axis].signum();
                return Turning {
                    u: exact,
                    mixes: Some(if u[axis] > 0.0 {
                        (first, second)
                    } else {
                        (second, first)
                    }),
                };
            }
        }
        Turning { u, mixes: None }
    }

    /// A vector turned by an angle whose sine and cosine are given (Rodrigues' formula).
    pub(crate) fn turn<R: Real>(&self, mut v: Vec3<R>, sin: R, cos: R) -> Vec3<R> {
        match self.mixes {
            Some((first, second)) => {
                // About a coordinate axis: the third coordinate keeps its bits.
                let (a, b) = (v[first], v[second]);
                v[first] = a * cos - b * sin;
                v[second] = a * sin + b * cos;
                v
            }
            None => {
                // v + sin (u x v) + (1 - cos) u x (u x v).
                let u = constant(self.u);
                let side = cross(u, v);
                let back = cross(u, side);
                let rest = R::constant(1.0) - cos;
                std::array::from_fn(|i| v[i] + sin * side[i] + rest * back[i])
            }
        }
    }

    /// The same by the angle itself, rad.
    pub(crate) fn by<R: Real>(&self, v: Vec3<R>, angle: R) -> Vec3<R> {
        self.turn(v, angle.sin(), angle.cos())
    }
}

/// Rotation matrix by rows, applied.
pub(crate) fn apply<R: Real>(rows: &[Vec3<R>; 3], v: Vec3<R>) -> Vec3<R> {
    [dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)]
}

/// The rotation Rz(c) Ry(b) Rx(a) of a vector: roll, pitch and yaw about fixed axes.
pub(crate) fn roll_pitch_yaw<R: Real>(v: Vec3<R>, [a, b, c]: [R; 3]) -> Vec3<R> {
    let mut v = v;
    for (axis, angle) in [(0, a), (1, b), (2, c)] {
        let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
        let (sin, cos) = (angle.sin(), angle.cos());
        let (p, q) = (v[first], v[second]);
        v[first] = p * cos - q * sin;
        v[second] = p * sin + q * cos;
    }
    v
}

/// Roll, pitch and yaw of the rotation with these columns; pitch in [-pi/2, pi/2].
pub(crate) fn angles_of(columns: &[[f64; 3]; 3]) -> [f64; 3] {
    use lostmotion_base::math::{atan2, hypot};
    let [x, y, z] = columns;
    let flat = hypot(x[0], x[1]);
    // Looking straight up or down, roll and yaw turn about the same axis: all of it is taken for
    // roll.
    if flat < UPRIGHT_COSINE {
        return [atan2(-z[1], y[1]), atan2(-x[2], flat), 0.0];
    }
    [atan2(y[2], z[2]), atan2(-x[2], flat), atan2(x[1], x[0])]
}
