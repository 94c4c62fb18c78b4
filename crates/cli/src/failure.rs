//! Why a command ends without an answer.

use lostmotion::report::{ReadError, WriteError};
use std::io::Write;
use std::process::ExitCode;

/// Exit code for everything that is wrong with what was given.
const BAD_INPUT: u8 = 2;

/// A command that could not do its work; ends with exit code 2.
#[derive(Debug)]
pub(crate) enum Failure {
    /// A message, with what to do about it.
    Message {
        /// What is wrong, with place and values.
        text: String,
        /// What to do; may be empty.
        hint: String,
    },
    /// Diagnostics, rendered already.
    Rendered(String),
}

impl Failure {
    /// A message without a hint.
    pub(crate) fn message(text: impl Into<String>) -> Failure {
        Failure::Message {
            text: text.into(),
            hint: String::new(),
        }
    }

    /// A message with a hint.
    pub(crate) fn with_hint(text: impl Into<String>, hint: impl Into<String>) -> Failure {
        Failure::Message {
            text: text.into(),
            hint: hint.into(),
        }
    }

    /// Prints the failure on stderr and gives the exit code. A closed stderr is nobody's loss.
    pub(crate) fn report(&self) -> ExitCode {
        let mut stderr = std::io::stderr().lock();
        let _ = match self {
            Failure::Message { text, hint } if hint.is_empty() => writeln!(stderr, "error: {text}"),
            Failure::Message { text, hint } => writeln!(stderr, "error: {text}\nhint: {hint}"),
            Failure::Rendered(text) => writeln!(stderr, "{}", text.trim_end()),
        };
        ExitCode::from(BAD_INPUT)
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Failure {
        Failure::message(error.to_string())
    }
}

impl From<ReadError> for Failure {
    fn from(error: ReadError) -> Failure {
        Failure::message(error.to_string())
    }
}
