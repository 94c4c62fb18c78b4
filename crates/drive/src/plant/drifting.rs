//! A plant whose parameters change with time.

use super::mode::{Contact, Mass, Side};
use super::{Plant, PlantParams, PlantState};
use crate::config::{Change, Cycles, Drift};
use lostmotion_base::Clock;

/// Time between two renewals of what the exact steps of a drifting axis are made of (inertia,
/// viscous friction, stiffness), ms.
pub const DRIFT_MS: f64 = 100.0;

/// The plant of a drifting axis at one setpoint: a function of the setpoint's number alone, kept
/// because it is costly to make.
#[derive(Clone, Debug)]
pub(crate) struct Drifting {
    drift: Drift,
    start: PlantParams,
    plant: Plant,
    /// The setpoints' clock, and their number from renewal to renewal.
    clock: Clock,
    renewal_ticks: u64,
    epoch: u64,
}

fn factor(change: Option<Change>, time_s: f64) -> f64 {
    change.map_or(1.0, |change| change.at(time_s))
}

impl Drifting {
    /// None for an axis that does not drift.
    pub(crate) fn new(drift: &Drift, cycles: &Cycles, plant: &Plant) -> Option<Drifting> {
        if drift.is_none() {
            return None;
        }
        let clock = cycles.command();
        // renewals fall on whole setpoints, whatever the command cycle is
        let renewal_ticks = ((DRIFT_MS / cycles.command_ms).round() as u64).max(1);
        Some(Drifting {
            drift: *drift,
            start: *plant.params(),
            plant: plant.clone(),
            clock,
            renewal_ticks,
            epoch: 0,
        })
    }

    /// The plant as it was made last.
    #[inline]
    pub(crate) fn plant(&self) -> &Plant {
        &self.plant
    }

    /// Makes the plant of setpoint `tick`, and gives a state that was reached under other
    /// parameters the contact that it has now.
    pub(crate) fn advance(&mut self, tick: u64, state: &mut PlantState) {
        // matrices are costly: quantities in them are renewed at fixed setpoints, so that the plant
        // is a function of the setpoint alone
        let epoch = tick / self.renewal_ticks;
        let renewed = epoch * self.renewal_ticks;
        if epoch != self.epoch
            && (self.drift.changes_steps() || self.creeps(Mass::Motor) || self.creeps(Mass::Load))
        {
            self.plant = Plant::new(&self.slow(renewed));
        }
        self.epoch = epoch;
        // gap and sliding friction stand outside the matrices and follow at every setpoint
        let (drift, start) = (&self.drift, &self.start);
        let friction_time = |mass| self.seconds(if self.creeps(mass) { renewed } else { tick });
        let load_coulomb_nm =
            start.load_coulomb_nm * factor(drift.load_coulomb, friction_time(Mass::Load));
        let motor_coulomb_nm =
            start.motor_coulomb_nm * factor(drift.motor_coulomb, friction_time(Mass::Motor));
        let half_gap_rad = start.half_gap_rad * factor(drift.gap, self.seconds(tick));
        self.plant.params = PlantParams {
            half_gap_rad,
            load_coulomb_nm,
            motor_coulomb_nm,
            ..self.plant.params
        };
        // the flanks may have moved past the motor while nothing else did
        self.plant.touch(state);
    }

    fn seconds(&self, tick: u64) -> f64 {
        tick as f64 * self.clock.period_s()
    }

    /// Whether a friction that drifts is part of the exact steps.
    fn creeps(&self, mass: Mass) -> bool {
        let drifts = match mass {
            Mass::Motor => self.drift.motor_coulomb.is_some(),
            Mass::Load => self.drift.load_coulomb.is_some(),
        };
        drifts && self.start.friction(mass).creeps()
    }

    fn slow(&self, tick: u64) -> PlantParams {
        let (drift, start, time_s) = (&self.drift, &self.start, self.seconds(tick));
        PlantParams {
            load_viscous_nm_s_per_rad: start.load_viscous_nm_s_per_rad
                * factor(drift.load_viscous, time_s),
            load_inertia_kgm2: start.load_inertia_kgm2 * factor(drift.load_inertia, time_s),
            motor_viscous_nm_s_per_rad: start.motor_viscous_nm_s_per_rad
                * factor(drift.motor_viscous, time_s),
            // friction that creeps stands in the matrices with its fall over speed
            load_coulomb_nm: start.load_coulomb_nm * factor(drift.load_coulomb, time_s),
            motor_coulomb_nm: start.motor_coulomb_nm * factor(drift.motor_coulomb, time_s),
            stiffness_nm_per_rad: start.stiffness_nm_per_rad * factor(drift.stiffness, time_s),
            ..*start
        }
    }
}

impl Plant {
    /// A flank that has moved may touch, or be left, where nothing else has moved.
    fn touch(&self, state: &mut PlantState) {
        let past = |side: Side| {
            side.sign() * (state.gap_angle - self.params.flank_at(side.sign(), state.load_position))
        };
        let contact = match state.mode.contact {
            Contact::Gap if past(Side::Positive) > 0.0 => Contact::Spring(Side::Positive),
            Contact::Gap if past(Side::Negative) > 0.0 => Contact::Spring(Side::Negative),
            Contact::Spring(side) | Contact::Doubled(side) | Contact::Lifted(side)
                if past(side) < 0.0 =>
            {
                Contact::Gap
            }
            same => same,
        };
        state.mode.contact = contact;
    }
}
