//! Half the gap towards the commanded direction, applied within limits of velocity and
//! acceleration, as LinuxCNC does.
//!
//! ```text
//! s       sign of w_ref; |w_ref| <= 1e-6 rad/s keeps the last one; target s b, rad
//! each servo period T_s, x the distance to the target:
//! v       min(v + a T_s, v_max, sqrt(a^2 T_s^2/4 + 2 a x) - a T_s/2), rad/s
//! position correction += v T_s towards the target;   velocity is its derivative
//! a       half of the joint's acceleration limit,   v_max half of its velocity limit
//! ```
//! The speed of the correction is a trapezoid, for small gaps a triangle that lasts `2 sqrt(2
//! b/a)`. The correction is added to the programmed motion, so both together may exceed the joint's
//! limits by half: LinuxCNC accepts the same.
//!
//! Signals: reference velocity, rad/s. Settings: told total gap (um, mdeg or motor rad), the
//! joint's limits of velocity and acceleration (axis unit per s, s2; if left out: no limit of
//! velocity, and the acceleration that the rated torque gives the whole axis).
//!
//! Fails: as `fixed`; only the curve differs.
//!
//! Source: LinuxCNC, BACKLASH in the joint's section of the INI file; its motion controller ramps
//! the correction at half of the joint's limits.

use crate::AxisConfig;
use crate::registry::{Registered, Settings, told, told_or_true_gap};
use crate::traverse::direction;
use lostmotion_drive::config::check::{AxisConfigError, positive};
use lostmotion_drive::config::{Gap, Transmission};
use lostmotion_drive::signal::Engagement;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `fixed-linuxcnc`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FixedLinuxcncSettings {
    /// Total gap that the control was told (BACKLASH); the machine's true gap if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<Gap>,
    /// The joint's limit of velocity, of which half is used: mm, deg or rad per s. Unlimited if left
    /// out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity_units_s: Option<f64>,
    /// The joint's limit of acceleration, of which half is used: mm, deg or rad per s2. What the
    /// rated torque gives the whole axis if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration_units_s2: Option<f64>,
}

impl Settings for FixedLinuxcncSettings {
    fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        told("gap", self.gap, transmission)?;
        positive("velocity_units_s", self.velocity_units_s.unwrap_or(1.0))?;
        positive(
            "acceleration_units_s2",
            self.acceleration_units_s2.unwrap_or(1.0),
        )
    }

    fn gaps(&mut self) -> Vec<&mut Option<Gap>> {
        vec![&mut self.gap]
    }
}

/// Part of the joint's limits that the correction may use, as in LinuxCNC's motion controller.
const SHARE_OF_JOINT_LIMITS: f64 = 0.5;

/// The method `fixed-linuxcnc`.
#[derive(Clone, Copy, Debug)]
pub struct FixedLinuxcnc {
    half_gap: f64,
    /// rad/s.
    velocity: f64,
    /// Change of speed in one tick, rad/s.
    step: f64,
    period_s: f64,
}

/// Where its correction is (rad) and how fast it moves (rad/s, without sign).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixedLinuxcncState {
    direction: i8,
    position: f64,
    speed: f64,
}

impl Registered for FixedLinuxcnc {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "fixed-linuxcnc",
        summary: "known half gap added at each reversal, taken up within half of the joint's limits of velocity and acceleration",
        knows: Knowledge {
            load_scale: false,
            gap: true,
            load: false,
        },
        source: "LinuxCNC, BACKLASH",
    };

    fn from_axis(config: &AxisConfig) -> FixedLinuxcnc {
        let settings = &config.compensation.fixed_linuxcnc;
        let gap = told_or_true_gap(settings.gap, config);
        let per_unit = config.transmission.motor_rad_per_unit();
        // without limits of the joint: what the motor can hold continuously
        let inertia = config.motor_side_inertia_kgm2() + config.reflected_load().inertia_kgm2;
        let rated = config.motor.rated_torque_nm / inertia;
        let acceleration = settings
            .acceleration_units_s2
            .map_or(rated, |limit| limit * per_unit);
        let period_s = config.servo_period_s();
        FixedLinuxcnc {
            half_gap: 0.5 * gap,
            velocity: SHARE_OF_JOINT_LIMITS
                * settings
                    .velocity_units_s
                    .map_or(f64::MAX, |limit| limit * per_unit),
            step: SHARE_OF_JOINT_LIMITS * acceleration * period_s,
            period_s,
        }
    }
}

impl Compensator for FixedLinuxcnc {
    type State = FixedLinuxcncState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) -> FixedLinuxcncState {
        FixedLinuxcncState {
            direction: 0,
            position: 0.0,
            speed: 0.0,
        }
    }

    #[inline]
    fn step(&self, state: &mut FixedLinuxcncState, signals: &Signals) -> Correction {
        let direction = direction(signals.reference.velocity, state.direction);
        if direction != state.direction {
            // a reversal within a ramp stops it at once and starts a new one from the present offset
            *state = FixedLinuxcncState {
                direction,
                speed: 0.0,
                ..*state
            };
        }
        // trapezoid in speed towards the new side
        let target = f64::from(direction) * self.half_gap;
        let way = target - state.position;
        // largest speed from which it can still stop at the target, braking by one step a tick: the
        // positive root of v^2/(2 a) + v T_s/2 = x
        let half = 0.5 * self.step;
        let stopping = (half * half + 2.0 * self.step * way.abs() / self.period_s).sqrt() - half;
        let speed = (state.speed + self.step).min(self.velocity).min(stopping);
        let before = state.position;
        // within one tick of the target: arrive exactly, without overshoot
        if speed * self.period_s >= way.abs() || speed <= 0.0 {
            (state.position, state.speed) = (target, 0.0);
        } else {
            (state.position, state.speed) = (before + speed * self.period_s * way.signum(), speed);
        }
        Correction {
            position: state.position,
            velocity: (state.position - before) / self.period_s,
            gap_angle_estimate: target,
            engagement_estimate: Engagement::of_sign(direction),
            ..Correction::NONE
        }
    }
}
