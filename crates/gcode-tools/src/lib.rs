//! Tools for part programs in G-code, built on the public interface of [`lostmotion_gcode`].
//!
//! | module | does |
//! |---|---|
//! | [`lint`] | warns of programs that run, but may not do what is meant |
//! | [`format`](mod@format) | rewrites the text in one style; what the program does stays the same |
//! | [`explain`] | says in words what a block does |
//! | [`document`] | holds the text of a program so that single blocks can be edited |
//! | [`writer`] | writes canonical operations as a plain program without variables and loops |
//!
//! ```
//! use lostmotion_gcode::{InterpreterConfig, Program};
//! use lostmotion_gcode_tools::lint::{Levels, lint};
//!
//! let mut program = Program::new(&b"G0 X10\nM2\n"[..], InterpreterConfig::default());
//! let found = lint(&mut program, Levels::default());
//! assert_eq!(found.kept()[0].rule.code, "unset-units");
//! ```

pub mod document;
pub mod explain;
pub mod format;
pub mod lint;
pub mod writer;
