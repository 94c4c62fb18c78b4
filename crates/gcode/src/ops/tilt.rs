//! Turned coordinates: G68 in the plane, G68.2 in space.

use super::parts::{Position, Units};
use lostmotion_base::math;
use lostmotion_base::units::rad;
use serde::{Deserialize, Serialize};

/// A rotation of X Y Z and a shift: place = origin + rows * program. Lengths in program units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tilt {
    /// Where the turned coordinates' zero lies.
    pub origin: [f64; 3],
    /// Rotation matrix by rows.
    pub rows: [[f64; 3]; 3],
}

/// Entries of a rotation smaller than this are rounding.
const ROUNDING: f64 = 1e-15;

impl Tilt {
    /// G68: about a point of the XY plane, counter-clockwise, degrees.
    pub fn in_plane(center: [f64; 2], degrees: f64) -> Tilt {
        let rows = about_z(degrees);
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
    let clean = |value: f64| if value.abs() < ROUNDING { 0.0 } else { value };
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
