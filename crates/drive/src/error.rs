//! What can go wrong with an axis.

use crate::config::AxisConfigError;

/// Error of an axis.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AxisError {
    /// The description makes no sense.
    #[error(transparent)]
    Config(#[from] AxisConfigError),
    /// The start position is not a finite number.
    #[error("the start position is {value}; it has to be a finite number")]
    StartPosition {
        /// The value given.
        value: f64,
    },
    /// A speed or a wind-up to begin with that no axis has.
    #[error("the {what} at the start is {value}; it has to be from -{highest:.6} to {highest:.6}")]
    Start {
        /// motor velocity, load velocity or wind-up.
        what: &'static str,
        /// The value given, in the axis' unit.
        value: f64,
        /// The largest magnitude allowed.
        highest: f64,
    },
    /// A setpoint that is not a finite number.
    #[error("setpoint {tick}: its {what} is {value}; it has to be a finite number")]
    SetpointNotFinite {
        /// Number of the setpoint since the start, from 0.
        tick: u64,
        /// position, velocity or acceleration.
        what: &'static str,
        /// The value given.
        value: f64,
    },
    /// A force on the load that no machine has.
    #[error(
        "setpoint {tick}: its load_force is {value}; it has to be from -{highest} to {highest}"
    )]
    LoadForce {
        /// Number of the setpoint since the start, from 0.
        tick: u64,
        /// The value given, N or N m.
        value: f64,
        /// The largest magnitude allowed.
        highest: f64,
    },
    /// A setpoint without velocity or acceleration where the reference needs them.
    #[error(
        "setpoint {tick} comes without {what}; send it along, or set the axis' `interpolator` to one that takes positions alone, such as \"quintic-differences\""
    )]
    SetpointIncomplete {
        /// Number of the setpoint since the start, from 0.
        tick: u64,
        /// velocity or acceleration.
        what: &'static str,
    },
}
