//! Half the gap, known beforehand, towards the direction of the commanded velocity: what controls
//! have done for decades.
//!
//! ```text
//! s         sign of w_ref; |w_ref| <= 1e-6 rad/s keeps the last one
//! position  from its present value to s b, rad, along 3 u^2 - 2 u^3 over the ramp time; b: half gap, rad
//! velocity  derivative of the position correction, rad/s
//! ```
//! Signals: reference velocity, rad/s. Settings: told total gap (um, mdeg or motor rad), ramp time
//! (ms).
//!
//! Fails: where the load does not follow the commanded direction. A load without friction coasts
//! through the reversal and changes flank where the acceleration changes sign, so the correction
//! comes about a quarter of a period off. An error of the told gap stays in full. While the load
//! still rests, the ramp itself is an error.
//!
//! Source: common practice, a machine parameter for the backlash and one for the time of take-up
//! (Heidenhain iTNC: MP 710 and MP 752; the curve that it follows is not published); Kao et al. as
//! cited by Gan, Wang, Huang (2023). With limits of velocity and acceleration: `fixed-linuxcnc`;
//! with two amounts: `fixed-fanuc`.

use crate::AxisConfig;
use crate::registry::{Registered, Settings, told, told_or_true_gap};
use crate::traverse::{Ramp, RampTime, direction};
use lostmotion_drive::config::check::{AxisConfigError, between};
use lostmotion_drive::config::{Gap, Transmission};
use lostmotion_drive::signal::Engagement;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `fixed`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FixedSettings {
    /// Total gap that the control was told; the machine's true gap if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<Gap>,
    /// Time over which the correction goes from one side to the other, ms.
    pub ramp_ms: f64,
}

impl Default for FixedSettings {
    fn default() -> FixedSettings {
        FixedSettings {
            gap: None,
            ramp_ms: 15.0,
        }
    }
}

impl Settings for FixedSettings {
    fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        told("gap", self.gap, transmission)?;
        between("ramp_ms", self.ramp_ms, 0.0, 10_000.0)
    }

    fn gaps(&mut self) -> Vec<&mut Option<Gap>> {
        vec![&mut self.gap]
    }
}

/// The method `fixed`.
#[derive(Clone, Copy, Debug)]
pub struct Fixed {
    /// Half of the told gap, rad at the motor.
    half_gap: f64,
    time: RampTime,
    period_s: f64,
}

/// Commanded direction, and the correction's ramp from one side to the other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixedState {
    direction: i8,
    ramp: Ramp,
}

impl Registered for Fixed {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "fixed",
        summary: "known half gap added at each reversal of the commanded velocity, with a ramp",
        knows: Knowledge {
            load_scale: false,
            gap: true,
            load: false,
        },
        source: "common practice: Heidenhain and others",
    };

    fn from_axis(config: &AxisConfig) -> Fixed {
        let settings = &config.compensation.fixed;
        let gap = told_or_true_gap(settings.gap, config);
        let period_s = config.servo_period_s();
        Fixed {
            half_gap: 0.5 * gap,
            time: RampTime::from_ms(settings.ramp_ms, period_s),
            period_s,
        }
    }
}

impl Compensator for Fixed {
    type State = FixedState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) -> FixedState {
        FixedState {
            direction: 0,
            ramp: Ramp::DONE,
        }
    }

    #[inline]
    fn step(&self, state: &mut FixedState, signals: &Signals) -> Correction {
        let before = self.position(state);
        let direction = direction(signals.reference.velocity, state.direction);
        // a reversal within a ramp starts anew from the present offset: no step of the position
        if direction != state.direction {
            state.direction = direction;
            state.ramp.start(before);
        }
        state.ramp.advance(self.time);
        // difference over the tick, so that velocity and position correction agree exactly
        let position = self.position(state);
        Correction {
            position,
            velocity: (position - before) / self.period_s,
            gap_angle_estimate: f64::from(state.direction) * self.half_gap,
            engagement_estimate: Engagement::of_sign(state.direction),
            ..Correction::NONE
        }
    }
}

impl Fixed {
    fn position(&self, state: &FixedState) -> f64 {
        state
            .ramp
            .towards(f64::from(state.direction) * self.half_gap)
    }
}
