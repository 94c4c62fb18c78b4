//! One axis of the machine: reference spline, servo, motor, shaft with a gap, friction, and the
//! compensator.
//!
//! What happens to one setpoint, in order:
//! 1. [`mod@reference`]: the setpoint (every 1 ms) ends a quintic piece; four references of
//!    position, velocity and acceleration come out of it.
//! 2. [`servo`]: at each of the four servo ticks (every 250 us) the encoder is read,
//! 3. [`compensation`]: the compensator sees what a drive sees and answers with a correction,
//! 4. [`servo`]: position and velocity loop turn reference, measurement and correction into a
//!    current command,
//! 5. [`plant`]: for each of the five current periods the current loop sets a voltage and the plant
//!    takes an exact step.
//!
//! [`runner`] strings these together, [`config`] describes them. Every block keeps its immutable
//! description apart from its small, serialisable state. Inside, everything is **motor-side**:
//! angles in rad at the motor's shaft, the load's inertia reflected. The axis' own unit (mm, deg or
//! rad at the load) appears only at the boundary, through [`config::Transmission`].
//!
//! ```
//! use lostmotion_axis::{AxisConfig, AxisOutput, Setpoint, build_runner};
//!
//! let mut axis = build_runner(&AxisConfig::paper(), "published", 0.0)?;
//! let mut out = AxisOutput::new(false);
//! let slow = |n: u32| Setpoint::moving(1e-3 * f64::from(n), 1.0, 0.0);
//! for n in 0..100 {
//!     out.clear();
//!     axis.push(&[slow(n)], &mut out)?;
//!     assert_eq!(out.load.len(), 4);
//! }
//! # Ok::<(), lostmotion_axis::AxisError>(())
//! ```

pub mod analysis;
mod axis;
pub mod batch;
pub mod compensation;
pub mod config;
mod current_loop;
pub mod error;
mod model;
pub mod plant;
pub mod reference;
pub mod runner;
pub mod servo;
pub mod signal;
pub mod tied;

pub use axis::{AxisSim, AxisState};
pub use batch::AxisBatch;
pub use compensation::observed::Observed;
pub use compensation::registry::{METHODS, Method, build_runner, find_method};
pub use compensation::shaft::{ShaftEstimate, ShaftEstimator, ShaftState};
pub use compensation::{Compensator, Correction, Knowledge, MethodInfo, Signals};
pub use config::{AxisConfig, AxisConfigError};
pub use current_loop::CurrentLoop;
pub use error::AxisError;
pub use runner::{AxisOutput, AxisRunner, Seen, TwinStep};
pub use signal::{AxisSample, Engagement, Reference, Setpoint};
pub use tied::{Tie, TiedAxes};
