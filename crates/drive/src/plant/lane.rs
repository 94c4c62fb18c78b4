//! The plant's fast step as plain numbers: those of a mode, which many steps share, and all that a
//! batch needs to take it for several axes at once.
//!
//! A lane holds the numbers of one plant in one mode. [`crate::batch`] applies the laws of
//! [`super::Plant::step`] to them up to and including the look for events; where that look finds
//! that something may happen, the plant itself steps.

use super::Plant;
use super::dynamics::{Electric, LOAD, MOTOR, Vector, shaft_torque};
use super::mode::{Contact, Friction, Mass, Mode};
use super::quiet::{Watch, keeps_pushing, keeps_sliding, keeps_standing, stays_within};
use crate::config::ContactLaw;

/// What a step of a plant in a mode asks for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    pub(crate) mode: Mode,
    /// The table of its step.
    pub(super) matrix: usize,
    /// Gap angle at which the penetration is zero.
    pub(crate) offset: f64,
    /// Coulomb friction of motor and load against their sliding, N m.
    pub(crate) friction: [f64; 2],
    /// Stiffness and damping of the shaft.
    pub(crate) shaft: (f64, f64),
    pub(crate) torque_constant: f64,
    pub(crate) look: Look,
    /// Whether a contact may not pull, and whether a mass stands.
    pub(crate) pushes: bool,
    pub(crate) stands: bool,
}

impl Known {
    /// Whether the contact stays what it is over a step between two ends, by the cubic of the penetration
    /// and by spring and damper.
    #[inline(always)]
    pub(super) fn keeps_contact(&self, before: &Vector, after: &Vector) -> bool {
        let Look {
            range,
            third,
            push: [stiffness, damping],
            push_margin,
            ..
        } = self.look;
        stays_within(range, third, before, after)
            && (!self.pushes || keeps_pushing(stiffness, damping, push_margin, before, after))
    }

    /// Whether frictions stay what they are, by how much speeds and torques change; `load_torque` is held
    /// against the load, N m.
    #[inline(always)]
    pub(super) fn keeps_frictions(
        &self,
        before: &Vector,
        after: &Vector,
        load_torque: f64,
    ) -> bool {
        let look = &self.look;
        let slides = |mass: usize, speed: [f64; 2]| {
            keeps_sliding(look.sliding[mass], look.speed_margin[mass], speed)
        };
        slides(0, [before[MOTOR], after[MOTOR]])
            && slides(1, [before[LOAD], after[LOAD]])
            && (!self.stands || self.keeps_standing([before, after], load_torque))
    }

    /// Torque that friction has to balance: at the motor the current's less the shaft's, at the load the
    /// shaft's less what is held against it.
    fn keeps_standing(&self, ends: [&Vector; 2], load_torque: f64) -> bool {
        let look = &self.look;
        let stands = |mass: usize, [before, after]: [f64; 2]| {
            keeps_standing(look.holding[mass], look.torque_margin, before, after)
        };
        let motor = |x: &Vector| self.torque_constant * x[0] - shaft_torque(self.shaft, x);
        let load = |x: &Vector| shaft_torque(self.shaft, x) - load_torque;
        stands(0, ends.map(motor)) && stands(1, ends.map(load))
    }
}

/// Numbers of a plant in a mode, for a batch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lane {
    pub(crate) known: Known,
    /// Columns of the step's matrix, then the row of the load's travel: see
    /// [`super::dynamics::StepTable`].
    pub(crate) columns: [[f64; 4]; 7],
    pub(crate) travel: [f64; 7],
    pub(crate) electric: Electric<f64>,
    pub(crate) load_constant: f64,
    /// What the frictions of motor and load are judged by where that does not suffice.
    pub(crate) watches: [Watch<f64>; 2],
}

