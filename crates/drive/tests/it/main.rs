//! The parts of an axis: config, reference, servo, plant.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod config;
mod hybrid;
mod interpolators;
mod options_config;
mod plant_arc;
mod plant_closed_forms;
mod plant_energy;
mod plant_mirror;
mod plant_modelica;
mod plant_options;
mod plant_solver;
mod plants;
mod reference;
mod servo;
mod servo_options;
mod tied;
mod twin;
