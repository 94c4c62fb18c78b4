//! A cheap look whether a step can have met an event at all.
//!
//! Nearly every step meets none. The look may only err towards "perhaps"; [`super::Plant::step`]
//! then searches in earnest.

use super::dynamics::{Held, LOAD, MOTOR, PENETRATION, Vector};
use super::mode::{Contact, Friction, Mass, Mode};
use super::params::PlantParams;
use crate::config::ContactLaw;
use crate::number::Number;

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
        // the lighter mass is the one that accelerates most
        let inertia = params.motor_inertia_kgm2.min(params.load_inertia_kgm2);
        let acceleration = 2.0 * params.torque_constant_nm_per_a * params.current_limit_a / inertia;
        let dip = params.period_s * params.period_s / 8.0 * acceleration;
        let rate = params.rate();
        // second derivatives: of a speed the jerk, at most `rate` times the acceleration; of the
        // shaft's torque k times the acceleration and d times the jerk
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
        // torques are computed only for a mass that stands
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
        let within = |range| stays_within(range, self.third, before, after);
        match mode.contact {
            Contact::Rigid => true,
            Contact::Gap => within([-params.half_gap_rad, params.half_gap_rad]),
            Contact::Spring(side) => {
                let s = side.sign();
                let flank = if s > 0.0 {
                    [0.0, f64::INFINITY]
                } else {
                    [f64::NEG_INFINITY, 0.0]
                };
                within(flank)
                    && (params.contact == ContactLaw::Linear
                        || keeps_pushing(
                            params.stiffness_nm_per_rad * s,
                            params.damping_nm_s_per_rad,
                            self.torque,
                            before,
                            after,
                        ))
            }
            // no cheap look for these: always searched in earnest
            Contact::Doubled(_) | Contact::Lifted(_) => false,
        }
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
        match state {
            Friction::None => true,
            Friction::Sliding(side) => {
                keeps_sliding(side.sign(), self.speed + self.slow[mass as usize], speed)
            }
            // between rest and the speed at which creeping ends
            Friction::Creeping(side) => {
                let (s, spare) = (side.sign(), (after - before).abs() + self.speed);
                keeps_sliding(s, self.speed, speed)
                    && (s * before).max(s * after) + spare < params.friction(mass).speed_rad_s
            }
            // a plant with bristles takes its steps as series
            Friction::Bristles(_) => false,
            Friction::Stuck => {
                let (before, after) = need();
                keeps_standing(params.breakaway(mass), self.torque, before, after)
            }
        }
    }
}

/// Whether the penetration stays in a range over a step: the four coefficients in Bernstein's form
/// of the cubic through both ends with the slopes there do, and the cubic lies between them.
#[inline(always)]
pub(crate) fn stays_within<N: Number>(
    [low, high]: [N; 2],
    third: N,
    before: &[N; 4],
    after: &[N; 4],
) -> N::Mask {
    let inside = |x: N| low.at_most(x) & x.at_most(high);
    let slope = |x: &[N; 4]| (x[MOTOR] - x[LOAD]) * third;
    let ends = inside(before[PENETRATION]) & inside(after[PENETRATION]);
    ends & (inside(before[PENETRATION] + slope(before)) & inside(after[PENETRATION] - slope(after)))
}

/// Whether the spring exceeds the damper by far at both ends of a step, so that a contact that may
/// not pull stays as it is. `stiffness` has the flank's sign.
#[inline(always)]
pub(crate) fn keeps_pushing<N: Number>(
    stiffness: N,
    damping: N,
    margin: N,
    before: &[N; 4],
    after: &[N; 4],
) -> N::Mask {
    let spare = |x: &[N; 4]| stiffness * x[PENETRATION] - damping * (x[MOTOR] - x[LOAD]).abs();
    let (a, b) = (spare(before), spare(after));
    let least = (a - b).abs() + margin;
    least.less(a) & least.less(b)
}

/// Whether a mass that slides in the direction of `sign` comes near to rest at neither end of a
/// step, by more than its speed changes.
#[inline(always)]
pub(crate) fn keeps_sliding<N: Number>(sign: N, margin: N, [from, to]: [N; 2]) -> N::Mask {
    let least = (to - from).abs() + margin;
    least.less(sign * from) & least.less(sign * to)
}

/// Whether friction up to `limit` holds a mass through a step against the torque on it at the
/// step's ends, by more than that torque changes. Where it does not change no margin is asked for.
#[inline(always)]
pub(crate) fn keeps_standing<N: Number>(limit: N, margin: N, before: N, after: N) -> N::Mask {
    let (size, then, change) = (before.abs(), after.abs(), (before - after).abs());
    let clear = |size: N| (size + change + margin).less(limit);
    (clear(size) & clear(then)) | (before.equals(after) & size.less(limit))
}
