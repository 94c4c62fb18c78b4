//! One axis of the machine: reference spline, servo, motor, shaft with a gap, friction, and the compensator.
//!
//! Inside, everything is **motor-side**: angles in rad at the motor shaft, the load's inertia reflected. The axis' own unit
//! (mm, deg or rad at the load) appears only at the boundary, through [`config::Transmission`].

pub mod compensation;
pub mod config;
pub mod error;
pub mod plant;
pub mod reference;
pub mod runner;
pub mod servo;
pub mod signal;

pub use compensation::registry::{METHODS, Method, build_runner, find_method};
pub use compensation::{Compensator, Correction, Knowledge, MethodInfo, Signals};
pub use config::{AxisConfig, AxisConfigError};
pub use error::AxisError;
pub use runner::{AxisOutput, AxisRunner, AxisSim, AxisState, SAMPLES_PER_SETPOINT};
pub use signal::{AxisSample, Engagement, Reference, Setpoint};
