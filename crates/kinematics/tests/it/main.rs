//! Tests of every kind of machine: there and back, oracles, orientation.
#![allow(clippy::disallowed_methods, clippy::unwrap_used, clippy::panic)]

mod common;
mod machines;
mod oracle;
mod orientation;
mod random_paths;
