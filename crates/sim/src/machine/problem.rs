//! What is wrong with a machine file, with its place.

use lostmotion_base::text::legible;
use std::fmt;

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Line, from 1; 0 for a machine that was described in code.
    pub line: u32,
    /// Column in bytes, from 1.
    pub column: u32,
    /// Key with the tables it stands in: `axis.x.limits.jerk_mm_s3`; empty where no key is known.
    pub key: String,
    /// What is wrong, with the values.
    pub message: String,
    /// How to mend it; empty if there is nothing to say.
    pub hint: String,
    /// Name of the [`Change`](super::Change) whose value it is about; `None` for one of the file.
    pub option: Option<String>,
}

/// Message of a key that is not there.
pub(super) const MISSING: &str = "missing";

/// Message of a key that the type under it does not have.
pub(super) const UNKNOWN_KEY: &str = "unknown key";

impl Problem {
    /// The key that an unknown key was meant to be: told to be missing, too, it would only be told
    /// twice.
    fn meant(&self) -> Option<String> {
        let name = self
            .hint
            .strip_prefix("did you mean `")?
            .strip_suffix("`?")?;
        Some(match self.key.rsplit_once('.') {
            Some((table, _)) => format!("{table}.{name}"),
            None => name.to_owned(),
        })
    }
}

/// A machine file that cannot be used, with everything that was found wrong with it, in the order
/// of the text.
///
/// Its text has one line `file:line:column: key: message` a problem, and a line `hint: ...` below
/// where there is one; without line and column for a machine that was described in code.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct MachineError {
    /// Name of the file as given.
    pub file: String,
    /// What is wrong; never empty.
    pub problems: Vec<Problem>,
}

impl MachineError {
    /// One problem of a description that is no text.
    pub(crate) fn of(name: &str, key: &str, message: String, hint: &str) -> MachineError {
        MachineError {
            file: name.to_owned(),
            problems: vec![Problem {
                line: 0,
                column: 0,
                key: key.to_owned(),
                message,
                hint: hint.to_owned(),
                option: None,
            }],
        }
    }

    /// For a description that is no text: without places.
    pub(crate) fn without_places(mut self) -> MachineError {
        for problem in &mut self.problems {
            (problem.line, problem.column) = (0, 0);
        }
        self
    }

    /// Sorts by place and keeps one problem for each key, the first that was found.
    pub(crate) fn new(file: &str, found: Vec<Problem>) -> MachineError {
        let mut problems: Vec<Problem> = Vec::new();
        for problem in found {
            // A key may be found wrong more than once; the first finding is nearest to the cause.
            let told = |other: &Problem| !problem.key.is_empty() && other.key == problem.key;
            if !problems.iter().any(told) {
                problems.push(problem);
            }
        }
        // A misspelt key is unknown and the right one missing: one mistake, told once.
        let misnamed: Vec<String> = problems.iter().filter_map(Problem::meant).collect();
        problems.retain(|problem| problem.message != MISSING || !misnamed.contains(&problem.key));
        problems.sort_by_key(|problem| (problem.line, problem.column));
        MachineError {
            file: file.to_owned(),
            problems,
        }
    }
}

impl MachineError {
    /// The text of one of its problems without the hint: place, key and message.
    pub fn text_of(&self, problem: &Problem) -> String {
        let place = match (&problem.option, problem.line, self.file.as_str()) {
            (Some(option), ..) => format!("{option}: "),
            (None, 0, "") => String::new(),
            (None, 0, name) => format!("{name}: "),
            (None, line, file) => format!("{file}:{line}:{}: ", problem.column),
        };
        let key = match problem.key.as_str() {
            "" => String::new(),
            key => format!("{key}: "),
        };
        legible(&format!("{place}{key}{}", problem.message))
    }
}

impl fmt::Display for MachineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, problem) in self.problems.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{}", self.text_of(problem))?;
            if !problem.hint.is_empty() {
                write!(f, "\n  hint: {}", problem.hint)?;
            }
        }
        Ok(())
    }
}

impl std::error::Error for MachineError {}
