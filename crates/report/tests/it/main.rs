//! Tests of the reports from outside the crate.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::disallowed_methods,
    reason = "a test says what went wrong by panicking; expected values are found independently"
)]

#[macro_use]
mod made;
mod common;
mod csv;
mod findings;
mod json;
mod page;
mod page_axes;
mod page_limits;
mod runs;
mod still;
mod svg;
mod text;
mod time;
