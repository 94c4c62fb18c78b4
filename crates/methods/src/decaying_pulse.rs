//! A pulse of speed at each reversal that decays exponentially, its height by the acceleration
//! there.
//!
//! ```text
//! after each change of sign of w_ref (|w_ref| <= 1e-6 rad/s keeps it):
//! velocity  s h(a) exp(-t/T), rad/s                 s: commanded direction
//! a         |acceleration of the reference| at the reversal: v^2/r on a circle
//! h(a)      H a/a1 below a1;  H up to a2;  from H to H_min in a straight line up to a3;  H_min beyond
//! ```
//! Without accelerations the height is H everywhere. H left out: H T = 2 b, the pulse's area is the
//! total gap. As with `reversal-pulse` nothing holds the motor there afterwards: it shortens the
//! time in which the load stands still and leaves the offset.
//!
//! Signals: reference velocity and acceleration. Settings: heights H and H_min (axis unit per s, at
//! the load), accelerations a1 to a3 (axis unit per s2), time constant T (ms).
//!
//! Fails: as `reversal-pulse`: a height that is right at one feed, radius and friction makes a notch
//! at others; the curve over the acceleration mends that for feed and radius.
//!
//! Source: Siemens, friction compensation MD32490 to MD32570, with the adaptation of the function
//! manual K3; Fagor 8060 and 8065, BAKANOUT with BAKTIME. Both as speed added to the command of the
//! velocity loop.

use crate::AxisConfig;
use crate::registry::{Registered, Settings};
use crate::traverse::direction;
use lostmotion_base::math;
use lostmotion_drive::config::Transmission;
use lostmotion_drive::config::check::{AxisConfigError, between, not_negative, positive};
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `decaying-pulse`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DecayingPulseSettings {
    /// Height of the pulse (MD32520, BAKANOUT): mm, deg or rad per s. If left out, the pulse's area
    /// is the machine's true gap.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_units_s: Option<f64>,
    /// Height beyond the last acceleration (MD32530): mm, deg or rad per s; the same if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_height_units_s: Option<f64>,
    /// Accelerations a1 to a3 between which the height changes (MD32550, MD32560, MD32570), rising:
    /// mm, deg or rad per s2. If left out, the height is the same at all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration_units_s2: Option<[f64; 3]>,
    /// Time constant of the decay (MD32540), ms.
    pub time_ms: f64,
}

impl Default for DecayingPulseSettings {
    fn default() -> DecayingPulseSettings {
        DecayingPulseSettings {
            height_units_s: None,
            least_height_units_s: None,
            acceleration_units_s2: None,
            time_ms: 15.0,
        }
    }
}

impl Settings for DecayingPulseSettings {
    fn check(&self, _transmission: &Transmission) -> Result<(), AxisConfigError> {
        not_negative("height_units_s", self.height_units_s.unwrap_or(0.0))?;
        let least = self.least_height_units_s.unwrap_or(0.0);
        not_negative("least_height_units_s", least)?;
        let mut least = 0.0;
        for acceleration in self.acceleration_units_s2.iter().flatten() {
            positive("acceleration_units_s2", *acceleration)?;
            between("acceleration_units_s2", *acceleration, least, f64::MAX)?;
            least = *acceleration;
        }
        between("time_ms", self.time_ms, 0.25, 10_000.0)
    }
}

/// The method `decaying-pulse`.
#[derive(Clone, Copy, Debug)]
pub struct DecayingPulse {
    /// H and H_min, rad/s.
    heights: [f64; 2],
    /// a1 to a3, rad/s2.
    accelerations: Option<[f64; 3]>,
    /// Part that is left after a tick.
    decay: f64,
}

/// Direction of the motion, and what is left of the pulse, rad/s with its sign.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DecayingPulseState {
    direction: i8,
    left: f64,
}

impl Registered for DecayingPulse {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "decaying-pulse",
        summary: "a pulse of speed at each reversal that decays exponentially, its height by the acceleration",
        knows: Knowledge {
            load_scale: false,
            gap: true,
            load: false,
        },
        source: "Siemens friction compensation MD32490 to MD32570; Fagor BAKANOUT and BAKTIME",
    };

    fn from_axis(config: &AxisConfig) -> DecayingPulse {
        let settings = &config.compensation.decaying_pulse;
        let per_unit = config.transmission.motor_rad_per_unit();
        let time_s = settings.time_ms * 1e-3;
        let of_gap = config.reflected_load().gap_rad / time_s;
        let height = settings
            .height_units_s
            .map_or(of_gap, |told| told * per_unit);
        let least = settings.least_height_units_s;
        DecayingPulse {
            heights: [height, least.map_or(height, |told| told * per_unit)],
            accelerations: settings
                .acceleration_units_s2
                .map(|told| told.map(|value| value * per_unit)),
            decay: math::exp(-config.servo_period_s() / time_s),
        }
    }
}

impl DecayingPulse {
    /// Height of the pulse at an acceleration, rad/s.
    fn height(&self, a: f64) -> f64 {
        let [most, least] = self.heights;
        let Some([a1, a2, a3]) = self.accelerations else {
            return most;
        };
        if a < a1 {
            most * a / a1
        } else if a <= a2 {
            most
        } else if a < a3 {
            most + (least - most) * (a - a2) / (a3 - a2)
        } else {
            least
        }
    }
}

impl Compensator for DecayingPulse {
    type State = DecayingPulseState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) -> DecayingPulseState {
        DecayingPulseState {
            direction: 0,
            left: 0.0,
        }
    }

    #[inline]
    fn step(&self, state: &mut DecayingPulseState, signals: &Signals) -> Correction {
        let direction = direction(signals.reference.velocity, state.direction);
        if direction != state.direction {
            let height = self.height(signals.reference.acceleration.abs());
            *state = DecayingPulseState {
                direction,
                left: f64::from(direction) * height,
            };
        }
        let velocity = state.left;
        state.left *= self.decay;
        Correction {
            velocity,
            ..Correction::NONE
        }
    }
}
