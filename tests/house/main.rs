//! What holds for the text of the repository: names, sizes of files, packages, documents.
//!
//! `cargo test -p lostmotion --test house -- --nocapture figures` prints the figures.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod documents;
mod figures;
mod files;
mod names;
mod recipes;
#[path = "../sources/mod.rs"]
mod sources;
