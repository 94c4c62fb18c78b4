//! How bad a finding is.

use serde::Serialize;

/// How bad a diagnostic is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// A habit of writing, reported once a file with its count; no change is needed.
    Note,
    /// The program is accepted, but may not do what its author means.
    Warning,
    /// The block is not executed and the program is refused.
    Error,
}

impl Severity {
    /// Its name in messages, tables and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Severity::Note => "note",
            Severity::Warning => "warning",
            Severity::Error => "error",
        }
    }
}

/// The severity of a word in the tables of problems and leniencies.
macro_rules! severity {
    (error) => {
        Severity::Error
    };
    (warning) => {
        Severity::Warning
    };
    (note) => {
        Severity::Note
    };
}

pub(crate) use severity;
