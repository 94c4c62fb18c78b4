//! Half the gap taken off the measured position, so that the position loop itself moves the motor
//! across: the backlash parameter of controls that correct the actual value.
//!
//! ```text
//! s         sign of w_ref; |w_ref| <= 1e-6 rad/s keeps the last one
//! offset    from its present value to s b, rad: at once, or along a straight line over a time
//! feedback  offset, subtracted from the measured motor position before the position loop sees it
//! ```
//! Nothing is fed forward, so the motor follows at the pace of the position loop: behind a step the
//! part `exp(-Kv t)` of the gap is left. Slower loops leave longer marks at reversals.
//!
//! Signals: reference velocity, rad/s. Settings: told total gap (um, mdeg or motor rad), time over
//! which the offset is spread (ms; 0 is a step).
//!
//! Fails: as `fixed`, and slower by the position loop: with Kv of 16 1/s (1 m/min per mm) a quarter
//! of the gap is still there 90 ms after the reversal. A step of a wide gap shakes the machine.
//!
//! Source: Siemens 840D, 828D, 808D: MD32450 BACKLASH, added to the actual value, at once.
//! Heidenhain iTNC 530: MP710 outside the loop, MP750 over the time MP752; MANUALplus 620 and later:
//! posCtrlRevErr over posCtrlRevErrTime, which settles with kv. The curve over that time is not
//! published; a straight line is taken.

use crate::AxisConfig;
use crate::registry::{Registered, Settings, told, told_or_true_gap};
use crate::traverse::{Ramp, RampTime, direction};
use lostmotion_drive::config::check::{AxisConfigError, between};
use lostmotion_drive::config::{Gap, Transmission};
use lostmotion_drive::signal::Engagement;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `actual-value`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ActualValueSettings {
    /// Total gap that the control was told; the machine's true gap if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<Gap>,
    /// Time over which the offset goes from one side to the other, ms; 0 is a step.
    pub spread_ms: f64,
}

impl Settings for ActualValueSettings {
    fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        told("gap", self.gap, transmission)?;
        between("spread_ms", self.spread_ms, 0.0, 10_000.0)
    }

    fn gaps(&mut self) -> Vec<&mut Option<Gap>> {
        vec![&mut self.gap]
    }
}

/// The method `actual-value`.
#[derive(Clone, Copy, Debug)]
pub struct ActualValue {
    /// Half of the told gap, rad at the motor.
    half_gap: f64,
    time: RampTime,
}

/// Commanded direction, and the offset on its way from one side to the other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActualValueState {
    direction: i8,
    ramp: Ramp,
}

impl Registered for ActualValue {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "actual-value",
        summary: "known half gap taken off the measured position at each reversal, left to the position loop",
        knows: Knowledge {
            load_scale: false,
            gap: true,
            load: false,
        },
        source: "Siemens MD32450; Heidenhain MP750 and MP752, posCtrlRevErr",
    };

    fn from_axis(config: &AxisConfig) -> ActualValue {
        let settings = &config.compensation.actual_value;
        ActualValue {
            half_gap: 0.5 * told_or_true_gap(settings.gap, config),
            time: RampTime::from_ms(settings.spread_ms, config.servo_period_s()),
        }
    }
}

impl Compensator for ActualValue {
    type State = ActualValueState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) -> ActualValueState {
        ActualValueState {
            direction: 0,
            ramp: Ramp::DONE,
        }
    }

    #[inline]
    fn step(&self, state: &mut ActualValueState, signals: &Signals) -> Correction {
        let offset = |state: &ActualValueState| {
            let target = f64::from(state.direction) * self.half_gap;
            state.ramp.straight_towards(target)
        };
        let before = offset(state);
        let direction = direction(signals.reference.velocity, state.direction);
        if direction != state.direction {
            state.direction = direction;
            state.ramp.start(before);
        }
        state.ramp.advance(self.time);
        Correction {
            feedback: offset(state),
            gap_angle_estimate: f64::from(direction) * self.half_gap,
            engagement_estimate: Engagement::of_sign(direction),
            ..Correction::NONE
        }
    }
}