/// Bounds of the look for events; infinite where a mode has no such event.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Look {
    /// A third of the period.
    pub(crate) third: f64,
    /// Range of the penetration.
    pub(crate) range: [f64; 2],
    /// Stiffness with the flank's sign, and damping, of a contact that may not pull; 0 elsewhere.
    pub(crate) push: [f64; 2],
    /// What is asked for between spring and damper.
    pub(crate) push_margin: f64,
    /// Signs of sliding of motor and load.
    pub(crate) sliding: [f64; 2],
    /// What is asked for between speed and its change.
    pub(crate) speed_margin: [f64; 2],
    /// Friction that holds motor and load.
    pub(crate) holding: [f64; 2],
    pub(crate) torque_margin: f64,
}

impl Plant {
    /// What a step in a mode asks for.
    pub(crate) fn known(&self, mode: Mode) -> Known {
        let (params, look) = (&self.params, self.look(mode));
        Known {
            mode,
            matrix: mode.matrix(),
            offset: params.flank(mode.contact.sign()),
            friction: [
                params.sliding_torque(Mass::Motor, mode.motor),
                params.sliding_torque(Mass::Load, mode.load),
            ],
            shaft: params.shaft(mode.contact.coupling()),
            torque_constant: params.torque_constant_nm_per_a,
            pushes: look.push_margin > f64::NEG_INFINITY,
            stands: mode.motor.stuck() || mode.load.stuck(),
            look,
        }
    }

    /// The numbers of a mode for a batch; `None` where a step of this plant is not the product with a table. In
    /// a mode whose look for events is a different one the range of the penetration is empty, so
    /// that something may happen at every step.
    pub(crate) fn lane(&self, mode: Mode) -> Option<Lane> {
        // steps of a plant that is not linear are series
        if self.curved {
            return None;
        }
        let (params, known) = (&self.params, self.known(mode));
        let (columns, travel) = self.tables.get(known.matrix)?.numbers();
        Some(Lane {
            known,
            columns,
            travel,
            electric: self.electric,
            load_constant: params.load_constant_nm,
            watches: [Mass::Motor, Mass::Load].map(|mass| self.margins.watch(params, mode, mass)),
        })
    }

    fn look(&self, mode: Mode) -> Look {
        let (params, margins) = (&self.params, &self.margins);
        // the range of the penetration in which the mode lasts; empty where another look is needed
        let range = match mode.contact {
            Contact::Rigid => [f64::NEG_INFINITY, f64::INFINITY],
            Contact::Gap => [-params.half_gap_rad, params.half_gap_rad],
            Contact::Spring(side) if side.sign() > 0.0 => [0.0, f64::INFINITY],
            Contact::Spring(_) => [f64::NEG_INFINITY, 0.0],
            Contact::Doubled(_) | Contact::Lifted(_) => [f64::INFINITY, f64::NEG_INFINITY],
        };
        // only contacts that may not pull can lift off
        let pushes =
            matches!(mode.contact, Contact::Spring(_)) && params.contact != ContactLaw::Linear;
        let sign = mode.contact.sign();
        // Stribeck friction ends sliding at the speed at which it begins to rise, not at rest
        let speed_margin = |mass: Mass| match mode.friction(mass) {
            Friction::Sliding(_) => margins.speed() + params.friction(mass).slow_rad_s(),
            // creeping ends on both sides: its cubic tells
            Friction::Creeping(_) => f64::INFINITY,
            _ => f64::NEG_INFINITY,
        };
        // a mass that moves has nothing to break away from
        let holding = |mass: Mass| {
            if mode.friction(mass).stuck() {
                params.breakaway(mass)
            } else {
                f64::INFINITY
            }
        };
        Look {
            third: margins.third(),
            range,
            push: if pushes {
                [
                    params.stiffness_nm_per_rad * sign,
                    params.damping_nm_s_per_rad,
                ]
            } else {
                [0.0; 2]
            },
            push_margin: if pushes {
                margins.torque()
            } else {
                f64::NEG_INFINITY
            },
            sliding: [mode.motor.sign(), mode.load.sign()],
            speed_margin: [speed_margin(Mass::Motor), speed_margin(Mass::Load)],
            holding: [holding(Mass::Motor), holding(Mass::Load)],
            torque_margin: margins.torque(),
        }
    }
}
