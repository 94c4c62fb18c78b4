//! The adaptive compensation of Gan, Wang, Huang, *Adaptive Backlash Compensation for CNC Machining
//! Applications*, Machines 2023, 11(2), 193, equations (4) to (13), at the servo period T = 250 us.
//!
//! ```text
//! (4)  ES in {-1, 0, 1}: which flank is in contact; starts at 0
//! (5)  theta_M(k) + a1 theta_M(k-1) + a2 theta_M(k-2) = b0 i_q(k),   D = J + b_v T,
//!      b0 = K_t T^2/D,  a1 = -(2 J + b_v T)/D,  a2 = J/D;   phi = [-theta_M(k-1), -theta_M(k-2), i_q(k)]
//! (6)  e = theta_M(k) - phi' theta;   theta += P phi e                      as printed: `published-literal`
//!                                     theta += P phi e/(1 + phi' P phi)     the usual gain: `published`
//! (7)  P -= P phi phi' P/(1 + phi' P phi)
//! (8)  P = P0 instead, where |alpha_ref(k)| > 0 and |alpha_ref(k-1)| = 0
//! (9)  start: J = J_M, b_v = 0, P = P0, ES = 0, theta_b = 0, theta_L = theta_M
//! (10) J = max(a2 K_t T^2/b0, (-a1 - 1) K_t T^2/b0)
//! (11) ES = sign(alpha_ref) if J > J_min and ES was 0;  0 if |J| <= J_min and ES was -sign(alpha_ref);  else as it was
//!      J_min = J_M/(1 - lambda)
//! (12) theta_b += dtheta_M(k) - dtheta_c if |J| <= J_min and ES was 0;  else held
//!      dtheta_c = dtheta_M(k) latched where ES became 0 (the load is taken to coast at that speed)
//! (13) theta_L = theta_M - theta_b goes to the position loop
//! ```
//! Signals: motor position (rad), current (A), reference acceleration (rad/s2). It knows K_t and
//! J_M (rotor and screw) from the data sheets. Settings: lambda (0 to 1), P0 (same for all three
//! parameters), and the acceleration that counts as zero (rad/s2).
//!
//! Ours, not the paper's: the threshold for zero acceleration, the default of lambda and of P0, and
//! the usual gain in (6).
//!
//! The paper gives neither lambda nor P0. On its own axis, moving 0 -> 20 rad -> 0, the settled
//! offset falls below a tenth of that without compensation for P0 from 100 to 300 with lambda 0.4
//! to 0.77, and again from 1e7 on; P0 below 10 learns too slowly, from 1e3 to 1e5 the way back ends
//! on the wrong flank, and lambda 0.2 never works. Another motor needs another P0: it scales with
//! the square of K_t T^2/J.
//!
//! Fails:
//! - The printed gain of (6) diverges once phi' P phi > 2.
//! - (8) fires only where the acceleration leaves exact zero. On an arc it never does again: ES
//!   latches, theta_b stays on one side, and the error reaches the whole gap, **twice that of no
//!   compensation**.
//! - J_min has to lie below J_M + J_L, which the drive is not told: lambda < 1 - J_M/(J_M + J_L).
//!   Above it, theta_b grows without bound.
//! - theta_b is a sum of differences without any absolute reference: it drifts. Wind-up of the shaft
//!   counts as gap.
//! - Three parameters from absolute angles, of which 1 + a1 + a2 = 0 always holds: ill-conditioned
//!   far from zero, and with an encoder of finite resolution a large P0 fits its steps. With 2^20
//!   counts theta_b can run away by millimetres where load friction is small.
//! - A friction-driven load changes flanks with the velocity; `sign(alpha_ref)` in (11) is then
//!   wrong.

use crate::AxisConfig;
use crate::registry::{Registered, Settings};
use lostmotion_drive::config::Transmission;
use lostmotion_drive::config::check::{AxisConfigError, between, not_negative, positive};
use lostmotion_drive::signal::Engagement;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `published` and `published-literal`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PublishedSettings {
    /// Threshold of the inertia: J_min = J_M/(1 - lambda), 0 < lambda < 1. It has to be below 1 -
    /// J_M/(J_M + J_L). If left out: 0.775 of that bound, as it would be set in commissioning; that is
    /// 0.60 on the paper's axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lambda: Option<f64>,
    /// Initial covariance P0 = p0 I of the recursive least squares (angles in rad, current in A).
    pub p0: f64,
    /// A reference acceleration no larger than this counts as zero, rad/s2 at the motor. The paper
    /// compares with exact zero; a spline of floating-point setpoints leaves rounding where the
    /// acceleration is meant to be zero.
    pub acceleration_zero_rad_s2: f64,
}

