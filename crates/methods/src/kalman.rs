//! An extended Kalman filter with gap angle and half gap among its states; the gap that it finds is
//! crossed on a planned traverse.
//!
//! ```text
//! x = (theta_M, w_M, theta_b, w_L, b),  y = theta_M       model and noises: `filter`; rad, rad/s
//! s = 1 where theta_b > b, -1 where theta_b < -b, else no contact;   the filter takes the linear step of that flank
//! ```
//! The half gap is learned where the motor meets a flank sooner or later than the filter predicted.
//! It starts from zero and grows. It unlearns slowly: a flank that is met too soon looks like noise
//! to a filter that believes it is in the gap.
//!
//! The half gap goes to the traverse of `crossing` once its standard deviation is below a fifth of
//! it and it agreed within a fifth at the last three changes of flank.
//!
//! Signals: references, motor position (rad), current (A). It is told the load's inertia and
//! friction and the shaft, **not the gap**. Settings: noise of the torques (part of the rated
//! torque), standard deviation of the gap at the start (as a total gap), drift of the half gap
//! (part of that per square root of s), part of the drive's torque for a traverse (0 to 1).
//!
//! Fails: where load or friction differ from what it is told by more than its noise: it then
//! explains the difference with the gap. With a load so free and slow that contact does not show
//! through the encoder's steps, the gap stays at its value.
//!
//! Source: Kalman filtering with dead zone and backlash size as states after Lagerberg and Egardt,
//! IEEE Trans. Control Syst. Technol. 15 (2007); here from the motor's side alone.

use crate::AxisConfig;
use crate::crossing::{Crossing, CrossingState, TORQUE_SHARE};
use crate::filter::{Belief, Filter, HALF_GAP, Noises, Trust, check_noises};
use crate::registry::{Registered, Settings};
use lostmotion_drive::config::check::{AxisConfigError, between};
use lostmotion_drive::config::{Gap, Transmission};
use lostmotion_drive::signal::Engagement;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `kalman`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct KalmanSettings {
    /// Standard deviation of the torques that the model does not explain, as part of the rated
    /// torque.
    pub torque_noise_share: f64,
    /// Standard deviation of the unknown gap at the start, as a total gap; a two-hundredth of a
    /// turn of the motor if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap_spread: Option<Gap>,
    /// Drift of the half gap, as a part of its spread at the start per square root of s.
    pub wandering_share: f64,
    /// Part of the drive's largest torque that a traverse of the gap may take, 0 to 1.
    pub torque_share: f64,
}

impl Default for KalmanSettings {
    fn default() -> KalmanSettings {
        KalmanSettings {
            torque_noise_share: 2e-3,
            gap_spread: None,
            wandering_share: 1e-3,
            torque_share: TORQUE_SHARE,
        }
    }
}

impl Settings for KalmanSettings {
    fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        check_noises(
            self.torque_noise_share,
            self.gap_spread,
            self.wandering_share,
            transmission,
        )?;
        between("torque_share", self.torque_share, 0.01, 1.0)
    }
}

/// The method `kalman`.
#[derive(Clone, Debug)]
pub struct Kalman {
    filter: Filter,
    crossing: Crossing,
}

/// State of the filter, of the traverse, and of the trust in the half gap.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct KalmanState {
    belief: Belief,
    crossing: CrossingState,
    current: f64,
    trust: Trust,
}

impl Registered for Kalman {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "kalman",
        summary: "extended Kalman filter from the motor's side with gap angle and half gap as states; planned traverse",
        knows: Knowledge {
            load_scale: false,
            gap: false,
            load: true,
        },
        source: "after Lagerberg and Egardt, IEEE Trans. Control Syst. Technol. 15 (2007)",
    };

    fn from_axis(config: &AxisConfig) -> Kalman {
        let settings = &config.compensation.kalman;
        Kalman {
            filter: Filter::new(
                config,
                &Noises::new(
                    settings.torque_noise_share,
                    settings.gap_spread,
                    settings.wandering_share,
                    config,
                ),
            ),
            crossing: Crossing::new(config, settings.torque_share, 0.0),
        }
    }
}

impl Compensator for Kalman {
    type State = KalmanState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, motor_position: f64) -> KalmanState {
        // the twin of the crossing carries the same told load as the filter
        let crossing = self.crossing.initial(motor_position, self.filter.load());
        KalmanState {
            belief: self.filter.initial(motor_position),
            crossing,
            current: 0.0,
            trust: Trust::default(),
        }
    }

    fn step(&self, state: &mut KalmanState, signals: &Signals) -> Correction {
        let current = Filter::mean_current(state.current, signals);
        state.current = signals.current;
        // prediction with the linear model of the flank that the mean is on: the extended part
        let contact = flank(&state.belief);
        self.filter.predict(&mut state.belief, contact, current);
        self.filter
            .update(&mut state.belief, signals.motor_position);
        // diverged, as on input that is not finite: start anew
        if !state.belief.is_finite() {
            state.belief = self.filter.initial(signals.motor_position);
        }
        let now = flank(&state.belief);
        // 0 until it is trusted: the crossing then does nothing
        let half_gap = state.trust.step(
            now,
            state.belief.mean[HALF_GAP],
            state.belief.half_gap_spread(),
        );
        let crossing =
            self.crossing
                .step(&mut state.crossing, signals, self.filter.load(), half_gap);
        Correction {
            gap_angle_estimate: state.belief.mean[super::filter::GAP_ANGLE],
            engagement_estimate: Engagement::of_sign(now),
            ..crossing
        }
    }
}

/// The flank that the mean presses on, 0 for none.
fn flank(belief: &Belief) -> i8 {
    if belief.pressed(1) > 0.0 {
        1
    } else if belief.pressed(-1) > 0.0 {
        -1
    } else {
        0
    }
}
