//! Machines and programs drawn at random: what methods do where nobody has tuned them.
//!
//! The cells of [`crate::matrix`] are looked at while methods are made; these are drawn anew from a
//! seed, as wide as real machines are: lead, gap, inertia, friction from none to a good part of the
//! rated torque, stiffness, encoders, gains, with and without feed-forward, and programs with
//! corners, circles, rests, mixtures of feeds and dense points. One seed is for looking, another,
//! new each time, for judging.
//!
//! A cell runs through [`Simulation`](lostmotion_sim::Simulation), exactly as users run it.
//!
//! ```
//! use lostmotion_study::drawn::draw;
//!
//! let cell = draw(1, 0)?;
//! assert!(cell.name.starts_with("1-0-") && cell.program.ends_with("M2\n"));
//! assert_eq!(cell.machine, draw(1, 0)?.machine);
//! # Ok::<(), lostmotion_study::StudyError>(())
//! ```

mod cell;
mod knowledge;
mod limit;
mod moment;
mod program;
mod run;
mod table;
mod trace;

pub use cell::{DrawnCell, Traits, draw};
pub use knowledge::Told;
pub use moment::{AxisMoment, AxisTruth, Missing, Moment};
pub use run::{DrawnFigures, DrawnResult, Part, commissioned, run, run_all};
pub use table::{left, markdown};
pub use trace::trace;
