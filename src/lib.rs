//! lostmotion: from a part program to its contour error on a real machine.
//!
//! The facade re-exports every stage under one name and adds nothing: [`sim`] is the front door
//! (`simulate`, `compare`, `plan`), the other modules are its stages for those who embed a part of the chain.
//!
//! ```text
//! gcode -> path -> plan -> kinematics -> axis (one each) -> contour -> report
//! ```

pub use lostmotion_axis as axis;
pub use lostmotion_base as base;
pub use lostmotion_contour as contour;
pub use lostmotion_gcode as gcode;
#[cfg(feature = "fit")]
pub use lostmotion_identify as identify;
pub use lostmotion_kinematics as kinematics;
pub use lostmotion_path as path;
pub use lostmotion_plan as plan;
pub use lostmotion_report as report;
pub use lostmotion_sim as sim;
