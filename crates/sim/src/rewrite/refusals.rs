//! What is refused in a program, all of it in one run: each cause with the lines that it stands on.

use super::RewriteError;
use std::collections::BTreeSet;

/// Causes that are told one by one. A choice: what a screen holds.
const MOST_CAUSES: usize = 20;
/// Lines that are named for one cause. A choice.
const MOST_LINES: usize = 8;

/// A cause and where it stands.
#[derive(Debug)]
struct Cause {
    line: usize,
    column: Option<usize>,
    what: String,
    /// Further lines with the same, at most [`MOST_LINES`] of them, and how many there are.
    others: Vec<usize>,
    count: usize,
}

/// Lines that are refused.
#[derive(Debug, Default)]
pub(super) struct Refusals {
    causes: Vec<Cause>,
    lines: BTreeSet<usize>,
    /// Lines with causes beyond those that are told.
    untold: usize,
}

impl Refusals {
    /// Takes the refusal of a line; the first of each line counts.
    pub(super) fn add(&mut self, error: RewriteError) {
        let RewriteError::Line { line, column, what } = error else {
            return;
        };
        if !self.lines.insert(line) {
            return;
        }
        if let Some(cause) = self.causes.iter_mut().find(|cause| cause.what == what) {
            cause.count += 1;
            if cause.others.len() < MOST_LINES {
                cause.others.push(line);
            }
        } else if self.causes.len() < MOST_CAUSES {
            self.causes.push(Cause {
                line,
                column,
                what,
                others: Vec::new(),
                count: 0,
            });
        } else {
            self.untold += 1;
        }
    }

    /// All that is refused as one error; none if nothing is.
    pub(super) fn told(self) -> Option<RewriteError> {
        let mut causes = self.causes;
        causes.sort_by_key(|cause| cause.line);
        let mut all: Vec<RewriteError> = causes.into_iter().map(Cause::told).collect();
        if self.untold > 0 {
            all.push(RewriteError::Machine(format!(
                "{} more lines are refused for other reasons",
                self.untold
            )));
        }
        if all.len() > 1 {
            return Some(RewriteError::Lines(all));
        }
        all.pop()
    }
}

impl Cause {
    fn told(self) -> RewriteError {
        let Cause {
            line,
            column,
            mut what,
            others,
            count,
        } = self;
        if count > 0 {
            let named: Vec<String> = others.iter().map(usize::to_string).collect();
            let more = match count - others.len() {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            what.push_str(&format!(" (so on lines {}{more})", named.join(", ")));
        }
        RewriteError::Line { line, column, what }
    }
}
