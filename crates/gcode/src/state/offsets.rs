//! Offsets: from program coordinates to those of the machine.

use crate::ops::Tilt;
use crate::ops::{Position, Units};
use lostmotion_base::math;
use lostmotion_base::units::rad;
use serde::{Deserialize, Serialize};

/// What G53, G54 and the like are about, and how far the tool reaches. Lengths in program units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Offsets {
    /// Origin of the work coordinate system.
    pub g5x: Position,
    /// G92 and G52 offset.
    pub g92: Position,
    /// Tool offset.
    pub tool: Position,
    /// Rotation about Z in degrees.
    pub rotation_deg: f64,
    /// Turned coordinates (G68, G68.2) in those of the workpiece.
    pub tilt: Option<Tilt>,
}

impl Offsets {
    /// Program coordinates to machine coordinates of the spindle: the work coordinates are turned,
    /// then shifted.
    pub fn to_machine(&self, program: &Position) -> Position {
        // Tilt, then G92, then the rotation of the system, then its origin and the tool.
        let mut work = *program;
        if let Some(tilt) = &self.tilt {
            tilt.apply(&mut work);
        }
        work = add(&work, &self.g92);
        rotate(&mut work, self.rotation_deg);
        add(&work, &add(&self.g5x, &self.tool))
    }

    /// Machine coordinates of the spindle to program coordinates.
    pub fn to_program(&self, machine: &Position) -> Position {
        // The steps of `to_machine` undone in reverse order.
        let mut work = subtract(machine, &add(&self.g5x, &self.tool));
        rotate(&mut work, -self.rotation_deg);
        work = subtract(&work, &self.g92);
        if let Some(tilt) = &self.tilt {
            tilt.undo(&mut work);
        }
        work
    }
}

/// Sum by axis.
pub fn add(a: &Position, b: &Position) -> Position {
    std::array::from_fn(|axis| a[axis] + b[axis])
}

/// Difference by axis.
pub fn subtract(a: &Position, b: &Position) -> Position {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

/// Turns X and Y about the origin.
pub fn rotate(position: &mut Position, degrees: f64) {
    if degrees != 0.0 {
        let (sin, cos) = math::sin_cos(rad(degrees));
        let [x, y, ..] = *position;
        position[0] = x * cos - y * sin;
        position[1] = x * sin + y * cos;
    }
}

/// A position whose lengths are in other units.
pub fn convert(position: &Position, from: Units, to: Units) -> Position {
    let mut converted = *position;
    for (index, coordinate) in converted.iter_mut().enumerate() {
        if !is_angle(index) {
            *coordinate = from.convert(*coordinate, to);
        }
    }
    converted
}

/// Whether an axis index is one of A, B, C.
pub(crate) const fn is_angle(index: usize) -> bool {
    index >= 3 && index < 6
}
