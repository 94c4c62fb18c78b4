//! Tests of the studies from outside the crate.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::disallowed_methods,
    reason = "a test says what went wrong by panicking; expected values are found independently"
)]

mod drawn;
mod fixed_sample;
mod matrix;
mod paper;
