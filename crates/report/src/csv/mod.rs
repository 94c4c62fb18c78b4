//! Tables for other programs: comma-separated, one header line, a unit in every column's name, `\n`
//! at the end of a row.
//!
//! Writers stream: rows go out in blocks and nothing is kept. Readers name line, column and value
//! of what they refuse.

mod axis_trace;
mod blocks;
mod cells;
mod contour;
mod log;
mod plan;
mod reversals;
mod rows;
mod setpoints;
mod times;

pub use axis_trace::AxisTraceWriter;
pub use blocks::BlockWriter;
pub use contour::ContourWriter;
pub use log::{AxisLog, read_log, read_motor_log};
pub use plan::PlanWriter;
pub use reversals::ReversalWriter;
pub use setpoints::{SetpointReader, SetpointSource};
pub use times::TimeWriter;
