//! Tests of the fits: accuracy, bad logs, the solver, motor-only.
#![allow(clippy::panic, clippy::unwrap_used, reason = "a test may panic")]

mod accuracy;
mod bad_logs;
mod body;
mod held_out;
mod huber;
mod load_off;
mod logged;
mod lost;
mod motor_only;
#[allow(dead_code, unreachable_pub)]
mod rig;
mod simulated_axis;
mod wrong_units;
