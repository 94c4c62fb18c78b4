//! Stiffness and damping of the shaft, estimated while the axis runs: the second item of the
//! paper's outlook.
//!
//! In contact, motor and load are two masses on a spring. What excites the spring makes them swing
//! against each other: the blow when the motor meets a flank, a step of the current, a load that
//! sticks while the torque on it changes. The motor's part of the oscillation is `J_L/J_T`, its
//! frequency gives `k (1/J_M + 1/J_L)`, its decay `d (1/J_M + 1/J_L)/2`, its answer to the current
//! `k/J_L` (k in N m/rad, d in N m s/rad). So:
//!
//! 1. A fast and a slow momentum observer watch the torque behind the motor; where they suddenly
//!    differ, a blow is detected (`window`).
//! 2. The motor's position and current of the 60 ms from there on are recorded. Excerpts that begin a
//!    little later each time are compared with the engaged axis, solved exactly (`model`), once with
//!    the load sliding and once with the load held: position, speed, twist and its rate at the start
//!    and the load's torque enter linearly and are projected out; stiffness, damping and inertia are
//!    found by Gauss-Newton (`fit`).
//! 3. An excerpt counts if the encoder's noise explains its residual, or hardly any is left, and if a
//!    rigid mass explains it far worse. That fails as long as the motor is in the gap, bounces, or the
//!    load starts to slide; the residual has to look like noise, and torque and load have to keep their
//!    sign in the solution. Where a load that slides and one that is held explain an excerpt equally
//!    well, it says nothing. The most certain excerpt of a window is the reading (`reading`).
//! 4. Of the last eight readings the largest group that agrees is believed, as for the gap
//!    (`readings`).
//!
//! Signals: motor position (rad), current and its mean over the servo period (A). Known: torque
//! constant, inertia and friction of the motor, resolution of its encoder; the load's inertia where
//! the method has learned it (otherwise it is estimated along with the rest). Neither gap nor load
//! nor any reference enters. Settings: `compensation.estimate_shaft`. It is no compensator: it
//! reports, and changes no bit of the motion.
//!
//! Needs: blows or steps that move the shaft by some ten counts of the encoder, a natural frequency
//! of 12 Hz to 1 kHz, and at least two periods on the flank. Until then it reports NaN: an axis in
//! smooth motion, or without a gap, does not excite its shaft. Fails: where the load's friction is
//! mostly viscous, its damping counts as the shaft's; contact laws other than the linear one are
//! taken for it.
//!
//! Source: this project; variable projection after Golub and Pereyra (1973).
//!
//! [`Observed`] is a compensator with the estimator beside it: the corrections are the compensator's
//! own, bit by bit; only the estimates of stiffness and damping are added.

mod fit;
mod model;
mod reading;
mod window;

use crate::AxisConfig;
use crate::readings::Readings;
use fit::{Found, ShaftPrior};
use lostmotion_drive::{
    Compensator, Correction, Heeded, Learned, Learning, MethodInfo, Signals, Twinned,
};
use model::ShaftMotor;
use reading::ShaftReading;
use serde::{Deserialize, Serialize};
use window::ShaftWatch;

/// Standard deviation of ln 1/J_L of an inertia that a method has learned. A choice: tighter forces
/// an error of the inertia on the stiffness, looser leaves both open.
const LEARNED_INERTIA_DOUBT: f64 = 0.05;
/// Largest standard deviations of stiffness and damping that are reported, parts of the value. A
/// choice: damping shows half as well as stiffness.
const LARGEST_DOUBTS: [f64; 2] = [0.1, 0.2];
/// Least standard deviation of a reading's damping ratio: errors of the model. A choice: a fifth of
/// a per cent of critical damping.
const LEAST_DAMPING_DOUBT: f64 = 2e-3;
/// Standard deviation of the damping ratio, part of its value, from which on a reading says nothing
/// of the damping: many vague readings that err alike must not make a sharp one.
const VAGUE_DAMPING_DOUBT: f64 = 0.1;
/// Servo ticks from a reading to the next one once the stiffness is known: 0.5 s. A choice:
/// stiffness drifts far more slowly, and readings cost time.
const PAUSE_TICKS: u32 = 2000;
/// Readings that agree from which on an estimate is reported: decision 61 of the book.
const READINGS_TO_REPORT: u32 = 2;
/// Readings that agree from which on the stiffness is known well enough to narrow the search. A
/// choice: one more than is needed to report, since a narrowed search finds no other valley any
/// more.
const READINGS_TO_KNOW: u32 = 3;

