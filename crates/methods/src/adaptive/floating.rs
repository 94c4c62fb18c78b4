//! Where nothing holds the load, nobody knows where it is.
//!
//! A load without friction that is neither accelerated nor held by any torque floats between the
//! flanks at whatever speed its last contact left it, and the motor does not see it. A traverse
//! that is right for a load on its flank then lets it go, or pushes it: worse than none. So after a
//! rest of such a load, or steady travel without need of torque, the gap is not crossed until
//! flanks have changed many times without one, as on arcs.

use lostmotion_drive::signal::Reference;
use lostmotion_drive::twin::LoadModel;
use serde::{Deserialize, Serialize};

/// Ticks of rest or steady travel after which the load floats: 20 ms.
const LONG: u32 = 80;
/// Changes of flank without such a stretch after which it is on its flanks again: at first, and at
/// most. They grow from stretch to stretch.
const CHANGES: [u32; 2] = [2, 64];
/// Parts of the rated torque: friction below which nothing holds the load, and torque that does not
/// press it on a flank.
const HELD: f64 = 0.01;
const PRESSED: f64 = 0.01;
/// Part of the rated torque that a load has to need at some time between two changes of flank, else
/// it hardly feels its flanks.
const DRIVEN: f64 = 1e-3;
/// An acceleration below this is none, and a speed, rad/s2 and rad/s.
const STEADY: f64 = 1e-6;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Floating {
    steady: u32,
    changes: u32,
    wanted: u32,
    /// Most torque that its motion needed since the last change of flank, N m.
    most: f64,
}

impl Floating {
    /// Nothing has floated yet.
    pub(super) const NEVER: Floating = Floating {
        steady: 0,
        changes: CHANGES[0],
        wanted: CHANGES[0],
        most: 0.0,
    };

    /// Takes the reference of a tick, the load as it is known, Coulomb friction that may hold it (N
    /// m), and whether the flank that has to carry it changed.
    pub(super) fn step(
        &mut self,
        reference: &Reference,
        load: &LoadModel,
        friction: f64,
        rated_torque: f64,
        changed: bool,
    ) {
        let need = load.need(reference.velocity, reference.acceleration, STEADY);
        let free = friction < HELD * rated_torque
            && reference.acceleration.abs() < STEADY
            && need.abs() < PRESSED * rated_torque;
        // what it may need all the time is learned last, and drives no change of flank
        let driven =
            load.inertia * reference.acceleration.abs() + load.viscous * reference.velocity.abs();
        self.most = self.most.max(driven);
        let hardly =
            changed && load.coulomb < HELD * rated_torque && self.most < DRIVEN * rated_torque;
        if changed {
            self.most = 0.0;
        }
        let before = self.steady;
        self.steady = if free { (self.steady + 1).min(LONG) } else { 0 };
        if hardly {
            self.changes = 0;
        } else if self.steady >= LONG {
            if before < LONG && self.changes > 0 {
                self.wanted = if self.wanted == CHANGES[0] {
                    2 * self.wanted
                } else {
                    (4 * self.wanted).min(CHANGES[1])
                };
            }
            self.changes = 0;
        } else {
            self.changes = (self.changes + u32::from(changed)).min(self.wanted);
        }
    }

    /// Whether the load may float.
    pub(super) fn floats(&self) -> bool {
        self.changes < self.wanted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_without_friction_floats_after_a_rest_until_flanks_have_changed() {
        let load = |coulomb: f64| LoadModel {
            inertia: 0.004,
            viscous: 0.0,
            coulomb,
            constant: 0.0,
            stiffness: 2400.0,
            damping: 0.2,
        };
        let rest = Reference::default();
        let moving = Reference {
            velocity: 5.0,
            acceleration: 20.0,
            ..rest
        };
        for (coulomb, expected) in [(0.0, true), (0.5, false)] {
            let mut floating = Floating::NEVER;
            for _ in 0..200 {
                floating.step(&rest, &load(coulomb), coulomb, 11.0, false);
            }
            assert_eq!(floating.floats(), expected);
            for change in 1..=2 * CHANGES[0] {
                floating.step(&moving, &load(coulomb), coulomb, 11.0, true);
                assert_eq!(floating.floats(), expected && change < 2 * CHANGES[0]);
            }
        }
    }
}