impl Default for PublishedSettings {
    fn default() -> PublishedSettings {
        PublishedSettings {
            lambda: None,
            p0: 300.0,
            acceleration_zero_rad_s2: 1e-3,
        }
    }
}

impl Settings for PublishedSettings {
    fn check(&self, _transmission: &Transmission) -> Result<(), AxisConfigError> {
        if let Some(lambda) = self.lambda {
            between("lambda", lambda, 1e-6, 1.0 - 1e-6)?;
        }
        positive("p0", self.p0)?;
        not_negative("acceleration_zero_rad_s2", self.acceleration_zero_rad_s2)
    }
}

const SOURCE: &str = "Gan, Wang, Huang, Machines 2023, 11(2), 193, equations (4) to (13)";

/// Default of lambda as a part of its bound 1 - J_M/(J_M + J_L): lambda 0.60 on the paper's axis,
/// which lies in the middle of the range that works there (scan of `study`).
const LAMBDA_SHARE_OF_BOUND: f64 = 0.775;

/// The methods `published` and `published-literal`.
#[derive(Clone, Copy, Debug)]
pub struct Published<const LITERAL: bool> {
    /// K_t T^2, N m s2/A.
    impulse: f64,
    /// J_M, kg m2.
    motor_inertia: f64,
    /// J_min, kg m2.
    threshold: f64,
    /// Diagonal of P0.
    p0: f64,
    /// Acceleration that counts as zero, rad/s2.
    acceleration_zero: f64,
}

/// State of the estimator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PublishedState {
    /// theta = [a1, a2, b0].
    parameters: [f64; 3],
    /// P.
    covariance: [[f64; 3]; 3],
    /// Motor position one and two ticks ago, rad.
    position: [f64; 2],
    /// Whether the reference acceleration was zero at the last tick.
    was_zero: bool,
    /// ES.
    engagement: i8,
    /// theta_b, rad.
    gap_angle: f64,
    /// dtheta_c, the latched step of the motor, rad.
    coasting: f64,
}

/// The method `published`.
pub type UsualGain = Published<false>;
/// The method `published-literal`.
pub type GainAsPrinted = Published<true>;

static USUAL: MethodInfo = MethodInfo {
    name: "published",
    summary: "recursive least squares of the carried inertia; the gap angle is summed up while it is small (usual gain)",
    knows: Knowledge {
        load_scale: false,
        gap: false,
        load: false,
    },
    source: SOURCE,
};

static AS_PRINTED: MethodInfo = MethodInfo {
    name: "published-literal",
    summary: "the same with the least squares' gain as printed, which diverges for large P0",
    knows: Knowledge {
        load_scale: false,
        gap: false,
        load: false,
    },
    source: SOURCE,
};

impl<const LITERAL: bool> Registered for Published<LITERAL> {
    const INFO: &'static MethodInfo = if LITERAL { &AS_PRINTED } else { &USUAL };

    fn from_axis(config: &AxisConfig) -> Self {
        Published::new(config)
    }
}

impl<const LITERAL: bool> Published<LITERAL> {
    fn new(config: &AxisConfig) -> Self {
        let settings = &config.compensation.published;
        let period = config.servo_period_s();
        // the bound of lambda follows from both inertias
        let motor_inertia = config.motor_side_inertia_kgm2();
        let load_inertia = config.reflected_load().inertia_kgm2;
        let lambda = settings
            .lambda
            .unwrap_or(LAMBDA_SHARE_OF_BOUND * load_inertia / (motor_inertia + load_inertia));
        Published {
            impulse: config.motor.torque_constant_nm_per_a * period * period,
            motor_inertia,
            threshold: motor_inertia / (1.0 - lambda),
            p0: settings.p0,
            acceleration_zero: settings.acceleration_zero_rad_s2,
        }
    }

