//! Output files that appear complete or not at all.
//!
//! A file is written under a temporary name in its own folder, flushed to the disk and renamed.
//! Whoever drops an uncommitted file, also by an error or a panic, leaves nothing behind. A process
//! that ends otherwise calls [`abandon`] first.

mod file;
mod folder;
mod unfinished;

pub use file::AtomicFile;
pub use folder::OutputFolder;
pub use unfinished::abandon;