/// Estimates of a shaft, with the standard deviation of each over its value; NaN where nothing is
/// known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShaftEstimate {
    /// Stiffness, N m/rad at the motor.
    pub stiffness_nm_per_rad: f64,
    /// Standard deviation over value.
    pub stiffness_doubt: f64,
    /// Damping, N m s/rad at the motor.
    pub damping_nm_s_per_rad: f64,
    /// Standard deviation over value.
    pub damping_doubt: f64,
}

impl ShaftEstimate {
    /// Nothing is known.
    pub const NOTHING: ShaftEstimate = ShaftEstimate {
        stiffness_nm_per_rad: f64::NAN,
        stiffness_doubt: f64::NAN,
        damping_nm_s_per_rad: f64::NAN,
        damping_doubt: f64::NAN,
    };
}

/// The estimator of one axis: immutable.
#[derive(Clone, Debug)]
pub struct ShaftEstimator {
    motor: ShaftMotor,
}

/// The readings so far, and the one under way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ShaftState {
    watch: ShaftWatch,
    reading: Option<ShaftReading>,
    stiffness: Readings,
    damping: Readings,
    /// Servo ticks until the next reading.
    pause: u32,
}

impl ShaftEstimator {
    /// For an axis whose description has been checked; only the motor's data are used.
    pub fn new(config: &AxisConfig) -> ShaftEstimator {
        ShaftEstimator {
            motor: ShaftMotor::new(config),
        }
    }

    /// One servo tick; with the load's inertia (kg m2) if it has been learned.
    pub fn step(
        &self,
        state: &mut ShaftState,
        signals: &Signals,
        load_inertia: Option<f64>,
    ) -> ShaftEstimate {
        // a learned inertia is a prior, no fact
        let prior: ShaftPrior = load_inertia
            .filter(|inertia| *inertia > 0.0)
            .map(|inertia| (1.0 / inertia, LEARNED_INERTIA_DOUBT));
        let window = state.watch.step(&self.motor, signals);
        state.pause = state.pause.saturating_sub(1);
        if let Some(window) = window
            && state.reading.is_none()
            && state.pause == 0
        {
            state.reading = Some(ShaftReading::new(window));
        }
        // a stiffness that is known well narrows the search to its neighbourhood
        let near = (state.stiffness.count >= READINGS_TO_KNOW).then_some(state.stiffness.value);
        if let Some(found) = state
            .reading
            .as_mut()
            .and_then(|reading| reading.work(&self.motor, prior, near))
        {
            state.reading = None;
            if let Some(found) = found {
                self.take(state, &found);
            }
        }
        state.estimate()
    }

    /// Adds the result of a window to the readings.
    fn take(&self, state: &mut ShaftState, found: &Found) {
        let (shaft, [of_stiffness, of_ratio]) = (found.shaft, found.doubt);
        let k = shaft.stiffness;
        // d = 2 zeta k/omega: from the damping ratio to the damping, and its variance
        let per_ratio = 2.0 * k / shaft.frequency(&self.motor);
        let variance = per_ratio
            * per_ratio
            * (of_ratio * of_ratio + LEAST_DAMPING_DOUBT * LEAST_DAMPING_DOUBT);
        state
            .stiffness
            .take(k, of_stiffness * of_stiffness * k * k, false, true);
        // repeated moves give equal errors, so vague readings would agree and look sharp
        if of_ratio < VAGUE_DAMPING_DOUBT * shaft.damping_ratio {
            state
                .damping
                .take(shaft.damping(&self.motor), variance, false, true);
        }
        // once the stiffness is known, readings only follow its drift
        state.pause = if state.stiffness.count >= READINGS_TO_KNOW {
            PAUSE_TICKS
        } else {
            0
        };
    }
}

