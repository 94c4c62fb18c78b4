//! Ground floor of lostmotion: what every other crate shares and nothing more.
//!
//! Axes and coordinates, units, ticks and spans; the numbers that kinematics are written in; and
//! the numerics that several crates need: vectors, linear algebra, roots, random numbers.
//!
//! Units inside the project are mm, s, rad, N, N m, A, V. A number that crosses a public boundary
//! says its unit in its name (`gap_mm`) or in its documentation; [`units`] converts between what
//! people write and what the project computes in.

pub mod axis;
pub mod coords;
pub mod limits;
pub mod linalg;
pub mod math;
pub mod matrix;
pub mod names;
pub mod number;
pub mod random;
pub mod real;
pub mod root;
pub mod span;
pub mod text;
pub mod threads;
pub mod tick;
pub mod twice;
pub mod units;
pub mod vec;
pub mod wide;

pub use axis::{AXES, AxisId, AxisSet, Plane};
pub use coords::Coords;
pub use limits::{AxisLimits, LimitError};
pub use number::Number;
pub use random::Random;
pub use real::{Jet, Real};
pub use span::{BlockRef, Span};
pub use tick::{Clock, Tick};
pub use twice::{Twice, TwiceMask};
pub use wide::{Wide, WideMask};
