//! Output files that appear complete or not at all.
//!
//! A file is written under a temporary name in its own folder, flushed to the disk and renamed.
//! An uncommitted file that is dropped, also by an error or a panic, leaves nothing behind. A process
//! that ends otherwise calls [`abandon`] first.

mod file;
mod folder;

pub use file::{Abandoned, AtomicFile, abandon};
pub use folder::OutputFolder;
