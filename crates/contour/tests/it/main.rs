//! Tests of tracking, bookkeeping and the circular test.
#![allow(clippy::unwrap_used)]

mod ballbar;
mod bookkeeping;
mod circles;
mod split;
mod tracking;
