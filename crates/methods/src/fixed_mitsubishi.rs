//! Half of an amount towards the commanded direction, the amount by the acceleration at the
//! reversal: up to four pairs, linear between them.
//!
//! ```text
//! s         sign of w_ref; |w_ref| <= 1e-6 rad/s keeps the last one
//! a         |acceleration of the reference| at the tick of the reversal
//! p(a)      part of the gap: linear between the four pairs, constant beyond the first and the last
//! position  from its present value to s p(a) b, rad, along 3 u^2 - 2 u^3 over the ramp time
//! velocity  derivative of the position correction, rad/s
//! ```
//! With all parts at 1 it is `fixed`.
//!
//! Signals: reference velocity and acceleration. Settings: told total gap (um, mdeg or motor rad),
//! four accelerations (axis unit per s2) with their parts of the gap, ramp time (ms).
//!
//! Fails: as `fixed`. What a faster reversal needs more or less than the gap has to be measured for
//! each acceleration.
//!
//! Source: Mitsubishi M80, backlash compensation II (IB-1501269). The curve in time is not
//! published.

use crate::AxisConfig;
use crate::registry::{Registered, Settings, told, told_or_true_gap};
use crate::traverse::{Ramp, RampTime, direction};
use lostmotion_drive::config::check::{AxisConfigError, between, not_negative};
use lostmotion_drive::config::{Gap, Transmission};
use lostmotion_drive::signal::Engagement;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `fixed-mitsubishi`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FixedMitsubishiSettings {
    /// Total gap that the control was told; the machine's true gap if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<Gap>,
    /// Accelerations at the reversal, rising: mm, deg or rad per s2.
    pub acceleration_units_s2: [f64; 4],
    /// Part of the gap that is corrected at each of them, 0 to 10.
    pub part: [f64; 4],
    /// Time over which the correction goes from one side to the other, ms.
    pub ramp_ms: f64,
}

impl Default for FixedMitsubishiSettings {
    fn default() -> FixedMitsubishiSettings {
        FixedMitsubishiSettings {
            gap: None,
            acceleration_units_s2: [0.0; 4],
            part: [1.0; 4],
            ramp_ms: 8.0,
        }
    }
}

impl Settings for FixedMitsubishiSettings {
    fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        told("gap", self.gap, transmission)?;
        let mut least = 0.0;
        for acceleration in self.acceleration_units_s2 {
            not_negative("acceleration_units_s2", acceleration)?;
            // Rising, or all alike where nothing depends on it.
            between("acceleration_units_s2", acceleration, least, f64::MAX)?;
            least = acceleration;
        }
        for part in self.part {
            between("part", part, 0.0, 10.0)?;
        }
        between("ramp_ms", self.ramp_ms, 0.0, 10_000.0)
    }

    fn gaps(&mut self) -> Vec<&mut Option<Gap>> {
        vec![&mut self.gap]
    }
}

/// The method `fixed-mitsubishi`.
#[derive(Clone, Copy, Debug)]
pub struct FixedMitsubishi {
    /// Half of the told gap, rad at the motor.
    half_gap: f64,
    /// rad/s2 at the motor.
    accelerations: [f64; 4],
    parts: [f64; 4],
    time: RampTime,
    period_s: f64,
}

/// Commanded direction, where the correction goes (rad), and where it is on its way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixedMitsubishiState {
    direction: i8,
    target: f64,
    ramp: Ramp,
}

impl Registered for FixedMitsubishi {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "fixed-mitsubishi",
        summary: "known half gap added at each reversal, more or less of it by the acceleration there",
        knows: Knowledge {
            load_scale: false,
            gap: true,
            load: false,
        },
        source: "Mitsubishi, backlash compensation II",
    };

    fn from_axis(config: &AxisConfig) -> FixedMitsubishi {
        let settings = &config.compensation.fixed_mitsubishi;
        let per_unit = config.transmission.motor_rad_per_unit();
        let period_s = config.servo_period_s();
        FixedMitsubishi {
            half_gap: 0.5 * told_or_true_gap(settings.gap, config),
            accelerations: settings.acceleration_units_s2.map(|value| value * per_unit),
            parts: settings.part,
            time: RampTime::from_ms(settings.ramp_ms, period_s),
            period_s,
        }
    }
}

impl FixedMitsubishi {
    /// Part of the gap at an acceleration.
    fn part(&self, acceleration: f64) -> f64 {
        let mut part = self.parts[0];
        for n in 1..4 {
            let [from, to] = [self.accelerations[n - 1], self.accelerations[n]];
            if acceleration < from {
                break;
            }
            let u = if to > from {
                ((acceleration - from) / (to - from)).min(1.0)
            } else {
                1.0
            };
            part = self.parts[n - 1] + (self.parts[n] - self.parts[n - 1]) * u;
        }
        part
    }
}

impl Compensator for FixedMitsubishi {
    type State = FixedMitsubishiState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) -> FixedMitsubishiState {
        FixedMitsubishiState {
            direction: 0,
            target: 0.0,
            ramp: Ramp::DONE,
        }
    }

    #[inline]
    fn step(&self, state: &mut FixedMitsubishiState, signals: &Signals) -> Correction {
        let before = state.ramp.towards(state.target);
        let direction = direction(signals.reference.velocity, state.direction);
        if direction != state.direction {
            state.direction = direction;
            let part = self.part(signals.reference.acceleration.abs());
            state.target = f64::from(direction) * part * self.half_gap;
            state.ramp.start(before);
        }
        state.ramp.advance(self.time);
        let position = state.ramp.towards(state.target);
        Correction {
            position,
            velocity: (position - before) / self.period_s,
            gap_angle_estimate: state.target,
            engagement_estimate: Engagement::of_sign(direction),
            ..Correction::NONE
        }
    }
}
