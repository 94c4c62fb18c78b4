//! Tests of the whole chain.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::disallowed_methods,
    reason = "a test says what went wrong by panicking; expected values are found independently"
)]

mod chain;
mod common;
mod determinism;
mod examples;
mod limits;
mod refusals;
mod snapshots;
