//! What can go wrong while reading or writing files.

use std::path::{Path, PathBuf};

/// An output that could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The operating system refused.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// What was being done: `create`, `write`, `replace`.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file was asked for where a folder is.
    #[error("cannot write {}: it is a folder; name a file inside it", path.display())]
    IsFolder {
        /// The folder.
        path: PathBuf,
    },
    /// A folder was asked for where a file is.
    #[error("cannot write into {}: it is not a folder; name a folder, it is made if it does not exist", path.display())]
    NotFolder {
        /// The file.
        path: PathBuf,
    },
    /// A name inside an output folder that would lie outside of it.
    #[error("`{name}` is not a plain file name")]
    BadName {
        /// The name.
        name: String,
    },
}

impl WriteError {
    /// An I/O error with what was being done to which file.
    pub fn io(action: &'static str, path: &Path, source: std::io::Error) -> WriteError {
        WriteError::Io {
            action,
            path: path.to_path_buf(),
            source,
        }
    }
}

/// A table that could not be read. Lines count from 1, the header being line 1 of most files.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The operating system refused.
    #[error("cannot read {name}: {source}")]
    Io {
        /// The file's name.
        name: String,
        /// Why.
        source: std::io::Error,
    },
    /// Nothing in the file, or a header without a row.
    #[error("{name} has no data rows; it needs a header line and at least {needed} rows")]
    Empty {
        /// The file's name.
        name: String,
        /// How many rows are needed.
        needed: usize,
    },
    /// A needed column is not there.
    #[error("{name}, line {line}: there is no column {wanted}; the columns are: {found}")]
    MissingColumn {
        /// The file's name.
        name: String,
        /// Line of the header.
        line: u64,
        /// Name, or names of which one is needed.
        wanted: String,
        /// What the header has, shortened.
        found: String,
    },
    /// Two columns that both could be meant.
    #[error(
        "{name}, line {line}: both `{first}` and `{second}` could be the {what}; keep one, or name it"
    )]
    AmbiguousColumn {
        /// The file's name.
        name: String,
        /// Line of the header.
        line: u64,
        /// What is looked for.
        what: &'static str,
        /// One column.
        first: String,
        /// Another one.
        second: String,
    },
    /// Two columns of one name.
    #[error("{name}, line {line}: there are two columns `{column}`; rename or remove one")]
    RepeatedColumn {
        /// The file's name.
        name: String,
        /// Line of the header.
        line: u64,
        /// Their name.
        column: String,
    },
    /// A row with a different number of cells than the header.
    #[error("{name}, line {line}: {found} cells where the header has {wanted}")]
    Ragged {
        /// The file's name.
        name: String,
        /// Line of the row.
        line: u64,
        /// Cells in the header.
        wanted: u64,
        /// Cells in the row.
        found: u64,
    },
    /// A cell that is not what it has to be.
    #[error("{name}, line {line}, column `{column}`: `{value}` {why}\nhint: {hint}")]
    Cell {
        /// The file's name.
        name: String,
        /// Line of the row.
        line: u64,
        /// Header of the column.
        column: String,
        /// The cell's text, shortened.
        value: String,
        /// What is wrong with it.
        why: String,
        /// What to do.
        hint: &'static str,
    },
    /// Not a text table.
    #[error("{name}, line {line}: not a CSV table in UTF-8 (byte 0x{byte:02x} at offset {offset})")]
    NotText {
        /// The file's name.
        name: String,
        /// Line where it was seen.
        line: u64,
        /// The byte.
        byte: u8,
        /// Its offset in the file.
        offset: u64,
    },
}
