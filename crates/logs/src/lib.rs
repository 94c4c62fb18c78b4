//! Readers of measured logs: what scopes and samplers of controls write, and tables of any kind.
//!
//! [`LogReader`] recognises the format of a log from its content, says what it found, and gives row
//! after row in constant memory. [`read_axis`] takes the channels of one axis out of it and brings
//! them to one clock.
//!
//! ```
//! use lostmotion_logs::{LogReader, ReadOptions, Row};
//!
//! let text = "Zeit [ms];Motor [um];Strom [A]\n0,0;12,5;0,1\n1,0;13,0;0,1\n2,0;13,5;0,1\n";
//! let mut log = LogReader::new(text.as_bytes(), "log.csv", &ReadOptions::default())?;
//! assert_eq!(log.header().said[0], "a table with semicolons between cells and decimal commas");
//! let mut row = Row::default();
//! let mut rows = 0;
//! while log.next_row(&mut row)? {
//!     rows += 1;
//! }
//! assert_eq!((rows, row.time_s, row.values[0]), (3, 2e-3, 13.5));
//! # Ok::<(), lostmotion_logs::LogError>(())
//! ```
//!
//! | format | recognised by | time |
//! |---|---|---|
//! | HALscope, three generations | `Sampling period is` in line 1 | row times the period in line 1 |
//! | halsampler | numbers with a blank behind each, no header | tag or row, times the period that the caller gives |
//! | TwinCAT Scope | `Name`, `File`, `Starttime of export` | a column for each group |
//! | Sinumerik trace | `<traceSession` | attribute `time` of each record |
//! | Heidenhain TNCscope | `%TNCscope` in line 1 | first column, us |
//! | EPICS camonitor | name, date, time, value | a stamp a line |
//! | Klipper, Duet accelerometers | their headers | a column; rate in the last line |
//! | Parquet (feature `parquet`) | `PAR1` | a column called time, or the one column of points in time |
//! | MCAP (feature `mcap`) | its first bytes | when each message was logged |
//! | any other table | a header above columns of numbers | a column called time, or the period that the caller gives |

mod accelerometer;
mod axis;
mod ballbar;
mod camonitor;
#[cfg(feature = "mcap")]
mod cdr;
mod clocks;
mod collect;
mod error;
mod halsampler;
mod halscope;
#[cfg(feature = "mcap")]
mod mcap;
#[cfg(feature = "mcap")]
mod mcap_records;
mod motion;
#[cfg(any(feature = "mcap", feature = "parquet"))]
mod packed;
#[cfg(feature = "parquet")]
mod parquet;
#[cfg(feature = "parquet")]
mod parquet_pages;
mod positions;
mod reader;
mod roles;
mod sinumerik;
mod source;
mod table;
mod text;
#[cfg(feature = "parquet")]
mod thrift;
mod time;
mod tncscope;
mod twincat;
mod unit;

pub use axis::{AxisLog, AxisOptions, DriveSignal, read_axis};
pub use ballbar::{BallbarLog, BallbarOptions, read_ballbar};
pub use error::LogError;
pub use positions::{
    AxisPositions, PositionKind, PositionLog, PositionOptions, PositionParts, read_positions,
};
pub use reader::LogReader;
pub use roles::{ColumnSpec, Role};
pub use source::{Channel, FileColumns, Format, Header, ReadOptions, Row};
pub use unit::{Quantity, Unit};
