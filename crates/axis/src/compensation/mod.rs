//! Backlash compensators: one file each, one line in the registry.
//!
//! A compensator is a block that runs at the servo rate (250 us). Its configuration is immutable
//! and shared, its state is small, cloneable and serialisable. It sees only what a drive has;
//! [`MethodInfo::knows`] says what it needs beyond that.

pub mod adaptive;
pub mod adaptive_inverse;
mod crossing;
pub mod disturbance_observer;
mod filter;
pub mod fitted_lookup;
pub mod fixed;
pub mod fixed_fanuc;
pub mod fixed_linuxcnc;
pub mod iterative_learning;
pub mod kalman;
mod linear;
pub mod load_feedback;
pub mod lookup;
pub mod multiple_models;
pub mod none;
pub mod observed;
mod passage;
pub mod published;
mod ramp;
mod readings;
pub mod registry;
pub mod reversal_pulse;
pub mod shaft;
mod strokes;
mod traverse;
mod trust;
mod twin;

pub(crate) use filter::Noises;
pub use twin::Twinned;
pub(crate) use twin::{MotorNumbers, Rates, Twin, TwinState};

use crate::signal::{Engagement, Reference};
use serde::{Deserialize, Serialize};

/// What a method may know beyond the signals that every drive has (motor encoder, current,
/// references, motor data sheet).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Knowledge {
    /// It measures the load (a linear scale or a second encoder).
    pub load_scale: bool,
    /// It is told the gap.
    pub gap: bool,
    /// It is told the load's inertia and friction.
    pub load: bool,
}

/// What every compensator declares about itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MethodInfo {
    /// Name on the command line and in files.
    pub name: &'static str,
    /// One line for people.
    pub summary: &'static str,
    /// What it may know.
    pub knows: Knowledge,
    /// Where the method comes from.
    pub source: &'static str,
}

/// What a drive knows at a servo tick, motor side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Signals {
    /// Reference at this tick (rad, rad/s, rad/s2).
    pub reference: Reference,
    /// Reference one servo tick ahead; the spline's delay makes it known.
    pub next_reference: Reference,
    /// Motor position from its encoder, rad, quantised.
    pub motor_position: f64,
    /// Motor velocity as the drive computes it, rad/s.
    pub motor_velocity: f64,
    /// Measured torque-forming current, A.
    pub current: f64,
    /// Mean of the torque-forming current over the last servo period, from the samples of the
    /// current loop, A.
    pub mean_current: f64,
    /// Whether the drive was at its current or voltage limit in the last period.
    pub saturated: bool,
    /// Load position from its scale, rad at the motor shaft; only for methods whose
    /// [`Knowledge::load_scale`] is set and machines that have one.
    pub load_position: Option<f64>,
}

/// A compensator's output at a servo tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction {
    /// Added to the position reference, rad.
    pub position: f64,
    /// Added to the velocity feed-forward, rad/s.
    pub velocity: f64,
    /// Added to the torque feed-forward, N m.
    pub torque: f64,
    /// Subtracted from the measured motor position before the position loop sees it, rad
    /// (the published method feeds back theta_M - theta_b_hat).
    pub feedback: f64,
    /// Estimate of theta_M - theta_L, rad; NaN if none.
    pub gap_angle_estimate: f64,
    /// Estimate of the inertia the motor carries, kg m2; NaN if none.
    pub inertia_estimate: f64,
    /// Estimate of the engagement.
    pub engagement_estimate: Engagement,
    /// Estimate of the shaft's stiffness, N m/rad at the motor; NaN if none.
    pub stiffness_estimate: f64,
    /// Estimate of the shaft's damping, N m s/rad at the motor; NaN if none.
    pub damping_estimate: f64,
}

impl Correction {
    /// No correction and no estimate.
    pub const NONE: Correction = Correction {
        position: 0.0,
        velocity: 0.0,
        torque: 0.0,
        feedback: 0.0,
        gap_angle_estimate: f64::NAN,
        inertia_estimate: f64::NAN,
        engagement_estimate: Engagement::Gap,
        stiffness_estimate: f64::NAN,
        damping_estimate: f64::NAN,
    };

    /// Whether every output is a number that a drive could act on. A drive ignores an output that
    /// is not, for that tick.
    pub fn is_usable(&self) -> bool {
        [self.position, self.velocity, self.torque, self.feedback]
            .iter()
            .all(|output| output.abs() < UNUSABLE)
    }

    /// The estimates without any output.
    #[must_use]
    pub fn without_output(self) -> Correction {
        Correction {
            position: 0.0,
            velocity: 0.0,
            torque: 0.0,
            feedback: 0.0,
            ..self
        }
    }
}

/// An output beyond this (rad, rad/s, N m) has run away.
const UNUSABLE: f64 = 1e9;

/// A backlash compensator.
pub trait Compensator: Send + Sync + 'static {
    /// What it carries from tick to tick.
    type State: Clone + Send + Sync + Serialize + for<'de> Deserialize<'de>;

    /// Whether it answers [`Correction::NONE`] to whatever it sees, so that nobody needs to ask.
    const PASSIVE: bool = false;

    /// Whether its [`Correction::inertia_estimate`] is motor and load together, learned for good,
    /// and not what the motor carries at the moment.
    const LEARNS_LOAD: bool = false;

    /// What it says of itself.
    fn info(&self) -> &'static MethodInfo;

    /// State before the first tick, standing still at `motor_position` rad.
    fn initial(&self, motor_position: f64) -> Self::State;

    /// One servo tick.
    fn step(&self, state: &mut Self::State, signals: &Signals) -> Correction;

    /// What a tick does before the method's own model of the axis is stepped, and that model;
    /// nothing for a method that has none. [`Compensator::step`] is this, the model's step, and
    /// [`Compensator::finish`]; who runs many axes steps their models side by side.
    fn begin<'a>(&'a self, _state: &'a mut Self::State, _signals: &Signals) -> Option<Twinned<'a>> {
        None
    }

    /// The rest of a tick that was begun.
    fn finish(&self, state: &mut Self::State, signals: &Signals) -> Correction {
        self.step(state, signals)
    }
}
