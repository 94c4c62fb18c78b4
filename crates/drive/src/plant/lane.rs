//! The plant's fast step as plain numbers: what a batch needs to take it for several axes at once.
//!
//! A lane holds the numbers of one plant in one mode. [`crate::batch`] applies the laws of
//! [`super::Plant::step`] to them up to and including the look for events; where that look finds
//! that something may happen, the plant itself steps.

use super::Plant;
use super::dynamics::Electric;
use super::mode::{Contact, Friction, Mass, Mode};
use super::quiet::Watch;
use crate::config::ContactLaw;

/// Numbers of a plant in a mode.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lane {
    pub(crate) mode: Mode,
    /// Columns of the step's matrix, then the row of the load's travel: see
    /// [`super::dynamics::StepTable`].
    pub(crate) columns: [[f64; 4]; 7],
    pub(crate) travel: [f64; 7],
    pub(crate) electric: Electric<f64>,
    pub(crate) torque_constant: f64,
    pub(crate) load_constant: f64,
    /// Gap angle at which the penetration is zero.
    pub(crate) offset: f64,
    /// Coulomb friction of motor and load against their sliding, N m.
    pub(crate) friction: [f64; 2],
    /// Stiffness and damping of the shaft in this mode.
    pub(crate) shaft: [f64; 2],
    pub(crate) look: Look,
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
    /// What the frictions of motor and load are judged by where that does not suffice.
    pub(crate) watches: [Watch<f64>; 2],
}

impl Plant {
    /// The numbers of a mode; `None` where a step of this plant is not the product with a table. In
    /// a mode whose look for events is a different one the range of the penetration is empty, so
    /// that something may happen at every step.
    pub(crate) fn lane(&self, mode: Mode) -> Option<Lane> {
        let (params, table) = (&self.params, self.tables.get(mode.matrix())?);
        // steps of a plant that is not linear are series
        if self.curved {
            return None;
        }
        let (columns, travel) = table.numbers();
        let (stiffness, damping) = params.shaft(mode.contact.coupling());
        Some(Lane {
            mode,
            columns,
            travel,
            electric: self.electric,
            torque_constant: params.torque_constant_nm_per_a,
            load_constant: params.load_constant_nm,
            offset: params.flank(mode.contact.sign()),
            friction: [
                params.sliding_torque(Mass::Motor, mode.motor),
                params.sliding_torque(Mass::Load, mode.load),
            ],
            shaft: [stiffness, damping],
            look: self.look(mode),
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
            watches: [Mass::Motor, Mass::Load].map(|mass| margins.watch(params, mode, mass)),
        }
    }
}
