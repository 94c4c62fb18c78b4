//! Results for people and for other programs: terminal tables, JSON, CSV, Parquet, SVG, a page for a browser,
//! and files that appear complete or not at all.
//!
//! Everything here is made from the data types of `lostmotion-sim`, `lostmotion-plan` and
//! `lostmotion-drive`. Writers take any [`std::io::Write`]; only `atomic` touches the file
//! system, and only with the feature `files`.
//! No number is computed here that a result does not hold, apart from ratios that a table shows.

#[cfg(feature = "files")]
pub mod atomic;
pub mod columns;
pub mod csv;
pub mod error;
pub mod findings;
pub mod json;
#[cfg(feature = "mcap")]
pub mod mcap;
pub mod number;
pub mod page;
#[cfg(feature = "parquet")]
pub mod parquet;
pub mod reading;
pub mod refusal;
pub mod runs;
#[cfg(feature = "schema")]
pub mod schema;
pub mod svg;
pub mod text;

pub use error::{ReadError, WriteError};
