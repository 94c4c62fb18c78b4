//! The session: a machine, a part program, the whole chain, the answer.
//!
//! [`simulate`], [`compare`] and [`plan`] are the front door. They take a [`ProgramSource`] and a
//! [`Machine`], go through the program in chunks of constant size, and answer with plain data
//! ([`results`]); an [`Observer`] sees rows and points as they are finished.

pub mod error;
pub mod import;
pub mod machine;
pub mod observer;
pub mod options;
pub mod results;
mod session;
pub mod source;
mod straightness;
pub mod time;

pub use error::{SimError, SinkError};
pub use machine::{Machine, presets};
pub use observer::{ContourPoint, Observer, Unobserved};
pub use options::{Intervention, SimulateOptions};
pub use results::{Comparison, Simulation};
pub use session::{PathSink, check, compare, interpreter_config, plan, plan_with_path, simulate};
pub use source::ProgramSource;
pub use straightness::BowLimit;
pub use time::time;
