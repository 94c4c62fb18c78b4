//! From one offset of the motor to another.
//!
//! A planned rest-to-rest motion across the gap:
//! ```text
//! u = t/T_g,   offset = from + way (10 u^3 - 15 u^4 + 6 u^5)      no velocity and no acceleration at both ends
//! peak acceleration = 10/sqrt(3) way/T_g^2                        at u = 1/2 -+ sqrt(3)/6
//! T_g = sqrt(5.77 J_M way/torque)                                 from the torque that the drive may spend on it
//! ```
//! The quintic is the polynomial of least degree for these six end conditions; without a step of
//! acceleration at the start and at the landing it does not excite the shaft.
//!
//! The motor's current follows its setpoint late. Its loop, of period h, whose voltage comes d periods
//! late, is undone exactly:
//! ```text
//! i[k+1+d] = i[k+d] + h K_p/L (r[k] - i[k])      i: current, r: setpoint, A
//! r(t) = i(t) + L/K_p i'(t + (d + 1/2) h)
//! ```
//! The servo holds a torque over a tick, so it takes the mean of this over the coming tick. For a load that
//! the motor leaves on one flank and meets on the other the shaft carries, from the torque T that it
//! would carry without a gap, N m, and its stiffness k, N m/rad, on a way upwards:
//! ```text
//! min(0, T + k (offset - from)) + max(0, T - k (target - offset))
//! ```
//!
//! The methods of the commanded direction share the direction of a reference, and a ramp in a set
//! time:
//! ```text
//! u = t/T,   offset = from + (target - from) (3 u^2 - 2 u^3)      cubic smoothstep: at rest at both ends
//! ```
//! The velocity is continuous; the acceleration jumps by `6 (target - from)/T^2` at both ends.

use lostmotion_base::math;
use serde::{Deserialize, Serialize};

/// A traverse under way, or done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Traverse {
    from: f64,
    to: f64,
    /// Servo ticks since it began; below zero while only its torque is set, ahead of it.
    tick: f64,
    ticks: u32,
    /// Way of the motor over that of its offset.
    share: f64,
}

/// How the motor's current comes behind its setpoint, servo ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct CurrentLag {
    /// Time constant of the closed loop, L/K_p.
    pub(super) lag: f64,
    /// Delay of the voltage.
    pub(super) delay: f64,
    /// Half a period of the loop.
    pub(super) half_step: f64,
}

/// Offset of the motor (rad), its speed over the last tick (rad/s) and the acceleration whose torque is to
/// be set for the coming tick (rad/s2), as the servo takes them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Offset {
    pub(super) position: f64,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
}

/// Peak of the quintic's second derivative for a way and time of one: 10/sqrt(3). Derived.
const PEAK_ACCELERATION: f64 = 5.773_502_691_896_258;

/// Servo ticks of `period` s that a way (rad) takes within a peak acceleration (rad/s2), limited to
/// `least` and `most`.
pub(super) fn ticks_for(way: f64, acceleration: f64, period: f64, [least, most]: [u32; 2]) -> u32 {
    let time = (PEAK_ACCELERATION * way.abs() / acceleration).sqrt();
    // rounded up, so that the peak stays below the limit; a time that is not finite takes the most
    let ticks = (time / period).ceil();
    if ticks < f64::from(most) {
        (ticks as u32).max(least)
    } else {
        most
    }
}

/// Largest way of the motor over that of its offset. A choice: the torque of a traverse may be that much
/// more than it is laid out for.
const MOST_SHARE: f64 = 1.25;

impl Traverse {
    /// Starts from its present offset to another one, rad. Its torque is set from the next tick on, itself
    /// begins once all of that can arrive.
    pub(super) fn start(&mut self, to: f64, ticks: u32, current: &CurrentLag) {
        *self = Traverse {
            from: self.now(),
            to,
            tick: -1.0 - current.delay,
            ticks,
            share: 1.0,
        };
    }

    /// The motor has only this way to go, rad, since it has gone the rest by itself: the offset of its
    /// reference is as it was, speed and torque are less.
    pub(super) fn leave(&mut self, way: f64) {
        self.share = (way / (self.to - self.from)).clamp(0.0, MOST_SHARE);
    }

    /// Whether it has not arrived yet.
    #[inline(always)]
    pub(super) fn moving(&self) -> bool {
        self.tick < f64::from(self.ticks)
    }

    /// The way that is left, rad, and its servo ticks.
    #[inline(always)]
    pub(super) fn left(&self) -> (f64, f64) {
        (self.to - self.now(), f64::from(self.ticks) - self.tick)
    }

