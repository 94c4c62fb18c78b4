//! Pictures drawn by the program: the contour error of a path, magnified, and time series.
//!
//! Plain SVG 1.1 on a white ground, generic font names, no scripts; the same input gives the same
//! bytes.

mod canvas;
mod contour;
mod scale;
mod series;
mod trace;

pub use contour::{ContourPicture, contour};
pub(crate) use scale::round_down;
pub use series::{Series, SeriesPicture, series};
pub use trace::{ContourTrace, Plane, TracePoint, TraceRecorder};
