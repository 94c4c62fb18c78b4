//! A disturbance observer around the motor: torque that the motor delivers beyond the need of its
//! nominal inertia is taken for a disturbance and cancelled.
//!
//! ```text
//! d = Q(s) (K_t i - J_n s w),   Q = g/(s + g),   g = 2 pi f           resisting torque, N m; J_n: inertia that the drive was told
//! without a derivative:  y += (1 - exp(-g T_s)) (K_t i + g J_n w - y),   d = y - g J_n w
//! torque correction = share d, limited to the rated torque
//! ```
//! Signals: motor velocity (rad/s), current (A). Settings: bandwidth f of the filter (Hz), share (0
//! to 1). It knows K_t and the inertia of the drive's own feed-forward, right or wrong; nothing
//! about gap or friction.
//!
//! Friction that changes sign at a reversal is cancelled within 1/g instead of the velocity
//! integral's time, so the motor's own error at the reversal shrinks. The contact torque that
//! appears or vanishes is cancelled in the same way.
//!
//! Fails: the gap does not resist. The motor stands where its reference is while the load is off by
//! half a gap, and no torque shows it; the offset stays in full, with friction and without. In the
//! gap the motor is lighter than J_n, and the observer makes the crossing slower, by `d = -(J_n -
//! J_M) alpha`. A bandwidth near the shaft's resonance or the loop's delays makes it oscillate; a
//! coarse encoder is heard as `g J_n` times the noise of the velocity. With little load friction
//! the stiffer motor lands harder.
//!
//! Source: Ohnishi (1987); Umeno and Hori, IEEE Trans. Ind. Electron. 38 (1991); in drives as load
//! torque observer.

use crate::AxisConfig;
use crate::registry::{Registered, Settings};
use lostmotion_base::math;
use lostmotion_drive::config::Transmission;
use lostmotion_drive::config::check::{AxisConfigError, between};
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Settings of `disturbance-observer`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DisturbanceObserverSettings {
    /// Bandwidth of the observer's filter, Hz.
    pub bandwidth_hz: f64,
    /// Part of the observed torque that is cancelled, 0 to 1.
    pub share: f64,
}

impl Default for DisturbanceObserverSettings {
    fn default() -> DisturbanceObserverSettings {
        DisturbanceObserverSettings {
            bandwidth_hz: 30.0,
            share: 0.8,
        }
    }
}

impl Settings for DisturbanceObserverSettings {
    fn check(&self, _transmission: &Transmission) -> Result<(), AxisConfigError> {
        between("bandwidth_hz", self.bandwidth_hz, 0.1, 500.0)?;
        between("share", self.share, 0.0, 1.0)
    }
}

/// The method `disturbance-observer`.
#[derive(Clone, Copy, Debug)]
pub struct DisturbanceObserver {
    torque_constant: f64,
    /// g J_n, N m s/rad.
    momentum_gain: f64,
    /// Gain of the low pass in a servo period, 1 - exp(-g T_s).
    smoothing: f64,
    share: f64,
    /// Largest correction, N m: the rated torque.
    largest: f64,
}

/// The filter's output, N m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DisturbanceObserverState {
    filtered: f64,
    started: bool,
}

impl Registered for DisturbanceObserver {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "disturbance-observer",
        summary: "torque beyond what the nominal inertia needs is observed at the motor and cancelled; the gap's offset stays",
        knows: Knowledge {
            load_scale: false,
            gap: false,
            load: false,
        },
        source: "Ohnishi (1987); Umeno and Hori (1991)",
    };

    fn from_axis(config: &AxisConfig) -> DisturbanceObserver {
        let settings = &config.compensation.disturbance_observer;
        // nominal inertia: that of the drive's acceleration feed-forward, or the true one if none
        // was told
        let all = config.motor_side_inertia_kgm2() + config.reflected_load().inertia_kgm2;
        let rate = TAU * settings.bandwidth_hz;
        DisturbanceObserver {
            torque_constant: config.motor.torque_constant_nm_per_a,
            momentum_gain: rate * config.drive.told_inertia_kgm2.unwrap_or(all),
            // exact discretisation of the low pass; expm1 keeps its digits at low bandwidths
            smoothing: -math::expm1(-rate * config.servo_period_s()),
            share: settings.share,
            largest: config.motor.rated_torque_nm,
        }
    }
}

impl Compensator for DisturbanceObserver {
    type State = DisturbanceObserverState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) -> DisturbanceObserverState {
        DisturbanceObserverState {
            filtered: 0.0,
            started: false,
        }
    }

    #[inline]
    fn step(&self, state: &mut DisturbanceObserverState, signals: &Signals) -> Correction {
        // the derivative of the velocity is avoided: Q (K_t i - J_n s w) = Q (K_t i + g J_n w) - g
        // J_n w
        let momentum = self.momentum_gain * signals.motor_velocity;
        let input = self.torque_constant * signals.current + momentum;
        if !state.started {
            // start at equilibrium: a drive that holds a load against gravity already carries the
            // torque in its integral, and cancelling it twice would be a blow
            *state = DisturbanceObserverState {
                filtered: momentum,
                started: true,
            };
        }
        state.filtered += self.smoothing * (input - state.filtered);
        let resisting = state.filtered - momentum;
        Correction {
            torque: (self.share * resisting).clamp(-self.largest, self.largest),
            ..Correction::NONE
        }
    }
}
