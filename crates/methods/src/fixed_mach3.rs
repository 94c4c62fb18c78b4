//! Half the gap towards the commanded direction at a constant speed, without a limit of
//! acceleration.
//!
//! ```text
//! s         sign of w_ref; |w_ref| <= 1e-6 rad/s keeps the last one
//! position  towards s b at the speed v, rad;   velocity  +-v until it is there
//! ```
//! The speed of the motor jumps by v at both ends of the take-up.
//!
//! Signals: reference velocity, rad/s. Settings: told total gap (um, mdeg or motor rad), speed of
//! the take-up (axis unit per s).
//!
//! Fails: as `fixed`. The jump of speed overloads the drive or makes a stepper lose steps where v is
//! more than the motor can start with.
//!
//! Source: Mach3, backlash distance and speed as a part of the axis' largest; secondary sources
//! alone say that it ignores the acceleration. That it switches constant velocity off is
//! `planner.stops`.

use crate::AxisConfig;
use crate::registry::{Registered, Settings, told, told_or_true_gap};
use crate::traverse::direction;
use lostmotion_drive::config::check::{AxisConfigError, positive};
use lostmotion_drive::config::{Gap, Transmission};
use lostmotion_drive::signal::Engagement;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `fixed-mach3`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FixedMach3Settings {
    /// Total gap that the control was told; the machine's true gap if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<Gap>,
    /// Speed of the take-up: mm, deg or rad per s.
    pub speed_units_s: f64,
}

impl Default for FixedMach3Settings {
    fn default() -> FixedMach3Settings {
        FixedMach3Settings {
            gap: None,
            speed_units_s: 5.0,
        }
    }
}

impl Settings for FixedMach3Settings {
    fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        told("gap", self.gap, transmission)?;
        positive("speed_units_s", self.speed_units_s)
    }

    fn gaps(&mut self) -> Vec<&mut Option<Gap>> {
        vec![&mut self.gap]
    }
}

/// The method `fixed-mach3`.
#[derive(Clone, Copy, Debug)]
pub struct FixedMach3 {
    /// Half of the told gap, rad at the motor.
    half_gap: f64,
    /// Way of one tick, rad.
    step: f64,
    period_s: f64,
}

/// Commanded direction and present correction, rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixedMach3State {
    direction: i8,
    position: f64,
}

impl Registered for FixedMach3 {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "fixed-mach3",
        summary: "known half gap added at each reversal at a constant speed, without a limit of acceleration",
        knows: Knowledge {
            load_scale: false,
            gap: true,
            load: false,
        },
        source: "Mach3, backlash distance and speed (secondary sources)",
    };

    fn from_axis(config: &AxisConfig) -> FixedMach3 {
        let settings = &config.compensation.fixed_mach3;
        let period_s = config.servo_period_s();
        FixedMach3 {
            half_gap: 0.5 * told_or_true_gap(settings.gap, config),
            step: settings.speed_units_s * config.transmission.motor_rad_per_unit() * period_s,
            period_s,
        }
    }
}

impl Compensator for FixedMach3 {
    type State = FixedMach3State;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) -> FixedMach3State {
        FixedMach3State {
            direction: 0,
            position: 0.0,
        }
    }

    #[inline]
    fn step(&self, state: &mut FixedMach3State, signals: &Signals) -> Correction {
        state.direction = direction(signals.reference.velocity, state.direction);
        let target = f64::from(state.direction) * self.half_gap;
        let (before, left) = (state.position, target - state.position);
        state.position = if left.abs() <= self.step {
            target
        } else {
            before + self.step * left.signum()
        };
        Correction {
            position: state.position,
            velocity: (state.position - before) / self.period_s,
            gap_angle_estimate: target,
            engagement_estimate: Engagement::of_sign(state.direction),
            ..Correction::NONE
        }
    }
}
