//! A cheap look whether a step can have met an event at all.
//!
//! Nearly every step meets none. The look may only err towards "perhaps"; [`super::Plant::step`]
//! then searches in earnest.

use super::dynamics::{Held, LOAD, MOTOR, PENETRATION, Vector};
use super::mode::{Contact, Friction, Mass, Mode};
use super::params::PlantParams;
use crate::config::ContactLaw;

/// How far a quantity can dip within a step between two ends that are alike.
#[derive(Clone, Copy, Debug)]
pub(super) struct Margins {
    speed: f64,
    /// Speeds at which motor and load begin to creep.
    slow: [f64; 2],
    torque: f64,
    third: f64,
}

impl Margins {
    /// From the largest acceleration that the drive's current can cause: a dip is at most h^2/8 of
    /// the second derivative.
    pub(super) fn new(params: &PlantParams) -> Margins {
        let inertia = params.motor_inertia_kgm2.min(params.load_inertia_kgm2);
        let acceleration = 2.0 * params.torque_constant_nm_per_a * params.current_limit_a / inertia;
        let dip = params.period_s * params.period_s / 8.0 * acceleration;
        let rate = params.rate();
        let damping = params.damping_nm_s_per_rad * rate;
        let slow = [
            params.motor_friction.slow_rad_s(),
            params.load_friction.slow_rad_s(),
        ];
        Margins {
            slow,
            speed: dip * rate,
            torque: dip * (params.stiffness_nm_per_rad + damping),
            third: params.period_s / 3.0,
        }
    }

    /// Dip of a speed, rad/s.
    pub(super) fn speed(&self) -> f64 {
        self.speed
    }

    /// Dip of a torque, N m.
    pub(super) fn torque(&self) -> f64 {
        self.torque
    }

    /// A third of the step, s.
    pub(super) fn third(&self) -> f64 {
        self.third
    }

    /// Whether no guard of the mode can have become negative between two ends of a step.
    #[inline]
    pub(super) fn quiet(
        &self,
        params: &PlantParams,
        mode: Mode,
        held: &Held,
        before: &Vector,
        after: &Vector,
    ) -> bool {
        self.contact(params, mode, before, after)
            && self.friction(
                params,
                Mass::Motor,
                mode.motor,
                [before[MOTOR], after[MOTOR]],
                || {
                    (
                        params.motor_need(mode, before),
                        params.motor_need(mode, after),
                    )
                },
            )
            && self.friction(
                params,
                Mass::Load,
                mode.load,
                [before[LOAD], after[LOAD]],
                || {
                    (
                        params.load_need(mode, before, held),
                        params.load_need(mode, after, held),
                    )
                },
            )
    }

    #[inline]
    fn contact(&self, params: &PlantParams, mode: Mode, before: &Vector, after: &Vector) -> bool {
        // Bernstein's coefficients of the cubic through both ends with the slopes there
        let slope = |x: &Vector| (x[MOTOR] - x[LOAD]) * self.third;
        let inner = [
            before[PENETRATION] + slope(before),
            after[PENETRATION] - slope(after),
        ];
        match mode.contact {
            Contact::Rigid => true,
            Contact::Gap => {
                let b = params.half_gap_rad;
                before[PENETRATION].abs() <= b
                    && after[PENETRATION].abs() <= b
                    && inner[0].abs() <= b
                    && inner[1].abs() <= b
            }
            Contact::Spring(side) => {
                let s = side.sign();
                let deep = s * before[PENETRATION] >= 0.0
                    && s * after[PENETRATION] >= 0.0
                    && s * inner[0] >= 0.0
                    && s * inner[1] >= 0.0;
                deep && (params.contact == ContactLaw::Linear
                    || self.pushing(params, s, before, after))
            }
            Contact::Doubled(_) | Contact::Lifted(_) => false,
        }
    }

    /// Whether spring exceeds damping by far at both ends, so that a clamped or bounded contact
    /// stays as it is.
    fn pushing(&self, params: &PlantParams, sign: f64, before: &Vector, after: &Vector) -> bool {
        let spare = |x: &Vector| {
            params.stiffness_nm_per_rad * sign * x[PENETRATION]
                - params.damping_nm_s_per_rad * (x[MOTOR] - x[LOAD]).abs()
        };
        let (a, b) = (spare(before), spare(after));
        a.min(b) > (a - b).abs() + self.torque
    }

    #[inline]
    fn friction(
        &self,
        params: &PlantParams,
        mass: Mass,
        state: Friction,
        speed: [f64; 2],
        need: impl FnOnce() -> (f64, f64),
    ) -> bool {
        let [before, after] = speed;
        let spare = (after - before).abs() + self.speed;
        match state {
            Friction::None => true,
            Friction::Sliding(side) => {
                let s = side.sign();
                (s * before).min(s * after) > spare + self.slow[mass as usize]
            }
            Friction::Creeping(side) => {
                let s = side.sign();
                (s * before).min(s * after) > spare
                    && (s * before).max(s * after) + spare < params.friction(mass).speed_rad_s
            }
            Friction::Bristles(_) => false,
            Friction::Stuck => {
                let ((a, b), limit) = (need(), params.breakaway(mass));
                a.abs().max(b.abs()) + (a - b).abs() + self.torque < limit
                    || a == b && a.abs() < limit
            }
        }
    }
}
