//! An extended Kalman filter with gap angle and half gap among its states; the gap it finds is crossed on a planned traverse.
//!
//! Model, states and noises: `filter` beside this file. Extended: the flank is the one that the mean itself presses on,
//! ```text
//! s = 1 where theta_b > b,  -1 where theta_b < -b,  else no contact;   the filter takes the linear step of that flank
//! ```
//! The half gap is learned where the motor meets a flank sooner or later than the filter thought. It starts from zero and grows: a half gap
//! that is thought too large is met too soon, which a filter that believes itself in the gap puts down to noise; it unlearns slowly.
//!
//! Use: after two crossings, and once its standard deviation is below a fifth of it, the half gap goes to the traverse of `crossing`.
//! Signals: references, motor position (rad), current (A): motor side. It is told the load's inertia and friction and the shaft, **not the gap**.
//! Tunables: noise of the torques (N m), standard deviation of the half gap at the start (as a total gap), how far it may wander (per square root of s).
//!
//! Fails: where what it is told of load and friction is wrong by more than the noise it was given, since then the difference is explained with the gap. With a
//! load so free and slow that contact is not felt through the encoder's steps the gap stays at what it was.
//! Source: Kalman filtering with dead zone and backlash size as states after Lagerberg and Egardt, IEEE Trans. Control Syst. Technol. 15 (2007); here
//! from the motor's side alone.

use super::crossing::{Crossing, CrossingState};
use super::filter::{Belief, Filter, HALF_GAP};
use super::registry::Registered;
use super::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use crate::config::AxisConfig;
use crate::signal::Engagement;
use serde::{Deserialize, Serialize};

/// Crossings before the half gap is used.
const CROSSINGS: u32 = 2;
/// Standard deviation over half gap, at most, for use.
const SURE: f64 = 0.2;

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
    side: i8,
    crossings: u32,
}

impl Registered for Kalman {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "kalman",
        summary: "extended Kalman filter from the motor's side with gap angle and half gap as states; planned traverse",
        knows: Knowledge { load_scale: false, gap: false, load: true },
        source: "after Lagerberg and Egardt, IEEE Trans. Control Syst. Technol. 15 (2007)",
    };

    fn from_axis(config: &AxisConfig) -> Kalman {
        let settings = &config.compensation.kalman;
        Kalman {
            filter: Filter::new(config, &settings.noises(config)),
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
        KalmanState { belief: self.filter.initial(motor_position), crossing, current: 0.0, side: 0, crossings: 0 }
    }

    fn step(&self, state: &mut KalmanState, signals: &Signals) -> Correction {
        let current = Filter::mean_current(state.current, signals);
        state.current = signals.current;
        let contact = flank(&state.belief);
        self.filter.predict(&mut state.belief, contact, current);
        self.filter.update(&mut state.belief, signals.motor_position);
        if !state.belief.is_finite() {
            state.belief = self.filter.initial(signals.motor_position);
        }
        let now = flank(&state.belief);
        if now != 0 && now != state.side {
            state.crossings = state.crossings.saturating_add(u32::from(state.side != 0));
            state.side = now;
        }
        let half_gap = state.belief.mean[HALF_GAP];
        let sure = state.crossings >= CROSSINGS && state.belief.half_gap_spread() < SURE * half_gap;
        let crossing = self.crossing.step(&mut state.crossing, signals, self.filter.load(), if sure { half_gap } else { 0.0 });
        Correction { gap_angle_estimate: state.belief.mean[super::filter::GAP_ANGLE], engagement_estimate: Engagement::of_sign(now), ..crossing }
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