    /// Its present offset, rad.
    #[inline(always)]
    pub(super) fn now(&self) -> f64 {
        self.position(self.tick)
    }

    /// Advances by one tick of `period` s. The acceleration is that of the setpoint of the torque.
    #[inline(always)]
    pub(super) fn step(&mut self, current: &CurrentLag, period: f64) -> Offset {
        // a tick past its end all of its torque has been set
        let over = f64::from(self.ticks) + 1.0;
        if self.tick >= over {
            return Offset {
                position: self.to,
                ..Offset::default()
            };
        }
        let before = self.now();
        self.tick = (self.tick + 1.0).min(over);
        let (from, to) = (self.tick, self.tick + 1.0);
        let mean = self.velocity(to - current.half_step, period)
            - self.velocity(from - current.half_step, period);
        let rise = self.acceleration(to + current.delay, period)
            - self.acceleration(from + current.delay, period);
        // the velocity is the difference of positions, so that its sum is exactly the way
        let position = self.now();
        Offset {
            position,
            velocity: self.share * (position - before) / period,
            acceleration: self.share * (mean / period + current.lag * rise),
        }
    }

    /// Torque that the shaft carries some ticks ahead, if it would carry `torque` then without a gap, N m.
    pub(super) fn carried(&self, torque: f64, stiffness: f64, ahead: f64) -> f64 {
        let offset = self.position(self.tick + ahead);
        let left = torque + stiffness * (offset - self.from);
        let met = torque - stiffness * (self.to - offset);
        if self.to > self.from {
            left.min(0.0) + met.max(0.0)
        } else {
            left.max(0.0) + met.min(0.0)
        }
    }

    /// Part of its time, 0 to 1.
    #[inline(always)]
    fn part(&self, tick: f64) -> f64 {
        if tick < f64::from(self.ticks) {
            (tick / f64::from(self.ticks)).max(0.0)
        } else {
            1.0
        }
    }

    #[inline(always)]
    fn position(&self, tick: f64) -> f64 {
        let u = self.part(tick);
        // exactly there at its end
        if u < 1.0 {
            self.from + (self.to - self.from) * (u * u * u * (10.0 - u * (15.0 - 6.0 * u)))
        } else {
            self.to
        }
    }

    fn velocity(&self, tick: f64, period: f64) -> f64 {
        let u = self.part(tick);
        if u < 1.0 {
            let duration = f64::from(self.ticks) * period;
            (self.to - self.from) * 30.0 * u * u * (1.0 - u) * (1.0 - u) / duration
        } else {
            0.0
        }
    }

    fn acceleration(&self, tick: f64, period: f64) -> f64 {
        let u = self.part(tick);
        if u < 1.0 {
            let duration = f64::from(self.ticks) * period;
            (self.to - self.from) * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (duration * duration)
        } else {
            0.0
        }
    }
}

/// Speed up to which a reference counts as standing still, rad/s at the motor: far below any feed,
/// far above the rounding of an interpolated setpoint. A choice.
pub(super) const STANDING_RAD_S: f64 = 1e-6;

/// Commanded direction, -1 or 1. A standing reference keeps the one before: a rest is no reversal.
pub(super) fn direction(velocity: f64, before: i8) -> i8 {
    if velocity.abs() <= STANDING_RAD_S {
        before
    } else if velocity > 0.0 {
        1
    } else {
        -1
    }
}

/// Duration of a ramp.
#[derive(Clone, Copy, Debug)]
pub(super) struct RampTime {
    /// Part of the ramp in one tick, above 0 to 1.
    per_tick: f64,
}

impl RampTime {
    /// A ramp of `ms` in ticks of `period_s`; at least one tick.
    pub(super) fn from_ms(ms: f64, period_s: f64) -> RampTime {
        let ramp_s = ms * 1e-3;
        RampTime {
            per_tick: if ramp_s > period_s {
                period_s / ramp_s
            } else {
                1.0
            },
        }
    }
}

/// A ramp under way: where it started (rad) and the part of its time that has passed, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Ramp {
    from: f64,
    progress: f64,
}

impl Ramp {
    /// A ramp that has arrived.
    pub(super) const DONE: Ramp = Ramp {
        from: 0.0,
        progress: 1.0,
    };

    /// Starts again from this offset, rad.
    pub(super) fn start(&mut self, from: f64) {
        *self = Ramp {
            from,
            progress: 0.0,
        };
    }

    /// Advances by one tick.
    pub(super) fn advance(&mut self, time: RampTime) {
        self.progress = (self.progress + time.per_tick).min(1.0);
    }

    /// Whether it has arrived.
    pub(super) fn done(&self) -> bool {
        self.progress >= 1.0
    }

