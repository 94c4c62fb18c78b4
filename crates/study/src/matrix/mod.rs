//! The test matrix: how much of the contour error that backlash causes does each method leave?
//!
//! ```text
//! factor   what is varied, its levels, a cell and its name
//! sample   which cells: each level equally often, pairs of levels as evenly as can be
//! motion   cell -> part program          machine  cell -> machine
//! cell     program -> plan -> all methods side by side -> contour errors
//! limit    the physical limit            cycle  limit cycles
//! result   figures of a cell, the sums that they come from, what may be expected of a drive
//! run      cells on all cores            journal  results as lines, to go on from
//! summary  distribution per method and regime      table  Markdown and CSV
//! ```
//!
//! Figure of merit: the signed contour error of the machine with its gap minus that of the same
//! machine without a gap and without compensator, servo tick by servo tick, on cutting moves, from
//! 0.1 s after each axis has reversed four times. RMS and largest magnitude of it, as parts of what
//! `none` leaves.

mod cell;
mod cycle;
pub mod factor;
pub mod journal;
mod limit;
pub mod machine;
pub mod motion;
pub mod result;
mod run;
pub mod sample;
pub mod summary;
pub mod table;

pub use cell::{Trace, Traced};
pub(crate) use cycle::Watch;
pub use factor::{Cell, FACTORS, Factor};
pub use limit::{Physics, traverse_s};
pub(crate) use result::practical_um;
pub use result::{CellResult, MethodFigures};
pub use run::{Progress, run_cell, run_cells};
pub use sample::{MOST_CELLS, all_cells, sample};
