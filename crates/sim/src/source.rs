//! Where a part program comes from.

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A part program that can be read several times, from a file or from memory.
///
/// A run reads it several times, each time from the start on and without holding it: to check it,
/// to count its lines, to simulate it, to fetch the text of the worst blocks. A pipe cannot be a
/// program for that reason; read it into memory first.
#[derive(Clone, Debug)]
pub struct ProgramSource {
    name: String,
    origin: Origin,
}

#[derive(Clone, Debug)]
enum Origin {
    File(PathBuf),
    Bytes(Arc<[u8]>),
}

impl ProgramSource {
    /// A file; its path as given is its name.
    pub fn from_path(path: impl AsRef<Path>) -> ProgramSource {
        let path = path.as_ref();
        ProgramSource {
            name: path.display().to_string(),
            origin: Origin::File(path.to_path_buf()),
        }
    }

    /// A program in memory.
    pub fn from_bytes(name: impl Into<String>, bytes: impl Into<Arc<[u8]>>) -> ProgramSource {
        ProgramSource {
            name: name.into(),
            origin: Origin::Bytes(bytes.into()),
        }
    }

    /// Name for messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Size in bytes.
    ///
    /// # Errors
    /// The file cannot be read, or is a folder.
    pub fn len(&self) -> std::io::Result<u64> {
        match &self.origin {
            Origin::Bytes(bytes) => Ok(bytes.len() as u64),
            Origin::File(path) => {
                let metadata = std::fs::metadata(path)?;
                if metadata.is_dir() {
                    return Err(std::io::Error::new(
                        std::io::ErrorKind::IsADirectory,
                        "is a folder, not a part program",
                    ));
                }
                Ok(metadata.len())
            }
        }
    }

    /// Whether there is nothing in it.
    ///
    /// # Errors
    /// As [`ProgramSource::len`].
    pub fn is_empty(&self) -> std::io::Result<bool> {
        Ok(self.len()? == 0)
    }

    /// A reader from the start.
    ///
    /// # Errors
    /// The file cannot be opened.
    pub fn open(&self) -> std::io::Result<Box<dyn BufRead + Send>> {
        Ok(match &self.origin {
            Origin::Bytes(bytes) => Box::new(Cursor::new(bytes.clone())),
            Origin::File(path) => Box::new(BufReader::with_capacity(1 << 16, File::open(path)?)),
        })
    }
}
