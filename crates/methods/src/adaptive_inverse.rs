//! Tao and Kokotovic's adaptive inverse of backlash: the motor is put where the load will be right;
//! the two half gaps are learned by a gradient.
//!
//! ```text
//! backlash (slope 1):   theta_L = theta_M - c_r while the motor moves up, theta_M - c_l while it moves down, else unchanged, rad
//! right inverse:        theta_M = v + c_r where v moves up, v + c_l where v moves down           (v: the reference)
//! measured:             y = theta_M - theta_L - T/k,   T = K_t i - J_M alpha_ref - b_v w_ref - T_cM sign(w_ref), N m
//! normalised gradient:  c_r += gamma (y - c_r) T_s on strokes up, c_l likewise on strokes down, from 30 ms after a reversal on
//! bounds:               |c| <= the largest half gap
//! ```
//! With the indicator functions of the strokes as regressor, the gradient is a first-order average
//! per direction. The jump of the inverse takes the ramp time. `T/k` keeps the shaft's wind-up out
//! of the gap.
//!
//! **It needs a scale at the load**: the theory adapts on the error of the backlash's output. The
//! torque as a motor-side surrogate of that output does not show the gap while the motor is where
//! it should be. A machine without a scale gets an ideal one.
//!
//! Signals: reference, motor position (rad), load position (rad at the motor), current (A). It
//! knows the stiffness of the shaft and the motor's data. Settings: gamma (1/s), largest half gap
//! as a total gap (um, mdeg or motor rad), ramp time (ms).
//!
//! Fails: the backlash of the theory has no inertia; its output stops as soon as the input turns.
//! That is a load driven by friction. A load without friction coasts across the gap at the
//! reversal, where the inverse crosses it too, and is off until the flank has changed; there the
//! method is worse than none.
//!
//! Source: Tao and Kokotovic, *Adaptive Control of Systems with Actuator and Sensor
//! Nonlinearities*, Wiley 1996, chapters 2 to 4.

use crate::AxisConfig;
use crate::registry::{Registered, Settings, told};
use crate::traverse::{Ramp, RampTime, direction};
use lostmotion_drive::config::check::{AxisConfigError, between};
use lostmotion_drive::config::{Gap, Transmission};
use lostmotion_drive::signal::Engagement;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `adaptive-inverse`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AdaptiveInverseSettings {
    /// Gain of the gradient, 1/s.
    pub gain_per_s: f64,
    /// Total gap beyond which nothing is learned; a turn of the motor if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub largest_gap: Option<Gap>,
    /// Time over which the correction goes from one side to the other, ms.
    pub ramp_ms: f64,
}

impl Default for AdaptiveInverseSettings {
    fn default() -> AdaptiveInverseSettings {
        AdaptiveInverseSettings {
            gain_per_s: 10.0,
            largest_gap: None,
            ramp_ms: 8.0,
        }
    }
}

impl Settings for AdaptiveInverseSettings {
    fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        between("gain_per_s", self.gain_per_s, 0.0, 1e4)?;
        told("largest_gap", self.largest_gap, transmission)?;
        between("ramp_ms", self.ramp_ms, 0.0, 10_000.0)
    }
}

/// Time from a reversal on in which nothing is learned, ms: ramp and ringing of the shaft have to
/// be over. A choice: longer loses the start of each stroke, shorter learns from the ringing.
const SETTLE_MS: f64 = 30.0;

/// The method `adaptive-inverse`.
#[derive(Clone, Copy, Debug)]
pub struct AdaptiveInverse {
    /// gamma T_s, at most 1.
    gain: f64,
    /// Bound of |c|, rad.
    largest_half_gap: f64,
    time: RampTime,
    period_s: f64,
    settle_ticks: u32,
    torque_constant: f64,
    inertia: f64,
    viscous: f64,
    coulomb: f64,
    /// 1/k, rad/(N m).
    compliance: f64,
}

/// The learned half gaps, and the correction on its ramp.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AdaptiveInverseState {
    direction: i8,
    /// Ticks of this stroke, up to [`SETTLE_MS`].
    ticks: u32,
    /// `c_l` and `c_r`, rad.
    learned: [f64; 2],
    /// Offset of this stroke, rad.
    target: f64,
    ramp: Ramp,
}

impl Registered for AdaptiveInverse {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "adaptive-inverse",
        summary: "right inverse of the backlash at the reference, both half gaps learned by a gradient from a scale at the load",
        knows: Knowledge {
            load_scale: true,
            gap: false,
            load: false,
        },
        source: "Tao and Kokotovic, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, Wiley 1996",
    };

    fn from_axis(config: &AxisConfig) -> AdaptiveInverse {
        let (settings, motor) = (&config.compensation.adaptive_inverse, &config.motor);
        let period_s = config.servo_period_s();
        let turn = std::f64::consts::TAU;
        AdaptiveInverse {
            gain: (settings.gain_per_s * period_s).min(1.0),
            largest_half_gap: 0.5
                * settings
                    .largest_gap
                    .map_or(turn, |gap| gap.motor_rad(&config.transmission)),
            time: RampTime::from_ms(settings.ramp_ms, period_s),
            period_s,
            settle_ticks: config.cycles.ticks(SETTLE_MS),
            torque_constant: motor.torque_constant_nm_per_a,
            inertia: config.motor_side_inertia_kgm2(),
            viscous: motor.viscous_nm_s_per_rad,
            coulomb: motor.coulomb_nm,
            compliance: 1.0 / config.reflected_load().stiffness_nm_per_rad,
        }
    }
}

impl AdaptiveInverse {
    /// One step of the gradient for the present direction.
    fn learn(&self, state: &mut AdaptiveInverseState, signals: &Signals) {
        let Some(load) = signals.load_position else {
            return;
        };
        let (reference, sign) = (&signals.reference, f64::from(state.direction));
        // torque in the shaft: what the motor gives beyond its own inertia and friction
        let own = self.inertia * reference.acceleration
            + self.viscous * reference.velocity
            + self.coulomb * sign;
        let wind_up = (self.torque_constant * signals.current - own) * self.compliance;
        // half gap on the present flank, with the wind-up taken out
        let output = signals.motor_position - load - wind_up;
        // the indicator of the stroke is the regressor: each direction learns its own half gap
        let learned = &mut state.learned[usize::from(state.direction > 0)];
        let next = *learned + self.gain * (output - *learned);
        *learned = if next.is_finite() {
            next.clamp(-self.largest_half_gap, self.largest_half_gap)
        } else {
            *learned
        };
    }
}

impl Compensator for AdaptiveInverse {
    type State = AdaptiveInverseState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, _motor_position: f64) -> AdaptiveInverseState {
        AdaptiveInverseState {
            direction: 0,
            ticks: 0,
            learned: [0.0; 2],
            target: 0.0,
            ramp: Ramp::DONE,
        }
    }

    #[inline]
    fn step(&self, state: &mut AdaptiveInverseState, signals: &Signals) -> Correction {
        let before = state.ramp.towards(state.target);
        let direction = direction(signals.reference.velocity, state.direction);
        if direction != state.direction {
            // frozen for the stroke: a target that followed the learning would move the motor from
            // which it is learned
            state.target = state.learned[usize::from(direction > 0)];
            state.direction = direction;
            state.ticks = 0;
            state.ramp.start(before);
        }
        state.ticks = (state.ticks + 1).min(self.settle_ticks);
        // the output is that of the flank only in steady contact, behind ramp and ringing
        if state.ticks >= self.settle_ticks
            && state.ramp.done()
            && signals.reference.velocity.abs() > super::traverse::STANDING_RAD_S
        {
            self.learn(state, signals);
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
