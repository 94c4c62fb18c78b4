//! Steps that the methods of the commanded direction share: the direction of a reference, and a
//! ramp from one offset to another in a set time.
//!
//! ```text
//! u = t/T,   offset = from + (target - from) (3 u^2 - 2 u^3)      cubic smoothstep: at rest at both ends
//! ```
//! The velocity is continuous; the acceleration jumps by `6 (target - from)/T^2` at both ends.

use serde::{Deserialize, Serialize};

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

    /// Its offset on the way to a target, rad.
    pub(super) fn towards(&self, target: f64) -> f64 {
        let u = self.progress;
        self.from + (target - self.from) * (u * u * (3.0 - 2.0 * u))
    }
}
