//! Vectors in space over plain numbers and jets alike, and turning about a fixed axis.

use lostmotion_base::Real;

/// X, Y, Z.
pub(crate) type Vector<R> = [R; 3];

/// Directions nearer to a coordinate axis than this are taken for it.
const SNAP: f64 = 1e-15;

pub(crate) fn constant<R: Real>(v: [f64; 3]) -> Vector<R> {
    v.map(R::constant)
}

pub(crate) fn add<R: Real>(a: Vector<R>, b: Vector<R>) -> Vector<R> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn sub<R: Real>(a: Vector<R>, b: Vector<R>) -> Vector<R> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn scale<R: Real>(a: Vector<R>, factor: R) -> Vector<R> {
    a.map(|c| c * factor)
}

pub(crate) fn dot<R: Real>(a: Vector<R>, b: Vector<R>) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross<R: Real>(a: Vector<R>, b: Vector<R>) -> Vector<R> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Length of a plain vector.
pub(crate) fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// A plain vector of length 1; none for one without a direction.
pub(crate) fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = norm(a);
    (length.is_finite() && length > 1e-9).then(|| a.map(|c| c / length))
}

/// A unit vector across a unit vector.
pub(crate) fn across(u: [f64; 3]) -> [f64; 3] {
    let least = if u[0].abs() <= u[1].abs() && u[0].abs() <= u[2].abs() {
        [1.0, 0.0, 0.0]
    } else if u[1].abs() <= u[2].abs() {
        [0.0, 1.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    let v = cross(u, least);
    scale(v, 1.0 / norm(v))
}

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
        for axis in 0..3 {
            if u[axis].abs() > 0.5
                && (u[axis].abs() - 1.0).abs() <= SNAP
                && (1..3).all(|k| u[(axis + k) % 3].abs() <= SNAP)
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
    pub(crate) fn turn<R: Real>(&self, mut v: Vector<R>, sin: R, cos: R) -> Vector<R> {
        match self.mixes {
            Some((first, second)) => {
                let (a, b) = (v[first], v[second]);
                v[first] = a * cos - b * sin;
                v[second] = a * sin + b * cos;
                v
            }
            None => {
                let u = constant(self.u);
                let side = cross(u, v);
                let back = cross(u, side);
                let rest = R::constant(1.0) - cos;
                std::array::from_fn(|i| v[i] + sin * side[i] + rest * back[i])
            }
        }
    }

    /// The same by the angle itself, rad.
    pub(crate) fn by<R: Real>(&self, v: Vector<R>, angle: R) -> Vector<R> {
        self.turn(v, angle.sin(), angle.cos())
    }
}

/// Rotation matrix by rows, applied.
pub(crate) fn apply<R: Real>(rows: &[Vector<R>; 3], v: Vector<R>) -> Vector<R> {
    [dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)]
}

/// The rotation Rz(c) Ry(b) Rx(a) of a vector: roll, pitch and yaw about fixed axes.
pub(crate) fn roll_pitch_yaw<R: Real>(v: Vector<R>, [a, b, c]: [R; 3]) -> Vector<R> {
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
    if flat < 1e-12 {
        return [atan2(-z[1], y[1]), atan2(-x[2], flat), 0.0];
    }
    [atan2(y[2], z[2]), atan2(-x[2], flat), atan2(x[1], x[0])]
}
