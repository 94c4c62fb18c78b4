//! How far the tool left the programmed contour, where, and why.
//!
//! [`ContourTracker`] holds the stretch of programmed path around the command and measures samples
//! against it; it is shared by all machines that follow the same plan, each with a [`FootState`] of
//! its own. Its samples go into [`Statistics`], a [`BlockLedger`] and a [`ReversalLedger`],
//! each of constant size whatever the program's length. Everything is data.

pub mod ballbar;
pub mod cause;
pub mod circular;
pub mod ledger;
pub mod reversal;
mod side;
pub mod statistics;
pub mod tracker;
pub mod types;

pub use cause::{Cause, CauseRule, Shares};
pub use circular::{Circle, CircularDeviation, Glitch, RadialPoint};
pub use ledger::{BlockLedger, BlockRow, ErrorRecord, ReversalLedger, ReversalRow};
pub use reversal::{Reversal, ReversalConfig, ReversalState};
pub use statistics::{Place, Statistics, Summary};
pub use tracker::{ContourTracker, FootPlace, FootState};
pub use types::ContourError;
pub use types::{ContourConfig, ContourInput, ContourSample, ProgrammedSegment};
