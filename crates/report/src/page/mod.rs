//! The result of a run as one HTML file that works offline: what a machinist looks at.
//!
//! [`PageRecorder`] gathers while the run goes on, [`page`] writes; [`runs_page`] sets several runs
//! side by side, [`time_page`] shows where the time goes, [`study_page`] what methods leave in many cells,
//! and [`still`] is one picture. The first
//! screen (verdict, worst places, times, axes, methods, still pictures) is plain HTML; the scripts add
//! the path in three dimensions, the program's lines, and plots. Nothing is fetched, texts of programs are escaped, and
//! the same run gives the same bytes. The file has at most 5 MB whatever the program's length.

mod advice;
mod axes;
mod ballbar;
mod circles;
mod data;
mod enlarged;
mod html;
mod levels;
mod path;
mod picture;
mod places;
mod record;
mod rests;
mod runs;
mod series;
mod still;
mod study;
mod time;

pub use html::{message_page, page};
pub use record::{Gathered, PageRecorder};
pub use runs::runs_page;
pub use still::still;
pub use study::{CellRatio, MethodCells, study_page};
pub use time::time_page;
