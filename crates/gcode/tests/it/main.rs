//! Tests of the language: one module for each subject.
#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::disallowed_methods,
    reason = "a test says what went wrong by panicking, and std's functions are independent of those under test"
)]

mod common;
mod compensation;
mod corners;
mod curves;
mod diagnostics;
mod dialects;
mod docs;
mod expressions;
mod feeding;
mod finishing;
mod five_axis;
mod generate;
mod hostile;
mod limits;
mod manuals;
mod mistakes;
mod more_motion;
mod motion;
mod production;
mod profiles;
mod quick;
mod reading;
mod robust;
mod samples;
mod spindles;
mod tokens;
mod tool_path;
mod turning;
mod twins;
