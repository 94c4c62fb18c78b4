//! Stiffness and damping of the shaft, estimated while the axis runs: the outlook of the paper.
//!
//! On a flank motor and load are two masses on a spring. What tells the spring is whatever makes
//! them swing against each other: the blow when the motor meets a flank, a step of the current, a
//! load that sticks while the torque on it changes. So:
//! 1. The torque behind the motor is watched by a quick and by a slow momentum observer; where they
//!    part suddenly, something has hit (`watch`).
//! 2. The motor's position and current of the 60 ms from there on are kept. Excerpts that begin a
//!    little later each time are held against the engaged axis, solved exactly (`model`), once with
//!    the load sliding and once with the load held: position, speed, twist and its rate at the
//!    start and the load's torque enter linearly and are projected out (`window`), stiffness,
//!    damping and inertia are found by Gauss-Newton (`fit`).
//! 3. An excerpt counts if the noise of the encoder explains what is left, or next to nothing is,
//!    and if a rigid mass explains it far worse. That fails as long as the motor is in the gap,
//!    bounces, or the load sets out to slide; what is left must look like noise, and torque and
//!    load must keep their sign in what was found. Where a load that slides and one that is held
//!    explain an excerpt alike, it says nothing. The sharpest excerpt of a window is taken
//!    (`reading`).
//! 4. Of the last eight readings the largest group that agrees is believed, as for the gap
//!    (`readings`).
//!
//! Signals: motor position (rad), current and its mean over the servo period (A). Known: torque
//! constant, inertia and friction of the motor, resolution of its encoder; the load's inertia where
//! the method has learned it (else it is found along with the rest). Neither gap nor load nor any
//! reference enters. Needs: blows or steps that move the shaft by some ten steps of the encoder
//! (the fit's own doubt tells), a natural frequency of 12 Hz to 1 kHz and at least two periods on
//! the flank. Says nothing (not a number) until then: an axis in smooth motion, or without a gap,
//! does not excite its shaft. Fails: where friction of the load is viscous for the most part, its
//! damping counts as the shaft's. Contact laws other than the linear one are taken for it. It is no
//! compensator: what it finds is told, and changes nothing.

mod fit;
mod model;
mod reading;
mod window;

use crate::AxisConfig;
use crate::readings::Readings;
use fit::{Found, ShaftPrior};
use lostmotion_drive::Signals;
use model::ShaftMotor;
use reading::ShaftReading;
use serde::{Deserialize, Serialize};
use window::ShaftWatch;

/// Standard deviation of ln 1/J_L of an inertia that a method has learned.
const LEARNED: f64 = 0.05;
/// Standard deviation over value up to which stiffness and damping are told.
const TOLD: [f64; 2] = [0.1, 0.2];
/// Of the damping ratio a reading is no surer than this.
const LEAST_DAMPING_DOUBT: f64 = 2e-3;
/// Standard deviation over value from which on a reading says nothing of the damping.
const VAGUE: f64 = 0.1;
/// Ticks after a reading until the next one, once the stiffness is known.
const PAUSE: u32 = 2000;
/// Readings that agree from which on something is told, and from which on it is known well.
const AGREE: u32 = 2;
const KNOWN: u32 = 3;

/// What is estimated of a shaft, and the standard deviation of each over its value; not numbers
/// where nothing is known.
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

/// What it has found, and what it is about.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ShaftState {
    watch: ShaftWatch,
    reading: Option<ShaftReading>,
    stiffness: Readings,
    damping: Readings,
    pause: u32,
}

impl ShaftEstimator {
    /// For an axis; only what a drive knows of its motor is taken from the description.
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
        let prior: ShaftPrior = load_inertia
            .filter(|inertia| *inertia > 0.0)
            .map(|inertia| (1.0 / inertia, LEARNED));
        let window = state.watch.step(&self.motor, signals);
        state.pause = state.pause.saturating_sub(1);
        if let Some(window) = window
            && state.reading.is_none()
            && state.pause == 0
        {
            state.reading = Some(ShaftReading::new(window));
        }
        let near = (state.stiffness.count >= KNOWN).then_some(state.stiffness.value);
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

    fn take(&self, state: &mut ShaftState, found: &Found) {
        let (shaft, [of_stiffness, of_ratio]) = (found.shaft, found.doubt);
        let k = shaft.stiffness;
        let per_ratio = 2.0 * k / shaft.frequency(&self.motor);
        let variance = per_ratio
            * per_ratio
            * (of_ratio * of_ratio + LEAST_DAMPING_DOUBT * LEAST_DAMPING_DOUBT);
        state
            .stiffness
            .take(k, of_stiffness * of_stiffness * k * k, false, true);
        // readings of one move after the other err alike, so that many vague ones make no sharp one
        if of_ratio < VAGUE * shaft.damping_ratio {
            state
                .damping
                .take(shaft.damping(&self.motor), variance, false, true);
        }
        state.pause = if state.stiffness.count >= KNOWN {
            PAUSE
        } else {
            0
        };
    }
}

impl ShaftState {
    /// What is known now.
    pub fn estimate(&self) -> ShaftEstimate {
        let sure =
            |readings: &Readings, most: f64| readings.count >= AGREE && readings.doubt() < most;
        let told = |readings: &Readings, most: f64| {
            if sure(readings, most) {
                [readings.value, readings.doubt()]
            } else {
                [f64::NAN; 2]
            }
        };
        let ([stiffness, stiffness_doubt], [damping, damping_doubt]) =
            (told(&self.stiffness, TOLD[0]), told(&self.damping, TOLD[1]));
        ShaftEstimate {
            stiffness_nm_per_rad: stiffness,
            stiffness_doubt,
            damping_nm_s_per_rad: damping,
            damping_doubt,
        }
    }
}
