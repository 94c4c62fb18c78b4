//! Results as lines of JSON, which a run appends to and a later one goes on from.
//!
//! A line is written in one piece and belongs to its cell by its key alone: files may be put one
//! behind the other, and have lines of other sweeps. A last line without its end was being written
//! when a run was killed: it counts for nothing.

use crate::cell::CellResult;
use crate::error::SweepError;
use crate::key::{Key, Keys};
use lostmotion_report::WriteError;
use serde::Deserialize;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Longest line, bytes. A choice: thousands of methods.
const LONGEST_LINE: u64 = 16 << 20;

/// What is looked at of a line.
#[derive(Deserialize)]
struct Known {
    key: Key,
}

/// Reads the keys of a file of results with the first bytes of their lines, from its start. Gives the
/// bytes of its whole lines.
///
/// # Errors
/// A line in the middle that is no result.
pub fn scan(path: &Path, file: &File, found: &mut dyn FnMut(Key, u64)) -> Result<u64, SweepError> {
    let unread = |error| SweepError::unread("results", path, error);
    let mut reader = BufReader::with_capacity(1 << 18, file);
    reader.seek(SeekFrom::Start(0)).map_err(unread)?;
    let mut line = Vec::new();
    let (mut start, mut number) = (0, 0);
    loop {
        line.clear();
        number += 1;
        let read = reader
            .by_ref()
            .take(LONGEST_LINE)
            .read_until(b'\n', &mut line);
        let read = read.map_err(unread)? as u64;
        if line.last() != Some(&b'\n') && read < LONGEST_LINE {
            return Ok(start);
        }
        line.pop();
        let known: Known = serde_json::from_slice(&line).map_err(|error| SweepError::Results {
            file: path.display().to_string(),
            line: number,
            message: error.to_string(),
        })?;
        found(known.key, start);
        start += read;
    }
}

/// A file of results open for more; no other run can open it meanwhile.
#[derive(Debug)]
pub struct Results {
    path: PathBuf,
    file: File,
    cut_bytes: u64,
    /// Whether there was none before.
    began: bool,
}

/// A file that began here and has no result is not left behind.
impl Drop for Results {
    fn drop(&mut self) {
        let is_empty = self.file.metadata().is_ok_and(|about| about.len() == 0);
        if self.began && is_empty {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

impl Results {
    /// Opens a file of results, which begins if there is none, and gives the keys of what is done. A
    /// half line at its end is cut off.
    ///
    /// # Errors
    /// A file that cannot be read and written, that another run writes to, or that has a line which
    /// is no result.
    pub fn open(path: &Path) -> Result<(Results, Keys), SweepError> {
        let unwritten = |error| SweepError::from(WriteError::io("write", path, error));
        let began = !path.exists();
        let mut file = OpenOptions::new()
            .read(true)
            .append(true)
            .create(true)
            .open(path)
            .map_err(unwritten)?;
        match file.try_lock() {
            // Some file systems have no locks: then nobody can be kept out.
            Ok(()) | Err(TryLockError::Error(_)) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(SweepError::Busy {
                    file: path.display().to_string(),
                });
            }
        }
        let mut done = Vec::new();
        let whole = scan(path, &file, &mut |key, _| {
            done.push(key);
        })?;
        let length = file.metadata().map_err(unwritten)?.len();
        if length > whole {
            file.set_len(whole).map_err(unwritten)?;
        }
        file.seek(SeekFrom::End(0)).map_err(unwritten)?;
        let results = Results {
            path: path.to_path_buf(),
            file,
            cut_bytes: length - whole,
            began,
        };
        Ok((results, Keys::of(done)))
    }

    /// Bytes of the half line that was cut off; 0 if there was none.
    pub fn cut_bytes(&self) -> u64 {
        self.cut_bytes
    }

    /// Puts a result at the end, at once and whole.
    ///
    /// # Errors
    /// The disk is full or gone.
    pub fn append(&mut self, result: &CellResult) -> Result<(), SweepError> {
        self.append_line(&line(result)?)
    }

    /// The same of a result that is already a line.
    ///
    /// # Errors
    /// As [`Results::append`].
    pub fn append_line(&mut self, line: &str) -> Result<(), SweepError> {
        // One call: a kill leaves the whole line, a part of it at the end, or nothing.
        let mut text = line.trim_end().to_owned();
        text.push('\n');
        self.file
            .write_all(text.as_bytes())
            .map_err(|error| WriteError::io("write", &self.path, error))?;
        Ok(())
    }

    /// Makes sure that everything is on the disk.
    ///
    /// # Errors
    /// The disk is full or gone.
    pub fn sync(&self) -> Result<(), SweepError> {
        let synced = self.file.sync_data();
        Ok(synced.map_err(|error| WriteError::io("write", &self.path, error))?)
    }
}

/// A result as its line, without the end.
///
/// # Errors
/// None for the results of this crate.
pub fn line(result: &CellResult) -> Result<String, SweepError> {
    serde_json::to_string(result).map_err(|error| SweepError::value(error.to_string(), ""))
}