    /// P0, same for all three parameters.
    fn start_covariance(&self) -> [[f64; 3]; 3] {
        [
            [self.p0, 0.0, 0.0],
            [0.0, self.p0, 0.0],
            [0.0, 0.0, self.p0],
        ]
    }

    /// Equations (6) and (7).
    fn least_squares(&self, state: &mut PublishedState, phi: &[f64; 3], position: f64) {
        // P phi, which gain and covariance share
        let p_phi = state
            .covariance
            .map(|row| row[0] * phi[0] + row[1] * phi[1] + row[2] * phi[2]);
        let denominator = 1.0 + phi[0] * p_phi[0] + phi[1] * p_phi[1] + phi[2] * p_phi[2];
        let [a1, a2, b0] = state.parameters;
        let error = position - (phi[0] * a1 + phi[1] * a2 + phi[2] * b0);
        // (6): the printed gain lacks the denominator of the least squares
        let gain = if LITERAL { error } else { error / denominator };
        for (parameter, direction) in state.parameters.iter_mut().zip(p_phi) {
            *parameter += direction * gain;
        }
        // (7), with the symmetric P: P phi phi' P = (P phi)(P phi)'
        for (row, left) in state.covariance.iter_mut().zip(p_phi) {
            for (entry, right) in row.iter_mut().zip(p_phi) {
                *entry -= left * right / denominator;
            }
        }
    }

    /// Equation (10).
    fn inertia(&self, state: &PublishedState) -> f64 {
        // a2 K_t T^2/b0 = J and (-a1 - 1) K_t T^2/b0 = J by (5): two estimates of one inertia
        let [a1, a2, b0] = state.parameters;
        (a2 * self.impulse / b0).max((-a1 - 1.0) * self.impulse / b0)
    }
}

impl<const LITERAL: bool> Compensator for Published<LITERAL> {
    type State = PublishedState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, motor_position: f64) -> PublishedState {
        PublishedState {
            // (9): J = J_M and b_v = 0 in (5)
            parameters: [-2.0, 1.0, self.impulse / self.motor_inertia],
            covariance: self.start_covariance(),
            position: [motor_position; 2],
            was_zero: true,
            engagement: 0,
            gap_angle: 0.0,
            coasting: 0.0,
        }
    }

    fn step(&self, state: &mut PublishedState, signals: &Signals) -> Correction {
        let position = signals.motor_position;
        // (5): regressor of the second-order difference equation
        let phi = [-state.position[0], -state.position[1], signals.current];
        let acceleration = signals.reference.acceleration;
        // the sign of the acceleration, with the tolerance for rounding
        let zero = acceleration.abs() <= self.acceleration_zero;
        // sign(alpha_ref) of (11)
        let direction = if zero { 0 } else { acceleration.signum() as i8 };

        self.least_squares(state, &phi, position);
        // (8): excitation begins, the covariance is reset
        if !zero && state.was_zero {
            state.covariance = self.start_covariance();
        }
        state.was_zero = zero;

        let inertia = self.inertia(state);
        // (10), and the threshold of (11) and (12)
        let small = inertia.abs() <= self.threshold;
        let step = position - state.position[0];
        let before = state.engagement;
        // (11): the inertia shows that a flank has been met, or has given way
        if inertia > self.threshold && before == 0 {
            state.engagement = direction;
        } else if small && before == -direction {
            state.engagement = 0;
        }
        // the flank has just given way: the load is taken to coast at the motor's present speed
        if state.engagement == 0 && before != 0 {
            state.coasting = step;
        }
        // (12): the motor moves relative to the coasting load
        if small && before == 0 {
            state.gap_angle += step - state.coasting;
        }
        // shift the regressor for the next tick
        state.position = [position, state.position[0]];
        Correction {
            // (13): the position loop sees theta_M - theta_b
            feedback: state.gap_angle,
            gap_angle_estimate: state.gap_angle,
            inertia_estimate: inertia,
            engagement_estimate: match state.engagement {
                1 => Engagement::Positive,
                -1 => Engagement::Negative,
                _ => Engagement::Gap,
            },
            ..Correction::NONE
        }
    }
}
