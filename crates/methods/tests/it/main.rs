//! The compensators, alone, on an axis and in batches.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod adaptive;
mod batch;
mod compensators;
mod controls;
mod drift;
mod filters;
mod fitted_lookup;
mod fixed_variants;
mod hostile;
mod inverse_and_observer;
mod iterative_learning;
mod lookup;
mod memory;
mod one_file;
mod reversal_pulse;
mod shaft;
