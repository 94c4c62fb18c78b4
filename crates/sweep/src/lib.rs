//! Sweeps: many part programs, machines, methods and values of machine keys, one table.
//!
//! ```text
//! file      what a sweep file says            design   which points: grid, random, Sobol
//! plan      file -> manifest                  key      what a cell is known by
//! manifest  a line for each cell              missing  cells that are yet to be run
//! inputs    programs and machines, as they were planned
//! cell      one cell -> its figures           run      cells on all cores
//! results   a line for each finished cell     collect  manifest and results -> table
//! page      the same for a browser            emit     scripts for schedulers
//! batch     cells as messages to workers without files
//! ```
//!
//! A cell is known by the hash of all that its figures depend on, so that results can be made
//! anywhere, in any order and more than once: [`collect::Finished`] puts them together by
//! their keys, the same bytes each time.

pub mod batch;
pub mod cell;
pub mod collect;
pub mod design;
pub mod emit;
pub mod error;
pub mod file;
pub mod inputs;
pub mod key;
pub mod manifest;
pub mod missing;
pub mod page;
pub mod plan;
pub mod results;
pub mod run;

pub use error::SweepError;
