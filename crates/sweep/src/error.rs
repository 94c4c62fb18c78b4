//! What ends a sweep's plan, run or collection.

use lostmotion_report::WriteError;
use lostmotion_sim::machine::MachineError;
use lostmotion_sim::request::RequestError;
use std::path::Path;

/// Why there is no plan, run or table.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// A sweep file that cannot be read, or that does not make sense.
    #[error("{file}: {message}")]
    File {
        /// Its name.
        file: String,
        /// What is wrong.
        message: String,
        /// What to do; may be empty.
        hint: String,
    },
    /// A manifest that cannot be read.
    #[error("{file}, line {line}: {message}")]
    Manifest {
        /// Its name.
        file: String,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// A file of results with a line that is none.
    #[error("{file}, line {line}: this is no result of a sweep ({message})")]
    Results {
        /// Its name.
        file: String,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// Another run appends to the same file.
    #[error("another run is writing to {file}")]
    Busy {
        /// Its name.
        file: String,
    },
    /// An input that is not what was planned with.
    #[error("{what} has changed since the plan: {cells} cells need it, the first of them {key}")]
    Changed {
        /// The program, machine file or folder.
        what: String,
        /// How many cells.
        cells: usize,
        /// Key of the first.
        key: String,
    },
    /// A manifest of another release.
    #[error("{file} was planned by lostmotion {there}, this is {here}")]
    Release {
        /// The manifest.
        file: String,
        /// Its release.
        there: String,
        /// This one.
        here: &'static str,
    },
    /// A value that cannot be used.
    #[error("{message}")]
    Value {
        /// What is wrong, with the value.
        message: String,
        /// What may be given; may be empty.
        hint: String,
    },
    /// A machine that is not accepted.
    #[error("{0}")]
    Machine(#[from] MachineError),
    /// How programs are read or run is not accepted.
    #[error("{0}")]
    Request(#[from] RequestError),
    /// A file that cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A file that cannot be read.
    #[error("cannot read {what} {file}: {source}")]
    Read {
        /// What it is.
        what: &'static str,
        /// Its name.
        file: String,
        /// Why.
        source: std::io::Error,
    },
}

impl SweepError {
    /// A value that cannot be used.
    pub(crate) fn value(message: impl Into<String>, hint: impl Into<String>) -> SweepError {
        SweepError::Value {
            message: message.into(),
            hint: hint.into(),
        }
    }

    /// A file that cannot be read.
    pub(crate) fn unread(what: &'static str, file: &Path, source: std::io::Error) -> SweepError {
        SweepError::Read {
            what,
            file: file.display().to_string(),
            source,
        }
    }

    /// What to do about it; empty where the message says it.
    pub fn hint(&self) -> String {
        match self {
            SweepError::File { hint, .. } | SweepError::Value { hint, .. } => hint.clone(),
            SweepError::Results { .. } => {
                "take the line out, or name another file of results".to_owned()
            }
            SweepError::Busy { .. } => "give each shard a file of its own".to_owned(),
            SweepError::Changed { .. } => {
                "plan again: results of cells that are the same are kept".to_owned()
            }
            SweepError::Release { .. } => {
                "plan again with this release, or run with that".to_owned()
            }
            SweepError::Request(RequestError::Value { hint, .. }) => hint.clone(),
            _ => String::new(),
        }
    }
}
