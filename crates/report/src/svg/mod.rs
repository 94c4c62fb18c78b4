//! Pictures drawn by the program: curves over a common axis. The picture of a run is
//! [`still`](crate::page::still).
//!
//! Plain SVG 1.1 on a white ground, generic font names, no scripts; the same input gives the same
//! bytes.

mod canvas;
mod plane;
mod scale;
mod series;

pub(crate) use canvas::{fit, text_width};
pub(crate) use plane::Plane;
pub(crate) use scale::{keep, round_down};
pub use series::{Series, SeriesPicture, series};
