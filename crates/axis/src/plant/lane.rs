//! The plant's fast step as plain numbers: what a batch needs to take it for several axes at once.
//!
//! A lane holds the numbers of one plant in one mode. [`crate::batch`] computes with them exactly what [`super::Plant::step`] does up to
//! and including the look for events, operation by operation; where that look finds that something may happen, the plant itself steps.

use super::Plant;
use super::mode::{Contact, Friction, Mode};
use crate::config::ContactLaw;

/// Numbers of a plant in a mode.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lane {
    pub(crate) mode: Mode,
    /// Columns of the step's matrix, then the row of the load's travel: see [`super::table::StepTable`].
    pub(crate) columns: [[f64; 4]; 7],
    pub(crate) travel: [f64; 7],
    pub(crate) decay_d: f64,
    pub(crate) gain_d: f64,
    pub(crate) pole_pairs: f64,
    pub(crate) inductance: f64,
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
}

impl Plant {
    /// The numbers of a mode; none where a step of this plant is not such a product.
    pub(crate) fn lane(&self, mode: Mode) -> Option<Lane> {
        let (params, margins) = (&self.params, &self.margins);
        let (columns, travel) = self.tables.get(mode.matrix())?.numbers();
        let (stiffness, damping) = params.shaft(mode.contact.coupling());
        let range = match mode.contact {
            Contact::Rigid => [f64::NEG_INFINITY, f64::INFINITY],
            Contact::Gap => [-params.half_gap_rad, params.half_gap_rad],
            Contact::Spring(side) if side.sign() > 0.0 => [0.0, f64::INFINITY],
            Contact::Spring(_) => [f64::NEG_INFINITY, 0.0],
            Contact::Doubled(_) | Contact::Lifted(_) => [f64::INFINITY, f64::NEG_INFINITY],
        };
        let pushes = matches!(mode.contact, Contact::Spring(_)) && params.contact != ContactLaw::Linear;
        let [motor, load] = [mode.motor, mode.load];
        let speed_margin = |friction: Friction| if matches!(friction, Friction::Sliding(_)) { margins.speed() } else { f64::NEG_INFINITY };
        let holding = |friction: Friction, coulomb: f64| if friction.stuck() { coulomb } else { f64::INFINITY };
        Some(Lane {
            mode,
            columns,
            travel,
            decay_d: self.decay_d,
            gain_d: self.gain_d,
            pole_pairs: params.pole_pairs,
            inductance: params.inductance_h,
            torque_constant: params.torque_constant_nm_per_a,
            load_constant: params.load_constant_nm,
            offset: mode.contact.sign() * params.half_gap_rad,
            friction: [params.motor_coulomb_nm * motor.sign(), params.load_coulomb_nm * load.sign()],
            shaft: [stiffness, damping],
            look: Look {
                third: margins.third(),
                range,
                push: if pushes { [params.stiffness_nm_per_rad * mode.contact.sign(), params.damping_nm_s_per_rad] } else { [0.0; 2] },
                push_margin: if pushes { margins.torque() } else { f64::NEG_INFINITY },
                sliding: [motor.sign(), load.sign()],
                speed_margin: [speed_margin(motor), speed_margin(load)],
                holding: [holding(motor, params.motor_coulomb_nm), holding(load, params.load_coulomb_nm)],
                torque_margin: margins.torque(),
            },
        })
    }
}
