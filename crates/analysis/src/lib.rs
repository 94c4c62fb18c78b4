//! Linear analysis of an axis: margins of its loops, stability, limit cycles through the gap.
//!
//! - [`analyse`]: gain and phase margin, crossover and bandwidth of current, velocity and position
//!   loop, on a flank and in the gap, from the exact model in discrete time (`model`), with every
//!   delay of the drive; and which loop is unstable or has too little margin.
//! - [`limit_cycle`]: the oscillation through the gap that the describing function predicts.
//! - [`simulated_cycle`]: the oscillation that the simulated axis shows after a push;
//!   [`CycleDetector`] finds it in any run.
//!
//! While an axis is simulated nothing here runs, except a detector that was asked for.

mod cycle;
mod describing;
mod loops;
mod margins;

mod model;
mod response;

pub use cycle::{Cycle, CycleDetector, simulated_cycle};
pub use describing::{LimitCycle, limit_cycle};
pub use loops::{AxisAnalysis, Fault, LoopAnalysis, LoopDelays, LoopKind, Regime, analyse};
pub use margins::Margins;
pub use model::Feedback;
