//! What is wrong with a log, and where.

use lostmotion_base::text::shortened;

/// Longest piece of a file shown in a message, characters. A choice: most of a terminal's line.
const LONGEST_SHOWN: usize = 60;

/// A log that could not be read. Lines, rows and messages count from 1.
///
/// ```
/// use lostmotion_logs::{LogReader, ReadOptions};
///
/// let text = "t_s,motor_mm\n0.000,1.5\n0.001,1.x\n";
/// let mut log = LogReader::new(text.as_bytes(), "log.csv", &ReadOptions::default()).unwrap();
/// let mut row = lostmotion_logs::Row::default();
/// assert!(log.next_row(&mut row).unwrap());
/// let error = log.next_row(&mut row).unwrap_err();
/// assert!(error.to_string().starts_with("log.csv, line 3, column `motor_mm`: `1.x`"));
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// The operating system refused.
    #[error("cannot read {name}: {source}")]
    Io {
        /// The file's name.
        name: String,
        /// Why.
        source: std::io::Error,
    },
    /// Something about the whole file, or about a choice that it leaves open.
    #[error("{name}: {what}{}", hinted(hint))]
    File {
        /// The file's name.
        name: String,
        /// What is wrong.
        what: String,
        /// What to do; may be empty.
        hint: String,
    },
    /// Something about one line.
    #[error("{name}, {counted} {line}: {what}{}", hinted(hint))]
    Line {
        /// The file's name.
        name: String,
        /// What is counted: line, row or message.
        counted: &'static str,
        /// The line.
        line: u64,
        /// What is wrong.
        what: String,
        /// What to do; may be empty.
        hint: String,
    },
    /// A cell that is not what it has to be.
    #[error(
        "{name}, {counted} {line}, column `{column}`: `{value}` {what}{}",
        hinted(hint)
    )]
    Cell {
        /// The file's name.
        name: Box<str>,
        /// What is counted: line, row or message.
        counted: &'static str,
        /// Line of the row.
        line: u64,
        /// Name of the column.
        column: Box<str>,
        /// The cell's text, shortened.
        value: Box<str>,
        /// What is wrong with it.
        what: Box<str>,
        /// What to do; may be empty.
        hint: Box<str>,
    },
}

fn hinted(hint: &str) -> String {
    if hint.is_empty() {
        String::new()
    } else {
        format!("\nhint: {hint}")
    }
}

impl LogError {
    pub(crate) fn file(name: &str, what: impl Into<String>, hint: impl Into<String>) -> LogError {
        LogError::File {
            name: name.to_owned(),
            what: what.into(),
            hint: hint.into(),
        }
    }

    pub(crate) fn line(
        name: &str,
        line: u64,
        what: impl Into<String>,
        hint: impl Into<String>,
    ) -> LogError {
        LogError::Line {
            name: name.to_owned(),
            counted: "line",
            line,
            what: what.into(),
            hint: hint.into(),
        }
    }

    /// The same in a log that has no lines.
    pub(crate) fn counting(mut self, what: &'static str) -> LogError {
        match &mut self {
            LogError::Line { counted, .. } | LogError::Cell { counted, .. } => *counted = what,
            LogError::Io { .. } | LogError::File { .. } => {}
        }
        self
    }

    pub(crate) fn cell(
        name: &str,
        line: u64,
        column: &str,
        value: &str,
        what: impl Into<String>,
        hint: impl Into<String>,
    ) -> LogError {
        LogError::Cell {
            name: name.into(),
            counted: "line",
            line,
            column: column.into(),
            value: shortened(value, LONGEST_SHOWN).into(),
            what: what.into().into(),
            hint: hint.into().into(),
        }
    }
}
