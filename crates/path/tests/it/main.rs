//! Tests of curves: geometry, arcs, nearest points.

mod arcs;
mod common;
mod geometry;
mod nearest;
