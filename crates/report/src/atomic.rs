//! Output files that appear complete or not at all.
//!
//! A file is written under a temporary name in its own folder, flushed to the disk and renamed. Whoever drops an uncommitted
//! file, also by an error or a panic, leaves nothing behind.

mod file;
mod folder;

pub use file::AtomicFile;
pub use folder::OutputFolder;
