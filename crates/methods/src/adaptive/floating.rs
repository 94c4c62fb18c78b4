//! Loads that float: where nothing holds a load, its position in the gap is unknown.
//!
//! A load without friction that is neither accelerated nor held by any torque floats between the
//! flanks at the speed that its last contact left it, and the motor does not show it. A traverse
//! that is right for a load on its flank then releases it, or pushes it: worse than none. So after
//! a rest of a load without friction, or steady travel without need of torque, the gap is not
//! crossed until flanks have changed 4, then 16, then 64 times without one, as on arcs.
//!
//! ```text
//! floats after 20 ms of:  friction < 0.01 T_rated,  |alpha_ref| = 0,  |need| < 0.01 T_rated
//! hardly driven:          J_L |alpha_ref| + b_L |w_ref| < 0.001 T_rated between two changes of flank
//! ```

use lostmotion_drive::signal::Reference;
use lostmotion_drive::twin::LoadModel;
use serde::{Deserialize, Serialize};

/// Servo ticks of rest or steady travel after which the load floats: 20 ms. A choice: a load that
/// left its flank at 0.1 rad/s drifts 6 um meanwhile on a screw of 20 mm.
const FLOATS_AFTER_TICKS: u32 = 80;
/// Changes of flank without a floating stretch after which a load is on its flanks again: at first,
/// and at most. They grow from stretch to stretch. Decision 66 of the book.
const CHANGES_WANTED: [u32; 2] = [2, 64];
/// Coulomb friction that holds a load in place, part of the rated torque. Tuned with wavering
/// flanks and coarse encoders (0.005 before).
const HOLDING_SHARE: f64 = 0.01;
/// Torque that presses a load on a flank, part of the rated torque. Tuned together with
/// `HOLDING_SHARE` (0.003 before).
const PRESSING_SHARE: f64 = 0.01;
/// Torque that a load has to need at some time between two changes of flank for its contacts to
/// show, part of the rated torque. Tuned on the study's matrix, decision 66 of the book.
const DRIVING_SHARE: f64 = 1e-3;
/// Acceleration and speed of a reference that count as zero, rad/s2 and rad/s: above rounding.
const STEADY_BOUND: f64 = 1e-6;

/// Whether the load of an axis may float, from its reference and what is known of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Floating {
    /// Servo ticks of the present stretch in which nothing holds or presses the load.
    steady: u32,
    /// Changes of flank since the last such stretch.
    changes: u32,
    /// Changes of flank that are wanted.
    wanted: u32,
    /// Most torque that its motion needed since the last change of flank, N m.
    most: f64,
}

impl Floating {
    /// No load has floated yet.
    pub(super) const NEVER: Floating = Floating {
        steady: 0,
        changes: CHANGES_WANTED[0],
        wanted: CHANGES_WANTED[0],
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
        let need = load.need(reference.velocity, reference.acceleration, STEADY_BOUND);
        // nothing holds the load and nothing presses it
        let free = friction < HOLDING_SHARE * rated_torque
            && reference.acceleration.abs() < STEADY_BOUND
            && need.abs() < PRESSING_SHARE * rated_torque;
        // a constant torque is learned last and does not change the flank: it does not count as driving
        let driven =
            load.inertia * reference.acceleration.abs() + load.viscous * reference.velocity.abs();
        self.most = self.most.max(driven);
        let hardly = changed
            && load.coulomb < HOLDING_SHARE * rated_torque
            && self.most < DRIVING_SHARE * rated_torque;
        if changed {
            self.most = 0.0;
        }
        // a motion that hardly drives the load leaves it floating; each new floating stretch makes
        // the demand four times as large
        let before = self.steady;
        self.steady = if free {
            (self.steady + 1).min(FLOATS_AFTER_TICKS)
        } else {
            0
        };
        if hardly {
            self.changes = 0;
        } else if self.steady >= FLOATS_AFTER_TICKS {
            if before < FLOATS_AFTER_TICKS && self.changes > 0 {
                self.wanted = if self.wanted == CHANGES_WANTED[0] {
                    2 * self.wanted
                } else {
                    (4 * self.wanted).min(CHANGES_WANTED[1])
                };
            }
            self.changes = 0;
        } else {
            self.changes = (self.changes + u32::from(changed)).min(self.wanted);
        }
    }

    /// The load floats until flanks have changed again.
    pub(super) const FLOATING: Floating = Floating {
        changes: 0,
        ..Floating::NEVER
    };

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
            for change in 1..=2 * CHANGES_WANTED[0] {
                floating.step(&moving, &load(coulomb), coulomb, 11.0, true);
                assert_eq!(
                    floating.floats(),
                    expected && change < 2 * CHANGES_WANTED[0]
                );
            }
        }
    }
}
