//! lostmotion: from a part program to its contour error on a real machine.
//!
//! The facade re-exports every stage under one name and adds nothing: [`sim`] is the front door
//! (`simulate`, `compare`, `plan`), the other modules are its stages for those who embed a part of
//! the chain.
//!
//! ```text
//! gcode -> path -> plan -> kinematics -> drive (one a joint, with a method) -> contour -> report
//! ```
//!
//! ```
//! use lostmotion::sim::{Machine, ProgramSource, SimulateOptions, Unobserved, simulate};
//!
//! let program = ProgramSource::from_bytes("circle.ngc", &b"G21 G0 X25 Y0\nG3 I-25 F2000\nM2\n"[..]);
//! let machine = Machine::preset("vmc3").ok_or("no such machine")?;
//! let answer = simulate(&program, &machine, "fixed", &SimulateOptions::default(), &mut Unobserved)?;
//! println!("largest contour error {:.1} um", answer.result.cutting.max);
//! for block in &answer.result.worst_blocks {
//!     println!("line {}: {:+.1} um, {:?}", block.block.span.line, block.max_um, block.cause);
//! }
//! assert!(answer.result.cutting.max < answer.tolerance_um);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub use lostmotion_analysis as analysis;
pub use lostmotion_base as base;
pub use lostmotion_contour as contour;
pub use lostmotion_drive as drive;
pub use lostmotion_gcode as gcode;
pub use lostmotion_gcode_tools as gcode_tools;
#[cfg(feature = "fit")]
pub use lostmotion_identify as identify;
pub use lostmotion_kinematics as kinematics;
pub use lostmotion_methods as methods;
pub use lostmotion_path as path;
pub use lostmotion_plan as plan;
pub use lostmotion_report as report;
pub use lostmotion_sim as sim;
pub use lostmotion_study as study;
