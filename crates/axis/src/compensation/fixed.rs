//! The classic: half the gap, known beforehand, towards the direction of the commanded velocity.
//!
//! ```text
//! direction s changes where w_ref changes sign (|w_ref| <= 1e-6 rad/s keeps it)
//! correction: from where it is to s b, along 3 u^2 - 2 u^3 over the ramp time; its derivative goes to the velocity
//! ```
//! Signals: reference velocity, rad/s. Tunables: told total gap (um, mdeg or motor rad), ramp time (ms).
//! Fails: where the load does not follow the commanded direction. A load without friction coasts through the reversal and changes flanks
//! where the acceleration changes sign, so the correction comes a quarter period late or early; an error of the told gap stays
//! in full; the ramp adds its own error while the load still rests.
//! Source: common practice, for instance LinuxCNC (BACKLASH in the INI file, with an acceleration-limited take-up), Heidenhain (backlash
//! compensation in MP 710 and its successors, over an adjustable time); Kao et al. as cited by Gan, Wang, Huang (2023).

use super::registry::Registered;
use super::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use crate::config::AxisConfig;
use crate::signal::Engagement;
use lostmotion_base::Clock;
use serde::{Deserialize, Serialize};

/// A reference slower than this keeps the direction, rad/s.
const STANDING_RAD_S: f64 = 1e-6;

/// The method `fixed`.
#[derive(Clone, Copy, Debug)]
pub struct Fixed {
    half_gap: f64,
    per_tick: f64,
    period_s: f64,
}

/// Where its correction is on the way from one side to the other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixedState {
    direction: i8,
    from: f64,
    progress: f64,
}

impl Registered for Fixed {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "fixed",
        summary: "known half gap added at each reversal of the commanded velocity, with a ramp",
        knows: Knowledge { load_scale: false, gap: true, load: false },
        source: "common practice: LinuxCNC, Heidenhain",
    };

    fn from_axis(config: &AxisConfig) -> Fixed {
        let settings = &config.compensation.fixed;
        let gap = settings.gap.map_or(config.reflected_load().gap_rad, |told| told.motor_rad(&config.transmission));
        let period_s = Clock::SERVO.period_s();
        let ramp_s = settings.ramp_ms * 1e-3;
        Fixed { half_gap: 0.5 * gap, per_tick: if ramp_s > period_s { period_s / ramp_s } else { 1.0 }, period_s }
    }
}

impl Compensator for Fixed {
    type State = FixedState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) -> FixedState {
        FixedState { direction: 0, from: 0.0, progress: 1.0 }
    }

    #[inline]
    fn step(&self, state: &mut FixedState, signals: &Signals) -> Correction {
        let before = self.position(state);
        let velocity = signals.reference.velocity;
        let direction = if velocity > 0.0 { 1 } else { -1 };
        if velocity.abs() > STANDING_RAD_S && direction != state.direction {
            *state = FixedState { direction, from: before, progress: 0.0 };
        }
        state.progress = (state.progress + self.per_tick).min(1.0);
        let position = self.position(state);
        Correction {
            position,
            velocity: (position - before) / self.period_s,
            gap_angle_estimate: f64::from(state.direction) * self.half_gap,
            engagement_estimate: match state.direction {
                1 => Engagement::Positive,
                -1 => Engagement::Negative,
                _ => Engagement::Gap,
            },
            ..Correction::NONE
        }
    }
}

impl Fixed {
    fn position(&self, state: &FixedState) -> f64 {
        let u = state.progress;
        let target = f64::from(state.direction) * self.half_gap;
        state.from + (target - state.from) * (u * u * (3.0 - 2.0 * u))
    }
}
