//! Backlash compensators: one file each, one line in the registry.
//!
//! What a compensator is stands in [`lostmotion_drive::compensator`].
//!
//! ```
//! use lostmotion_methods::{AxisConfig, AxisOutput, Setpoint, build_runner};
//!
//! let mut axis = build_runner(&AxisConfig::paper(), "published", 0.0)?;
//! let mut out = AxisOutput::new(false);
//! let slow = |n: u32| Setpoint::moving(1e-3 * f64::from(n), 1.0, 0.0);
//! for n in 0..100 {
//!     out.clear();
//!     axis.push(&[slow(n)], &mut out)?;
//!     assert_eq!(out.load.len(), 4);
//! }
//! # Ok::<(), lostmotion_drive::AxisError>(())
//! ```

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

pub use lostmotion_drive::{AxisConfig, AxisOutput, Setpoint};
pub use observed::Observed;
pub use registry::{METHODS, Method, build_runner, find_method};
pub use shaft::{ShaftEstimate, ShaftEstimator, ShaftState};
