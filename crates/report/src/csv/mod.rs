//! Tables for other programs: comma-separated, one header line, a unit in every column's name, `\n`
//! at the end of a row.
//!
//! Writers stream: rows go out in blocks and nothing is kept. Readers name line, column and value
//! of what they refuse.

mod cells;
mod motion;
mod results;
mod rows;
mod setpoints;
mod table;
mod trace;

pub use motion::{AxisRow, AxisScales, AxisTraceWriter, PlanWriter};
pub use results::{BlockWriter, ReversalWriter, TimeWriter};
pub use rows::{ColumnKind, Rows, TableCells, TableColumn};
pub use setpoints::{SetpointReader, SetpointSource};
pub use table::{TableCell, TableWriter};
pub use trace::{ContourWriter, MotorWriter, TraceRange};
