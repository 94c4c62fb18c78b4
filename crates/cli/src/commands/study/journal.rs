//! The file in which the results so far are kept.

use super::failure;
use crate::failure::Failure;
use lostmotion::report::WriteError;
use lostmotion_study::matrix::journal::{Found, Header, line, read};
use lostmotion_study::matrix::{Cell, CellResult};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

const NAME: &str = "cells.jsonl";

/// A journal open for more results.
pub(super) struct Journal {
    path: PathBuf,
    file: File,
    /// What was there.
    pub(super) results: BTreeMap<Cell, CellResult>,
}

impl Journal {
    /// Opens the journal of a folder, which is made if it does not exist; begins it if there is
    /// none, or if asked to.
    pub(super) fn open(folder: &Path, header: &Header, fresh: bool) -> Result<Journal, Failure> {
        if folder.exists() && !folder.is_dir() {
            return Err(WriteError::NotFolder {
                path: folder.to_path_buf(),
            }
            .into());
        }
        std::fs::create_dir_all(folder).map_err(|error| WriteError::io("create", folder, error))?;
        let path = folder.join(NAME);
        let failed = |error| Failure::from(WriteError::io("write", &path, error));
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(fresh)
            .open(&path)
            .map_err(failed)?;
        let mut text = String::new();
        file.read_to_string(&mut text)
            .map_err(|error| match error.kind() {
                ErrorKind::InvalidData => {
                    Failure::with_hint(format!("{} is not text", path.display()), HINT)
                }
                _ => failed(error),
            })?;
        let found = read(&text, header)
            .map_err(|error| Failure::with_hint(format!("{}: {error}", path.display()), HINT))?;
        let mut journal = Journal {
            file,
            results: BTreeMap::new(),
            path,
        };
        journal.trim(&found)?;
        if found.whole_bytes == 0 {
            journal.append(&line(header).map_err(|error| failure(&error))?)?;
        }
        journal.results = found.results;
        Ok(journal)
    }

    /// Cuts off a line that was not finished.
    fn trim(&mut self, found: &Found) -> Result<(), Failure> {
        let end = found.whole_bytes as u64;
        let done = self
            .file
            .set_len(end)
            .and_then(|()| self.file.seek(SeekFrom::Start(end)));
        done.map(|_| ())
            .map_err(|error| WriteError::io("write", &self.path, error).into())
    }

    /// Puts a line at the end, at once and whole.
    pub(super) fn append(&mut self, text: &str) -> Result<(), Failure> {
        self.file
            .write_all(text.as_bytes())
            .map_err(|error| WriteError::io("write", &self.path, error).into())
    }
}

const HINT: &str = "--fresh forgets what is there; another --out keeps it";
