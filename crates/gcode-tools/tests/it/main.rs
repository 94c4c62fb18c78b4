//! Tests of the tools: one module for each.
#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::disallowed_methods,
    reason = "a test says what went wrong by panicking, and std's functions are independent of those under test"
)]

#[allow(unreachable_pub, reason = "the fuzzers' crate publishes them")]
mod checks;
mod corpus;
mod docs;
mod explain;
mod lints;
mod programs;
mod rewriting;