    /// Its offset on the way to a target in a straight line, rad.
    pub(super) fn straight_towards(&self, target: f64) -> f64 {
        self.along(target, self.progress)
    }

    /// Its offset on the way to a target along sin2 of a quarter turn, rad.
    pub(super) fn sin2_towards(&self, target: f64) -> f64 {
        let sine = math::sin(std::f64::consts::FRAC_PI_2 * self.progress);
        self.along(target, sine * sine)
    }

    /// Exactly the target where the whole way is done.
    fn along(&self, target: f64, part: f64) -> f64 {
        if self.done() {
            target
        } else {
            self.from + (target - self.from) * part
        }
    }

    /// Its offset on the way to a target, rad.
    pub(super) fn towards(&self, target: f64) -> f64 {
        let u = self.progress;
        self.from + (target - self.from) * (u * u * (3.0 - 2.0 * u))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_arrives_with_its_velocities_summing_to_the_way_and_its_peak_as_computed() {
        let (way, limit, period) = (4e-3, 4000.0, 250e-6);
        let ticks = ticks_for(way, limit, period, [1, 400]);
        let mut traverse = Traverse::default();
        traverse.start(way, ticks, &CurrentLag::default());
        let (mut sum, mut peak, mut last) = (0.0, 0.0_f64, Offset::default());
        while traverse.moving() {
            last = traverse.step(&CurrentLag::default(), period);
            sum += last.velocity * period;
            peak = peak.max(last.acceleration.abs());
        }
        assert!((last.position - way).abs() < 1e-15 && (sum - way).abs() < 1e-15);
        // the mean over a tick is a little below the peak itself, and the next whole tick makes the
        // way a little slower
        assert!(peak < limit && peak > 0.7 * limit, "{peak}");
        assert_eq!(
            traverse.step(&CurrentLag::default(), period),
            Offset {
                position: way,
                velocity: 0.0,
                acceleration: 0.0
            }
        );
    }

    #[test]
    fn a_motor_behind_its_current_loop_keeps_to_it() {
        // a loop of four periods a tick, 0.8 ticks slow, whose voltage comes a period late; a motor of 1 kg m2
        let (way, period, ticks) = (4e-3, 250e-6, 12);
        let current = CurrentLag {
            lag: 0.8,
            delay: 0.25,
            half_step: 0.125,
        };
        let step = 0.25 * period;
        let mut traverse = Traverse::default();
        traverse.start(way, ticks, &current);
        let (mut torque, mut rise, mut speed, mut angle) = (0.0, 0.0, 0.0, 0.0);
        let mut most = 0.0_f64;
        for _ in 0..ticks + 4 {
            let set = traverse.step(&current, period);
            most = most.max((angle - set.position).abs());
            for _ in 0..4 {
                let before = torque;
                torque += rise;
                rise = 0.25 / current.lag * (set.acceleration - before);
                // the torque runs straight from sample to sample
                let mean = 0.5 * (before + torque);
                angle += step * (speed + 0.5 * step * mean);
                speed += step * mean;
            }
        }
        assert!(most < 0.01 * way, "{most}");
        assert!(
            (angle - way).abs() < 0.001 * way && speed.abs() < 1e-2,
            "{angle} {speed}"
        );
    }

    #[test]
    fn the_shaft_lets_go_of_one_flank_before_it_meets_the_other() {
        let mut traverse = Traverse::default();
        traverse.start(-1e-3, 1, &CurrentLag::default());
        traverse = Traverse {
            tick: 0.0,
            ticks: 10,
            from: 1e-3,
            ..traverse
        };
        // wound up by a tenth of the gap, it is let go once the motor has gone that far
        assert_eq!(traverse.carried(0.2, 1000.0, 0.0), 0.2);
        assert_eq!(traverse.carried(0.2, 1000.0, 5.0), 0.0);
        assert_eq!(traverse.carried(-0.2, 1000.0, 5.0), 0.0);
        assert_eq!(traverse.carried(-0.2, 1000.0, 10.0), -0.2);
    }

    #[test]
    fn its_time_follows_from_the_torque() {
        // 100 ms at 5.77 way/T^2
        let acceleration = 10.0 / 3.0_f64.sqrt() * 0.01 / 0.01;
        assert_eq!(
            ticks_for(0.01, acceleration * (1.0 + 1e-12), 250e-6, [1, 1000]),
            400
        );
        assert_eq!(ticks_for(0.01, 1e9, 250e-6, [12, 400]), 12);
        assert_eq!(ticks_for(0.01, 0.0, 250e-6, [12, 400]), 400);
    }
}
