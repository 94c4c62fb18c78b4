//! From a program on a machine to samples of its plan.
//!
//! ```text
//! check    read everything once: diagnostics, travel            (check.rs)
//! travel   what lies beyond the travel, and which offset brings it in  (travel.rs)
//! reader   text -> operations -> motion; tool directions        (reader.rs, steer.rs)
//! curves   motion -> curves and planner's items                 (curves.rs)
//! stops    moves -> pieces with the stops of the control between them (stops.rs)
//! feed     moves -> samples, segments                           (feed.rs)
//! paced    samples at another pace: hold, override, stop        (paced.rs)
//! bow      samples, moves -> how far the tool is off where joints go straight (bow.rs)
//! ```

mod bow;
mod change;
mod check;
mod curves;
mod feed;
mod paced;
mod reader;
mod steer;
mod stops;
mod travel;

pub(crate) use bow::Bows;
pub(crate) use change::{CHANGES, LimitChange};
pub(crate) use check::{Checked, check, planner_config};
pub use curves::{Curves, ProgrammedMove, curve, plan_item};
pub(crate) use feed::{Feed, Note};
pub use reader::interpreter_config;
pub(crate) use steer::Modes;
pub(crate) use stops::reversals;
