//! A pulse at each reversal: extra velocity or torque for a short time that pushes the motor across
//! the gap.
//!
//! ```text
//! after each change of sign of w_ref (|w_ref| <= 1e-6 rad/s keeps it) and the set delay, for 0 <= t < T:
//! velocity  s a (1 - t/T), rad/s        torque  s m (1 - t/T), N m        s: commanded direction
//! a left out and no torque given: a T/2 = 2 b, the pulse's area is the total gap
//! ```
//! Nothing holds the motor there afterwards: the position loop does not know of the gap and pulls
//! it back. The pulse shortens the time in which the load stands still after a reversal; the offset
//! of half a gap stays. Against the velocity loop a torque pulse works only while it is shorter
//! than the loop's own time (about 1/(2 pi f_v)), and it lands the motor hard.
//!
//! Signals: reference velocity, rad/s. Settings: speed a (rad/s at the motor), torque m (N m), time
//! T (ms), delay (ms). It knows the gap where neither speed nor torque is given.
//!
//! Fails: too strong, it makes a notch of the opposite sign; right at one feed and friction, it is
//! wrong at others; on a load without friction it pushes at the wrong time.
//!
//! Source: common practice, backlash acceleration of Fanuc (servo function), stick-slip or friction
//! injection pulse of Siemens and Heidenhain.

use crate::AxisConfig;
use crate::registry::{Registered, Settings};
use crate::traverse::direction;
use lostmotion_drive::config::Transmission;
use lostmotion_drive::config::check::{AxisConfigError, between, not_negative};
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `reversal-pulse`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ReversalPulseSettings {
    /// Speed at the start of the pulse, rad/s at the motor. If left out, the pulse's area is the
    /// machine's true gap, or there is no velocity pulse where a torque is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_rad_s: Option<f64>,
    /// Torque at the start of the pulse, N m; no torque if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_nm: Option<f64>,
    /// Time in which it falls to zero, ms.
    pub time_ms: f64,
    /// From the reversal of the reference to the pulse, ms.
    pub delay_ms: f64,
}

impl Default for ReversalPulseSettings {
    fn default() -> ReversalPulseSettings {
        ReversalPulseSettings {
            speed_rad_s: None,
            torque_nm: None,
            time_ms: 20.0,
            delay_ms: 0.0,
        }
    }
}

impl Settings for ReversalPulseSettings {
    fn check(&self, _transmission: &Transmission) -> Result<(), AxisConfigError> {
        not_negative("speed_rad_s", self.speed_rad_s.unwrap_or(0.0))?;
        not_negative("torque_nm", self.torque_nm.unwrap_or(0.0))?;
        between("time_ms", self.time_ms, 0.25, 1000.0)?;
        between("delay_ms", self.delay_ms, 0.0, 1000.0)
    }
}

/// The method `reversal-pulse`.
#[derive(Clone, Copy, Debug)]
pub struct ReversalPulse {
    /// Height of the velocity pulse, rad/s.
    speed: f64,
    /// Height of the torque pulse, N m.
    torque: f64,
    /// Length of the pulse, servo ticks.
    ticks: f64,
    /// From the reversal to the pulse, servo ticks.
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
        summary: "a short pulse of speed or torque at each reversal of the commanded velocity",
        knows: Knowledge {
            load_scale: false,
            gap: true,
            load: false,
        },
        source: "common practice: Fanuc backlash acceleration, Siemens and Heidenhain friction pulse",
    };

    fn from_axis(config: &AxisConfig) -> ReversalPulse {
        let settings = &config.compensation.reversal_pulse;
        let per_ms = 1e-3 / config.servo_period_s();
        // a triangle whose area is the total gap
        let of_gap = 2.0 * config.reflected_load().gap_rad / (settings.time_ms * 1e-3);
        ReversalPulse {
            speed: settings
                .speed_rad_s
                .unwrap_or(if settings.torque_nm.is_none() {
                    of_gap
                } else {
                    0.0
                }),
            torque: settings.torque_nm.unwrap_or(0.0),
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
        ReversalPulseState {
            direction: 0,
            // no pulse before the first reversal
            since: self.delay + self.ticks,
        }
    }

    #[inline]
    fn step(&self, state: &mut ReversalPulseState, signals: &Signals) -> Correction {
        let direction = direction(signals.reference.velocity, state.direction);
        if direction != state.direction {
            *state = ReversalPulseState {
                direction,
                since: 0.0,
            };
        }
        // part of the pulse that has passed: below 0 in the delay, 1 and more behind it
        let u = (state.since - self.delay) / self.ticks;
        state.since = (state.since + 1.0).min(self.delay + self.ticks);
        if !(0.0..1.0).contains(&u) {
            return Correction::NONE;
        }
        // falling triangle in the commanded direction
        let shape = f64::from(state.direction) * (1.0 - u);
        Correction {
            velocity: self.speed * shape,
            torque: self.torque * shape,
            ..Correction::NONE
        }
    }
}
