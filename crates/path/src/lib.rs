//! Curves of the programmed path, by arc length.
//!
//! A [`Curve`] lives in the nine program axes ([`lostmotion_base::Coords`]); its parameter `s` runs
//! from 0 to [`Curve::length`]. For lines and arcs `s` is exact arc length of the X Y Z part
//! (rotary axes follow linearly in `s`); a line on which only rotary axes move has `s` in degrees,
//! as the feed rule of RS274 has it.
//!
//! ```
//! use lostmotion_base::Coords;
//! use lostmotion_path::Curve;
//!
//! let line = Curve::line(Coords::ZERO, Coords::xyz(30.0, 40.0, 0.0));
//! assert_eq!(line.length(), 50.0);
//! // The point of the line nearest to a tool that is 4.6 mm beside it.
//! let foot = line.nearest([26.0, 27.0, 0.0], (0.0, line.length()), 1e-6);
//! assert!((foot.distance - 4.6).abs() < 1e-12 && (foot.s - 37.2).abs() < 1e-12);
//! ```

pub mod arc;
mod arc_bounds;
mod arc_length;
pub mod curve;
pub mod derivs;
pub mod error;
pub mod line;
mod nearest;
pub mod quintic;

pub use arc::{Arc, ArcSpec};
pub use curve::Curve;
pub use derivs::{Bounds, CurveDerivs, Foot};
pub use error::PathError;
pub use line::Line;
pub use lostmotion_base::Plane;
pub use quintic::{HermiteEnd, Quintic};
