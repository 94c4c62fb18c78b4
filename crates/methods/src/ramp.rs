//! A way from one offset to another within a set time: `3 u^2 - 2 u^3`, at rest at both ends. And
//! the direction of a reference.

use serde::{Deserialize, Serialize};

/// A reference slower than this keeps the direction, rad/s.
pub(super) const STANDING_RAD_S: f64 = 1e-6;

/// Direction of a reference that moves, the one before if it stands.
pub(super) fn direction(velocity: f64, before: i8) -> i8 {
    if velocity.abs() <= STANDING_RAD_S {
        before
    } else if velocity > 0.0 {
        1
    } else {
        -1
    }
}

/// How fast a ramp goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct RampTime {
    per_tick: f64,
}

impl RampTime {
    /// A ramp of so many ms in ticks of `period_s`; a single tick if it is shorter than that.
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

/// Where a ramp is on its way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Ramp {
    from: f64,
    progress: f64,
}

impl Ramp {
    /// Arrived.
    pub(super) const DONE: Ramp = Ramp {
        from: 0.0,
        progress: 1.0,
    };

    /// Sets out from here.
    pub(super) fn start(&mut self, from: f64) {
        *self = Ramp {
            from,
            progress: 0.0,
        };
    }

    /// One tick on.
    pub(super) fn advance(&mut self, time: RampTime) {
        self.progress = (self.progress + time.per_tick).min(1.0);
    }

    /// Whether it has arrived.
    pub(super) fn done(&self) -> bool {
        self.progress >= 1.0
    }

    /// Where it is on its way to a target, rad.
    pub(super) fn towards(&self, target: f64) -> f64 {
        let u = self.progress;
        self.from + (target - self.from) * (u * u * (3.0 - 2.0 * u))
    }
}
