//! The result of a run as one HTML file that works offline: what a machinist looks at.
//!
//! [`PageRecorder`] gathers while the run goes on, [`page`] writes; [`runs_page`] sets several runs side by side. The first screen (verdict, worst
//! places, times, axes, methods, still pictures) is plain HTML; the scripts add the path in three
//! dimensions, the program's lines, and plots. Nothing is fetched, texts of programs are escaped, and
//! the same run gives the same bytes. The file has at most 5 MB whatever the program's length.

mod advice;
mod circles;
mod data;
mod html;
mod path;
mod picture;
mod places;
mod record;
mod runs;
mod series;

pub use html::{message_page, page};
pub use record::PageRecorder;
pub use runs::runs_page;
