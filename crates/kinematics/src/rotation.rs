//! Rotations of vectors: about a fixed axis, by a matrix, by roll, pitch and yaw; and the turns that
//! bring one direction onto another, the closed forms behind every analytic inverse here.
//!
//! The latter are Paden and Kahan's subproblems in the form of R. M. Murray, Z. Li, S. S. Sastry, A
//! Mathematical Introduction to Robotic Manipulation, CRC Press 1994, chapter 3.3.

use lostmotion_base::Real;
use lostmotion_base::vec::{Vec3, constant, cross, dot, norm, scale, sub};

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

/// How far the cosine of a direction may lie beyond 1 and still be rounding.
const REACH_TOLERANCE: f64 = 1e-9;
/// Square of the sine of the angle to an axis below which a direction counts as the axis itself:
/// 1e-11 rad. Derived: there rounding of the direction (1e-16) makes the angle uncertain by 1e-5
/// rad.
const POLE_SINE_SQUARED: f64 = 1e-22;

/// Distance from 1 of the largest (or from -1 of the smallest) cosine that a pair of joints can give
/// at which the pole itself can be reached: rounding of the description's numbers.
const POLE_COSINE_ERROR: f64 = 1e-12;

/// Angles x that fulfil a cos x + b sin x = d: x = atan2(b, a) + / - atan2(sqrt((h - d)(h + d)), d)
/// with h = |(a, b)|. `above` and `below` are h - d and h + d, given because they may be known more
/// exactly than by subtraction. `None` if no angle does.
pub(crate) fn cosine<R: Real>(a: R, b: R, d: R, above: R, below: R) -> Option<[R; 2]> {
    let size = (a.value() * a.value() + b.value() * b.value()).sqrt();
    // Beyond the reach by more than rounding, or a pair that does not turn at all.
    if above.value() < -REACH_TOLERANCE * (1.0 + size)
        || below.value() < -REACH_TOLERANCE * (1.0 + size)
        || size == 0.0
    {
        return None;
    }
    // h^2 - d^2 as a product keeps its digits near a pole.
    let square = above * below;
    let root = if square.value() > 0.0 {
        square.sqrt()
    } else {
        R::constant(0.0)
    };
    let (middle, half) = (b.atan2(a), root.atan2(d));
    Some([middle + half, middle - half])
}

/// The angle about `u` that turns `from` to `to`, both seen along `u`; `None` if either lies on `u`.
pub(crate) fn about<R: Real>(u: [f64; 3], from: Vec3<R>, to: Vec3<R>) -> Option<R> {
    let along = constant(u);
    // What lies along u is taken off first: near u it would drown the rest.
    let flat = |v: Vec3<R>| sub(v, scale(along, dot(along, v)));
    let (p, q) = (flat(from), flat(to));
    let (sin, cos) = (dot(along, cross(p, q)), dot(p, q));
    let size = dot(from, from).value() * dot(to, to).value();
    let seen = sin.value() * sin.value() + cos.value() * cos.value();
    (seen > POLE_SINE_SQUARED * size * size).then(|| sin.atan2(cos))
}

/// Angles (a, b) with R(u1, a) R(u2, b) t = d for unit vectors. The first angle of a pair is `None`
/// where the direction lies on `u1` (the pole), so that any does.
///
/// With t = t_u u2 + t_p, u1 . R(u2, b) t = t_u (u1 . u2) + (u1 . t_p) cos b + u1 . (u2 x t) sin b
/// has to be u1 . d, which has two solutions or none; a follows from each.
pub(crate) fn two<R: Real>(
    u1: &Turning,
    u2: &Turning,
    t: [f64; 3],
    d: Vec3<R>,
) -> Option<[(Option<R>, R); 2]> {
    let along = dot(t, u2.u);
    let lean = dot(u1.u, u2.u);
    let a = dot(u1.u, t) - along * lean;
    let b = dot(u1.u, cross(u2.u, t));
    let h = (a * a + b * b).sqrt();
    let seen = dot(constant(u1.u), d);
    let offset = along * lean;
    // Near a pole u1 . d is near 1 and says nothing any more; the chord from u1 to d does.
    let chord = |sign: f64| {
        let away = sub(d, constant(u1.u.map(|c| sign * c)));
        dot(away, away) * R::constant(0.5)
    };
    // Cosines of the directions nearest to u1 and to its opposite that the second joint reaches.
    let (most, least) = (offset + h, offset - h);
    let above = if (most - 1.0).abs() < POLE_COSINE_ERROR {
        chord(1.0)
    } else {
        R::constant(most) - seen
    };
    let below = if (least + 1.0).abs() < POLE_COSINE_ERROR {
        chord(-1.0)
    } else {
        seen - R::constant(least)
    };
    let angles = cosine(
        R::constant(a),
        R::constant(b),
        seen - R::constant(offset),
        above,
        below,
    )?;
    Some(angles.map(|angle| (about(u1.u, u2.by(constant(t), angle), d), angle)))
}

/// The angle with R(u, a) t = d; `None` if no angle does, `Some(None)` where any does.
pub(crate) fn one(u: &Turning, t: [f64; 3], d: [f64; 3]) -> Option<Option<f64>> {
    let angle = about(u.u, t, d);
    let reached = u.by(t, angle.unwrap_or(0.0));
    (norm(sub(reached, d)) < REACH_TOLERANCE).then_some(angle)
}
