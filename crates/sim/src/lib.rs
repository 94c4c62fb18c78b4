//! Simulation of part programs on machines: the way in is [`Simulation`].
//!
//! A [`Program`] holds the text, a [`Machine`] everything that is known of the machine, and a
//! [`Simulation`] takes the one through the other in chunks of constant size: it judges the contour
//! error ([`Simulation::run`]), plans ([`Simulation::plan`]), or tells where the time goes
//! ([`Simulation::time`]). The answers are plain data ([`results`]); an [`Observer`] sees rows and
//! points as they are finished.

pub mod commission;
pub mod control;
pub mod error;
pub mod files;
pub mod import;
mod limiter;
pub mod machine;
pub mod measure;
mod method;
pub mod motion;
pub mod observer;
pub mod options;
pub mod program;
pub mod recommend;
pub mod recorded;
pub mod request;
pub mod results;
pub mod rewrite;
mod session;
mod setup;
pub mod simulation;
pub mod subroutines;
pub mod testpart;
pub mod time;

pub use error::{SimError, SinkError, TravelExcess};
pub use limiter::Limiter;
pub use machine::{Machine, presets};
pub use motion::interpreter_config;
pub use observer::{ContourPoint, ForeseenContour, MotorPoint, Observer, Progress};
pub use options::{BowLimit, Intervention, SimulateOptions};
pub use program::Program;
pub use results::Run;
pub use session::{Frame, SETTLE_S, TickSink, Ticks};
pub use simulation::Simulation;
pub use subroutines::SubroutineFolders;
