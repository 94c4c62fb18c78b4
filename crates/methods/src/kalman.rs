//! An extended Kalman filter with gap angle and half gap among its states; the gap it finds is
//! crossed on a planned traverse.
//!
//! Model, states and noises: `filter` beside this file. Extended: the flank is the one that the
//! mean itself presses on,
//! ```text
//! s = 1 where theta_b > b,  -1 where theta_b < -b,  else no contact;   the filter takes the linear step of that flank
//! ```
//! The half gap is learned where the motor meets a flank sooner or later than the filter thought.
//! It starts from zero and grows: a half gap that is thought too large is met too soon, which a
//! filter that believes itself in the gap puts down to noise; it unlearns slowly.
//!
//! Use: once its standard deviation is below a fifth of it and it agreed within a fifth at the last
//! three changes of flank, the half gap goes to the traverse of `crossing`. Signals: references,
//! motor position (rad), current (A): motor side. It is told the load's inertia and friction and
//! the shaft, **not the gap**. Tunables: noise of the torques (N m), standard deviation of the half
//! gap at the start (as a total gap), how far it may wander (per square root of s).
//!
//! Fails: where what it is told of load and friction is wrong by more than the noise it was given,
//! since then the difference is explained with the gap. With a load so free and slow that contact
//! is not felt through the encoder's steps the gap stays at what it was. Source: Kalman filtering
//! with dead zone and backlash size as states after Lagerberg and Egardt, IEEE Trans. Control Syst.
//! Technol. 15 (2007); here from the motor's side alone.

use crate::AxisConfig;
use crate::crossing::{Crossing, CrossingState};
use crate::filter::{Belief, Filter, HALF_GAP, Noises};
use crate::registry::Registered;
use crate::trust::Trust;
use lostmotion_drive::signal::Engagement;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// The method `kalman`.
#[derive(Clone, Debug)]
pub struct Kalman {
    filter: Filter,
    crossing: Crossing,
}

/// The belief and where the traverse is.
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
        let contact = flank(&state.belief);
        self.filter.predict(&mut state.belief, contact, current);
        self.filter
            .update(&mut state.belief, signals.motor_position);
        if !state.belief.is_finite() {
            state.belief = self.filter.initial(signals.motor_position);
        }
        let now = flank(&state.belief);
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
