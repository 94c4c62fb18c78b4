//! Curves of the programmed path, by arc length.
//!
//! A [`Curve`] lives in the nine program axes ([`lostmotion_base::Coords`]); its parameter `s` runs
//! from 0 to [`Curve::length`]. For lines and arcs `s` is exact arc length of the X Y Z part
//! (rotary axes follow linearly in `s`); a line on which only rotary axes move has `s` in degrees,
//! as the feed rule of RS274 has it.

pub mod arc;
mod arc_bounds;
mod arc_length;
mod arc_spec;
mod bernstein;
pub mod curve;
pub mod derivs;
pub mod error;
mod extent;
pub mod line;
mod nearest;
pub mod quintic;

pub use arc::Arc;
pub use arc_spec::ArcSpec;
pub use curve::{Curve, Foot};
pub use derivs::{Bounds, CurveDerivs};
pub use error::PathError;
pub use line::Line;
pub use lostmotion_base::Plane;
pub use quintic::{HermiteEnd, Quintic};
