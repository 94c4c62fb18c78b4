//! Look-ahead planning: program moves in, 1 ms samples of every joint out, all limits kept.
//!
//! What happens to one move:
//! 1. it is checked (finite, connected, inside the travel, every moving joint has limits);
//! 2. the conditioner joins it to its neighbours: a smooth curve inside the tube of the program in
//!    place of lines that meet at small angles, a blend within the tolerance, or a stop, so that
//!    between two stops the path has a continuous second derivative;
//! 3. bounds of every joint's derivatives along the path say how fast it may go;
//! 4. the look-ahead window plans a speed profile and outputs what later moves cannot change;
//! 5. a moving average over time makes the profile jerk-limited, a time law makes it faster where
//!    it can, and the sampler reads it at every tick.
//!
//! Of quality `optimal`, the samples of all joints are then retimed as a whole to nearly the least
//! time (module `optimal`).
//!
//! Where the tolerance allows to cut a corner but no blend is faster than a stop, the next stretch
//! sets out before the one before has come to rest, so that the two motions add up for a while. The
//! tool then stays within the tolerance of the path and passes the corner itself within it, too;
//! where the path turns back by more than 175 degrees it comes to rest.
//!
//! ```
//! use lostmotion_base::{AxisLimits, BlockRef, Coords};
//! use lostmotion_kinematics::Cartesian;
//! use lostmotion_path::Curve;
//! use lostmotion_plan::{FeedLimit, Move, PathControl, PlanItem, Planner, PlannerConfig};
//! use std::sync::Arc;
//!
//! let limits = AxisLimits { min: -500.0, max: 500.0, velocity: 100.0, acceleration: 1e3, jerk: 3e4 };
//! let mut config = PlannerConfig::new([None; 9]);
//! config.limits[..3].fill(Some(limits));
//! let mut planner = Planner::new(config, Arc::new(Cartesian), Coords::ZERO)?;
//! let corners = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]].map(|[x, y]| Coords::xyz(x, y, 0.0));
//! for ends in corners.windows(2) {
//!     planner.push(PlanItem::Move(Move {
//!         curve: Curve::line(ends[0], ends[1]),
//!         feed: FeedLimit::PerSecond(50.0),
//!         control: PathControl::ExactStop,
//!         tool_mm: [0.0; 3],
//!         block: BlockRef::default(),
//!     }))?;
//! }
//! planner.finish()?;
//! let mut samples = Vec::new();
//! while planner.take(1000, &mut samples) > 0 {}
//! let fastest = samples.iter().map(|sample| sample.path_speed).fold(0.0, f64::max);
//! assert!((fastest - 50.0).abs() < 1e-3);
//! assert_eq!(samples.last().map(|sample| sample.position), Some(corners[2]));
//! # Ok::<(), lostmotion_plan::PlanError>(())
//! ```

mod admit;
mod chord;
mod condition;
pub mod config;
mod corner;
mod demand;
pub mod error;
mod intake;
mod intervals;
pub mod item;
mod judge;
mod machine;
mod motion;
mod optimal;
mod pace;
mod piece;
pub mod planner;
mod profile;
mod sampler;
mod sharp;
mod soft;
mod timing;
pub mod travel;
mod wide;
mod window;

pub use chord::Chord;
pub use config::{PlannerConfig, Quality};
pub use error::{PlanError, TravelViolation};
pub use item::{Dwell, FeedLimit, Halt, Heeds, Move, PathControl, PlanItem, Sample, Shortfalls};
pub use pace::{Action, Pacer};
pub use planner::{ItemsIn, PathIn, Planner};
pub use travel::TravelCheck;
