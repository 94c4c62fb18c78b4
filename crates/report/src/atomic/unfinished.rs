//! What is on the disk without its name yet, for a process that is told to end: its values are not
//! dropped then.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Temporary files, and folders that were made for files to come, by their number.
static UNFINISHED: Mutex<BTreeMap<u64, PathBuf>> = Mutex::new(BTreeMap::new());

fn unfinished() -> MutexGuard<'static, BTreeMap<u64, PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An entry in the list, as long as it lives.
#[derive(Debug)]
pub(super) struct Unfinished(u64);

impl Unfinished {
    pub(super) fn new(path: PathBuf) -> Unfinished {
        let mut all = unfinished();
        let number = all.last_key_value().map_or(0, |(last, _)| last + 1);
        all.insert(number, path);
        Unfinished(number)
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        unfinished().remove(&self.0);
    }
}

/// Removes every file that is being written, and the folders made for them, before a process ends
/// without dropping its values (a signal). Nothing may be written or committed afterwards.
pub fn abandon() {
    // The latest first: files, then the folders around them, the innermost first.
    while let Some((_, path)) = unfinished().pop_last() {
        let _ = if path.is_dir() {
            std::fs::remove_dir(&path)
        } else {
            std::fs::remove_file(&path)
        };
    }
}
