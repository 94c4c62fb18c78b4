//! Half the gap towards the commanded direction along sin2 over a number of the control's cycles.
//!
//! ```text
//! s         sign of w_ref; |w_ref| <= 1e-6 rad/s keeps the last one
//! position  from its present value to s b, rad, along sin2(pi t/(2 T)); T: cycles times the command's cycle
//! velocity  derivative of the position correction, rad/s
//! ```
//! One cycle is abrupt.
//!
//! Signals: reference velocity, rad/s. Settings: told total gap (um, mdeg or motor rad), cycles.
//!
//! Fails: as `fixed`; the curve differs from its cubic by one hundredth of the gap at most.
//!
//! Source: ISG kernel (Beckhoff TwinCAT CNC and others), P-AXIS-00103 over the cycles of P-AXIS-00243
//! along sin2, 0 and 1 abrupt; P-AXIS-00021 says on which side it begins.

use crate::AxisConfig;
use crate::registry::{Registered, Settings, told, told_or_true_gap};
use crate::traverse::{Ramp, RampTime, direction};
use lostmotion_drive::config::check::{AxisConfigError, between};
use lostmotion_drive::config::{Gap, Transmission};
use lostmotion_drive::signal::Engagement;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `fixed-isg`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FixedIsgSettings {
    /// Total gap that the control was told (P-AXIS-00103); the machine's true gap if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<Gap>,
    /// Command cycles over which the correction goes from one side to the other (P-AXIS-00243); 1
    /// is abrupt.
    pub cycles: u32,
}

impl Default for FixedIsgSettings {
    fn default() -> FixedIsgSettings {
        FixedIsgSettings {
            gap: None,
            cycles: 10,
        }
    }
}

impl Settings for FixedIsgSettings {
    fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        told("gap", self.gap, transmission)?;
        between("cycles", f64::from(self.cycles), 1.0, 100.0)
    }

    fn gaps(&mut self) -> Vec<&mut Option<Gap>> {
        vec![&mut self.gap]
    }
}

/// The method `fixed-isg`.
#[derive(Clone, Copy, Debug)]
pub struct FixedIsg {
    /// Half of the told gap, rad at the motor.
    half_gap: f64,
    time: RampTime,
    period_s: f64,
}

/// Commanded direction, and the correction on its way from one side to the other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixedIsgState {
    direction: i8,
    ramp: Ramp,
}

impl Registered for FixedIsg {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "fixed-isg",
        summary: "known half gap added at each reversal, along sin2 over a number of command cycles",
        knows: Knowledge {
            load_scale: false,
            gap: true,
            load: false,
        },
        source: "ISG kernel and Beckhoff, P-AXIS-00103 and P-AXIS-00243",
    };

    fn from_axis(config: &AxisConfig) -> FixedIsg {
        let settings = &config.compensation.fixed_isg;
        let period_s = config.servo_period_s();
        let cycle_ms = config.cycles.servo_ticks() as f64 * period_s * 1e3;
        let ms = if settings.cycles > 1 {
            f64::from(settings.cycles) * cycle_ms
        } else {
            0.0
        };
        FixedIsg {
            half_gap: 0.5 * told_or_true_gap(settings.gap, config),
            time: RampTime::from_ms(ms, period_s),
            period_s,
        }
    }
}

impl FixedIsg {
    fn position(&self, state: &FixedIsgState) -> f64 {
        let target = f64::from(state.direction) * self.half_gap;
        state.ramp.sin2_towards(target)
    }
}

impl Compensator for FixedIsg {
    type State = FixedIsgState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) -> FixedIsgState {
        FixedIsgState {
            direction: 0,
            ramp: Ramp::DONE,
        }
    }

    #[inline]
    fn step(&self, state: &mut FixedIsgState, signals: &Signals) -> Correction {
        let before = self.position(state);
        let direction = direction(signals.reference.velocity, state.direction);
        if direction != state.direction {
            state.direction = direction;
            state.ramp.start(before);
        }
        state.ramp.advance(self.time);
        let position = self.position(state);
        Correction {
            position,
            velocity: (position - before) / self.period_s,
            gap_angle_estimate: f64::from(direction) * self.half_gap,
            engagement_estimate: Engagement::of_sign(direction),
            ..Correction::NONE
        }
    }
}
