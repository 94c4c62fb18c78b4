//! RS274/NGC front end: bytes of a part program in, canonical operations and diagnostics out.
//!
//! ```
//! use lostmotion_gcode::{InterpreterConfig, Program};
//!
//! let mut program = Program::new(&b"G21 G1 X10 F200\nM2\n"[..], InterpreterConfig::default());
//! let ops: Vec<String> = program.by_ref().map(|sourced| sourced.op.to_string()).collect();
//! assert_eq!(program.diagnostics().errors(), 0);
//! assert!(ops.contains(&"STRAIGHT_FEED(10.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000)".to_owned()));
//! ```
//!
//! What happens to a line: [`syntax`] makes it a block of words and postfix code; the
//! [`interpreter`] evaluates the words, looks their codes up in the table of [`codes`], and carries
//! them out in the order of their phases; the result is [`ops::SourcedOp`]s. [`motion`] folds those
//! into moves in machine coordinates.
//!
//! Under cutter compensation (G41, G42) a move is held back until the next one is known. Curves
//! (G5, G5.1, G5.2) keep their control points and rigid tapping (G33.1) its end;
//! [`MotionFold::push_all`] makes moves of them. Probing moves and inputs find nothing: see
//! [`ops::StraightProbe`]. Subroutines in files come through a [`provenance::SubroutineLoader`], and
//! [`Interpreter::call_stacks`] tells which calls led to a block.
//!
//! A sender or an editor that has lines instead of a file gives them to a [`Feeder`] one at a time
//! and gets what each does; [`Program::run_block`] reads a file block by block; [`Blocks`]
//! only parses.

pub mod canon;
pub mod catalog;
pub mod codes;
pub mod config;
pub mod diagnostics;
pub mod dialect;
mod exec;
pub mod finding;
pub mod interpreter;
pub mod limits;
pub mod motion;
pub mod ops;
pub mod parameters;
pub mod problem;
pub mod program;
pub mod provenance;
mod source;
pub mod state;
pub mod syntax;
pub mod tool_table;
mod turning;

pub use codes::Code;
pub use config::{InterpreterConfig, MCodeUse};
pub use diagnostics::{Diagnostic, Diagnostics};
pub use dialect::{Dialect, Leniencies, Leniency};
pub use finding::Severity;
pub use interpreter::{Interpreter, Step};
pub use limits::{LimitError, LimitRow, Limits};
pub use motion::{Circle, Feed, Motion, MotionFold, MotionItem, PathMode};
pub use ops::{
    ArcFeed, CanonicalOp, ControlPoint, NurbsFeed, OrientWay, OutputValue, PathControl, Plane,
    Position, SourcedOp, StraightProbe, TextKind, Units, WaitFor,
};
pub use problem::Problem;
pub use program::{Fed, Feeder, Program};
pub use provenance::{
    CallSite, CallStacks, LoadedFile, Provenance, SourceFiles, SourceText, SubroutineLoader,
};
pub use source::{Blocks, ParsedBlock, Place};
pub use tool_table::{Tool, ToolTable};
