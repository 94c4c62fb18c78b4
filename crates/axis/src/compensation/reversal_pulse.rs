//! A pulse at each reversal: extra speed for a short time that pushes the motor across the gap.
//!
//! ```text
//! at each change of sign of w_ref (|w_ref| <= 1e-6 rad/s keeps it), after the set delay:
//! direction * a (1 - t/T) for 0 <= t < T is added to the velocity reference
//! ```
//! Nothing holds the motor there afterwards: the position loop does not know of the gap and pulls it back. It shortens the time in which
//! the load stands still after a reversal; the offset of half a gap stays.
//!
//! Signals: reference velocity, rad/s. Tunables: speed a (rad/s at the motor; if left out, so much that the pulse's area is the true gap), time T
//! (ms), delay (ms). It knows the gap where the speed is left out. The same pulse put on the torque landed the motor so hard that peaks grew;
//! it is not offered.
//! Fails: too strong, it makes a notch of the opposite sign; right at one feed and friction, it is wrong at others; on a load without friction it
//! pushes at the wrong time.
//! Source: common practice: backlash acceleration of Fanuc (servo function), stick-slip or friction injection pulse of Siemens and Heidenhain.

use super::registry::Registered;
use super::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use crate::config::AxisConfig;
use lostmotion_base::Clock;
use serde::{Deserialize, Serialize};

/// A reference slower than this keeps the direction, rad/s.
const STANDING_RAD_S: f64 = 1e-6;

/// The method `reversal-pulse`.
#[derive(Clone, Copy, Debug)]
pub struct ReversalPulse {
    speed: f64,
    ticks: f64,
    delay: f64,
}

/// Direction of the motion, and ticks since it changed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReversalPulseState {
    direction: i8,
    since: f64,
}

impl Registered for ReversalPulse {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "reversal-pulse",
        summary: "a short pulse of speed at each reversal of the commanded velocity",
        knows: Knowledge { load_scale: false, gap: true, load: false },
        source: "common practice: Fanuc backlash acceleration, Siemens and Heidenhain friction pulse",
    };

    fn from_axis(config: &AxisConfig) -> ReversalPulse {
        let settings = &config.compensation.reversal_pulse;
        let per_ms = 1e-3 / Clock::SERVO.period_s();
        let gap = config.reflected_load().gap_rad;
        ReversalPulse {
            // a triangle of the gap's area
            speed: settings.speed_rad_s.unwrap_or(2.0 * gap / (settings.time_ms * 1e-3)),
            ticks: settings.time_ms * per_ms,
            delay: settings.delay_ms * per_ms,
        }
    }
}

impl Compensator for ReversalPulse {
    type State = ReversalPulseState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) -> ReversalPulseState {
        ReversalPulseState { direction: 0, since: self.delay + self.ticks }
    }

    #[inline]
    fn step(&self, state: &mut ReversalPulseState, signals: &Signals) -> Correction {
        let velocity = signals.reference.velocity;
        let direction = if velocity > 0.0 { 1 } else { -1 };
        if velocity.abs() > STANDING_RAD_S && direction != state.direction {
            *state = ReversalPulseState { direction, since: 0.0 };
        }
        let u = (state.since - self.delay) / self.ticks;
        state.since = (state.since + 1.0).min(self.delay + self.ticks);
        if !(0.0..1.0).contains(&u) {
            return Correction::NONE;
        }
        let shape = f64::from(state.direction) * (1.0 - u);
        Correction { velocity: self.speed * shape, ..Correction::NONE }
    }
}
