//! The program from the outside: exit codes, messages, files that appear or do not.

#![allow(
    clippy::panic,
    clippy::unwrap_used,
    reason = "helpers of tests say what is missing by panicking"
)]

mod bench;
mod commands;
mod drives;
mod editor;
mod hostile;
#[cfg(unix)]
mod interrupt;
mod learned;
mod machines;
mod measured;
mod reference;
mod setpoints;
mod settings;
mod studies;
mod surface;
mod sweeps;
mod texts;
mod tools;
mod watch;
