//! A plant whose parameters change with time.

use super::mode::{Contact, Side};
use super::{Plant, PlantParams, PlantState};
use crate::config::{Change, Drift};
use lostmotion_base::Clock;

/// Setpoints between two renewals of what the exact steps of a drifting axis are made of: inertia, viscous friction, stiffness.
pub const DRIFT_TICKS: u64 = 100;

/// The plant of a drifting axis at one setpoint: a function of the setpoint's number alone, kept because it is costly to make.
#[derive(Clone, Debug)]
pub(crate) struct Drifting {
    drift: Drift,
    start: PlantParams,
    plant: Plant,
    epoch: u64,
}

fn factor(change: Option<Change>, time_s: f64) -> f64 {
    change.map_or(1.0, |change| change.at(time_s))
}

impl Drifting {
    /// None for an axis that does not drift.
    pub(crate) fn new(drift: &Drift, plant: &Plant) -> Option<Drifting> {
        if drift.is_none() {
            return None;
        }
        Some(Drifting { drift: *drift, start: *plant.params(), plant: plant.clone(), epoch: 0 })
    }

    /// The plant as it was made last.
    #[inline]
    pub(crate) fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Makes the plant of setpoint `tick`, and gives a state that was reached under other parameters the contact that it has now.
    pub(crate) fn advance(&mut self, tick: u64, state: &mut PlantState) {
        let epoch = tick / DRIFT_TICKS;
        if epoch != self.epoch && self.drift.changes_steps() {
            self.plant = Plant::new(&self.slow(epoch * DRIFT_TICKS));
        }
        self.epoch = epoch;
        let (drift, start, time_s) = (&self.drift, &self.start, seconds(tick));
        let params = &mut self.plant.params;
        params.half_gap_rad = start.half_gap_rad * factor(drift.gap, time_s);
        params.load_coulomb_nm = start.load_coulomb_nm * factor(drift.load_coulomb, time_s);
        params.motor_coulomb_nm = start.motor_coulomb_nm * factor(drift.motor_coulomb, time_s);
        self.plant.touch(state);
    }

    fn slow(&self, tick: u64) -> PlantParams {
        let (drift, start, time_s) = (&self.drift, &self.start, seconds(tick));
        PlantParams {
            load_viscous_nm_s_per_rad: start.load_viscous_nm_s_per_rad * factor(drift.load_viscous, time_s),
            load_inertia_kgm2: start.load_inertia_kgm2 * factor(drift.load_inertia, time_s),
            motor_viscous_nm_s_per_rad: start.motor_viscous_nm_s_per_rad * factor(drift.motor_viscous, time_s),
            stiffness_nm_per_rad: start.stiffness_nm_per_rad * factor(drift.stiffness, time_s),
            ..*start
        }
    }
}

fn seconds(tick: u64) -> f64 {
    tick as f64 * Clock::CNC.period_s()
}

impl Plant {
    /// A flank that has moved may touch, or be left, where nothing else has moved.
    fn touch(&self, state: &mut PlantState) {
        let b = self.params.half_gap_rad;
        let contact = &mut state.mode.contact;
        *contact = match *contact {
            Contact::Gap if state.gap_angle.abs() > b => Contact::Spring(Side::of(state.gap_angle)),
            Contact::Spring(side) | Contact::Doubled(side) | Contact::Lifted(side) if side.sign() * state.gap_angle < b => Contact::Gap,
            same => same,
        };
    }
}
