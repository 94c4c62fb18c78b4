//! Curves of the programmed path, by arc length.
//!
//! A [`Curve`] lives in the nine program axes ([`lostmotion_base::Coords`]); its parameter `s` runs from 0 to
//! [`Curve::length`]. For lines and arcs `s` is exact arc length of the X Y Z part (rotary axes follow linearly in `s`);
//! a line on which only rotary axes move has `s` in degrees, as the feed rule of RS274 has it.

pub mod arc;
pub mod curve;
pub mod line;
pub mod quintic;

pub use arc::Arc;
pub use curve::{Curve, Foot, Plane};
pub use line::Line;
pub use quintic::Quintic;
