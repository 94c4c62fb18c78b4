//! Tests of the planner from the outside: limits, corners, overrides, generated programs, a reference optimiser.
#![allow(clippy::panic, clippy::unwrap_used)]

mod bounded;
mod common;
mod corners;
mod five_axes;
mod generated;
mod limits;
mod motion;
mod never_slower;
mod optimal;
mod optimal_generated;
mod overrides;
mod pace;
mod reference;
mod tangents;
mod tube;
