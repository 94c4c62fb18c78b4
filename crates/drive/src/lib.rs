//! One axis of the machine: reference spline, servo, motor, shaft with a gap, friction, and
//! what a compensator is.
//!
//! What happens to one setpoint, in order:
//! 1. [`mod@reference`]: the setpoint (every 1 ms) ends a quintic piece; four references of
//!    position, velocity and acceleration come out of it.
//! 2. [`servo`]: at each of the four servo ticks (every 250 us) the encoder is read,
//! 3. [`compensator`]: the compensator sees what a drive sees and answers with a correction,
//! 4. [`servo`]: position and velocity loop turn reference, measurement and correction into a
//!    current command,
//! 5. [`plant`]: for each of the five current periods the current loop sets a voltage and the plant
//!    takes an exact step.
//!
//! [`runner`] strings these together, [`config`] describes them. Every block keeps its immutable
//! description apart from its small, serialisable state. Inside, everything is **motor-side**:
//! angles in rad at the motor's shaft, the load's inertia reflected. The axis' own unit (mm, deg or
//! rad at the load) appears only at the boundary, through [`config::Transmission`].

pub mod batch;
pub mod compensator;
pub mod config;
pub mod error;
mod learned;
mod number;
pub mod plant;
pub mod reference;
pub mod runner;
pub mod servo;
pub mod signal;
mod sim;
mod start;
pub mod tied;
pub mod twin;

pub use batch::AxisBatch;
pub use compensator::{Compensator, Heeded, Knowledge, MethodInfo};
pub use config::{AxisConfig, AxisConfigError};
pub use error::AxisError;
pub use learned::{GapReading, Learned, Learning, ReadingVerdict};
pub use runner::{AxisOutput, AxisRunner, CurrentLoop, Monitored, Seen, TwinStep};
pub use signal::{
    AxisSample, BlockMotion, Correction, Engagement, MotorSample, Reference, Setpoint, Signals,
};
pub use sim::{AxisSim, AxisState};
pub use start::AxisStart;
pub use tied::{Tie, TiedAxes};
pub use twin::Twinned;
