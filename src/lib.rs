//! lostmotion: how far a real machine's tool leaves the programmed contour, and what each way of
//! compensating backlash does about it.
//!
//! A [`Program`] on a [`Machine`] makes a [`Simulation`]; its [`Run`] tells the contour error block
//! by block:
//!
//! ```
//! use lostmotion::{Machine, Program, Simulation};
//!
//! let program = Program::from_str("part", "G21 G0 X25\nG3 I-25 F2000\nM2\n");
//! let machine = Machine::preset("vmc3")?.edit(|m| {
//!     m.axis("x").gap_um = 25.0;
//!     m.g54 = [-300.0, -200.0, -250.0];
//! })?;
//! let run = Simulation::new(&program, &machine).method("fixed").run()?;
//! for block in run.blocks() {
//!     println!("{}: {:+.1} um, {}", block.line, block.max_um, block.cause);
//! }
//! assert!(run.is_within_tolerance());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The modules are the stages of the chain, for callers that embed a part of it:
//!
//! ```text
//! gcode -> path -> plan -> kinematics -> drive with methods (one per axis) -> contour -> report
//! ```
//!
//! | feature | adds |
//! |---|---|
//! | `files` | programs and subroutines from files, and files as output with `report` |
//! | `threads` | runs on several threads; without it the same results on the caller's |
//! | `fit` | [`identify`](https://docs.rs/lostmotion-identify): the offline fit of the gap from a log, with its convex solver |
//! | `logs` | [`logs`](https://docs.rs/lostmotion-logs): readers of measured logs |
//! | `report` | [`report`](https://docs.rs/lostmotion-report): results as text, JSON, CSV and SVG |
//!
//! The first two are on by default; the command line has all.

pub use lostmotion_analysis as analysis;
pub use lostmotion_base as base;
pub use lostmotion_contour as contour;
pub use lostmotion_drive as drive;
pub use lostmotion_gcode as gcode;
pub use lostmotion_gcode_tools as gcode_tools;
#[cfg(feature = "fit")]
pub use lostmotion_identify as identify;
pub use lostmotion_kinematics as kinematics;
#[cfg(feature = "logs")]
pub use lostmotion_logs as logs;
pub use lostmotion_methods as methods;
pub use lostmotion_path as path;
pub use lostmotion_plan as plan;
#[cfg(feature = "report")]
pub use lostmotion_report as report;
pub use lostmotion_sim as sim;

pub use lostmotion_sim::{
    ContourPoint, Intervention, Machine, Observer, Program, Progress, Run, SimError,
    SimulateOptions, Simulation, results,
};

/// The Rust blocks of README.md and of the book, as doctests.
#[cfg(doctest)]
mod documents {
    #[doc = include_str!("../README.md")]
    struct Readme;

    #[doc = include_str!("../docs/book/src/guide/library.md")]
    struct Library;
}