impl ShaftState {
    /// The estimates now.
    pub fn estimate(&self) -> ShaftEstimate {
        let sure = |readings: &Readings, most: f64| {
            readings.count >= READINGS_TO_REPORT && readings.doubt() < most
        };
        let told = |readings: &Readings, most: f64| {
            if sure(readings, most) {
                [readings.value, readings.doubt()]
            } else {
                [f64::NAN; 2]
            }
        };
        let ([stiffness, stiffness_doubt], [damping, damping_doubt]) = (
            told(&self.stiffness, LARGEST_DOUBTS[0]),
            told(&self.damping, LARGEST_DOUBTS[1]),
        );
        ShaftEstimate {
            stiffness_nm_per_rad: stiffness,
            stiffness_doubt,
            damping_nm_s_per_rad: damping,
            damping_doubt,
        }
    }
}

/// A compensator and an observer of its axis' shaft.
#[derive(Clone, Debug)]
pub struct Observed<C> {
    compensator: C,
    shaft: ShaftEstimator,
    motor_inertia: f64,
}

/// The compensator's state and the estimator's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObservedState<S> {
    compensator: S,
    shaft: ShaftState,
}

impl<C: Compensator> Observed<C> {
    /// On an axis whose description has been checked.
    pub fn new(compensator: C, config: &AxisConfig) -> Observed<C> {
        Observed {
            compensator,
            shaft: ShaftEstimator::new(config),
            motor_inertia: config.motor_side_inertia_kgm2(),
        }
    }
}

impl<C: Compensator> Observed<C> {
    /// Adds the estimates of stiffness and damping to a correction.
    fn watch(
        &self,
        state: &mut ShaftState,
        signals: &Signals,
        correction: Correction,
    ) -> Correction {
        // a method that learns the load reports the inertia of motor and load together
        let learned = correction.inertia_estimate - self.motor_inertia;
        let load_inertia = (C::LEARNS_LOAD && learned > 0.0).then_some(learned);
        // the estimator only listens: the correction goes on unchanged but for two estimates
        let found = self.shaft.step(state, signals, load_inertia);
        Correction {
            stiffness_estimate: found.stiffness_nm_per_rad,
            damping_estimate: found.damping_nm_s_per_rad,
            ..correction
        }
    }
}

impl<C: Compensator> Compensator for Observed<C> {
    type State = ObservedState<C::State>;

    const LEARNS_LOAD: bool = C::LEARNS_LOAD;

    const HEEDS_OTHERS: bool = C::HEEDS_OTHERS;

    fn info(&self) -> &'static MethodInfo {
        self.compensator.info()
    }

    fn initial(&self, motor_position: f64) -> Self::State {
        ObservedState {
            compensator: self.compensator.initial(motor_position),
            shaft: ShaftState::default(),
        }
    }

    fn make_room(&self, state: &mut Self::State) {
        self.compensator.make_room(&mut state.compensator);
    }

    fn step(&self, state: &mut Self::State, signals: &Signals) -> Correction {
        let correction = self.compensator.step(&mut state.compensator, signals);
        self.watch(&mut state.shaft, signals, correction)
    }

    fn learned(&self, state: &Self::State) -> Option<Learned> {
        self.compensator.learned(&state.compensator)
    }

    fn readiness(&self, state: &Self::State) -> Option<f64> {
        self.compensator.readiness(&state.compensator)
    }

    fn heed(&self, state: &mut Self::State, heeded: Heeded) {
        self.compensator.heed(&mut state.compensator, heeded);
    }

    fn foreseen<'a>(&self, state: &'a Self::State) -> &'a [Option<[f64; 2]>] {
        self.compensator.foreseen(&state.compensator)
    }

    fn learning(&self, state: &Self::State) -> Option<Learning> {
        self.compensator.learning(&state.compensator)
    }

    fn begin<'a>(&'a self, state: &'a mut Self::State, signals: &Signals) -> Option<Twinned<'a>> {
        self.compensator.begin(&mut state.compensator, signals)
    }

    fn finish(&self, state: &mut Self::State, signals: &Signals) -> Correction {
        let correction = self.compensator.finish(&mut state.compensator, signals);
        self.watch(&mut state.shaft, signals, correction)
    }
}
