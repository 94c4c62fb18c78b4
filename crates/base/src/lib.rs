//! Ground floor of lostmotion: what every other crate shares and nothing more.
//!
//! Units inside the project are mm, s, rad, N, N m, A, V. Numbers that cross a public boundary
//! carry their unit in a newtype ([`units`]) or in the field's name (`gap_mm`).

pub mod axis;
pub mod coords;
pub mod jet;
pub mod limits;
pub mod math;
pub mod plane;
pub mod real;
pub mod span;
pub mod tick;
pub mod units;

pub use axis::{AXES, AxisId, AxisSet};
pub use coords::Coords;
pub use jet::Jet;
pub use limits::{AxisLimits, LimitError};
pub use plane::Plane;
pub use real::Real;
pub use span::{BlockRef, Span};
pub use tick::{Clock, Tick};
