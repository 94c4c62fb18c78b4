//! An explanation for people.

use super::{Execution, Explanation, Snapshot};
use std::fmt::{Display, Formatter, Result};

const LETTERS: &str = "XYZABCUVW";

impl Display for Explanation {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        writeln!(f, "line {}: {}", self.line, self.text.trim())?;
        let width = self
            .parts
            .iter()
            .map(|part| part.text.chars().count())
            .max()
            .unwrap_or(0)
            .min(24);
        for part in &self.parts {
            writeln!(f, "  {:width$}  {}", part.text, part.meaning)?;
        }
        if let Some(never) = self.never {
            return writeln!(f, "\nnever carried out: {never}");
        }
        match self.executions {
            1 => writeln!(f, "\ncarried out once")?,
            times => writeln!(f, "\ncarried out {times} times")?,
        }
        if let Some(first) = &self.first {
            execution(
                f,
                if self.last.is_some() {
                    "the first time"
                } else {
                    ""
                },
                first,
            )?;
        }
        self.last
            .as_ref()
            .map_or(Ok(()), |last| execution(f, "the last time", last))
    }
}

fn execution(f: &mut Formatter<'_>, title: &str, execution: &Execution) -> Result {
    if !title.is_empty() {
        writeln!(f, "\n{title}:")?;
    }
    for call in &execution.calls {
        let file = call
            .file
            .as_deref()
            .map_or(String::new(), |file| format!(" of {file}"));
        writeln!(f, "  in {}, called from line {}{file}", call.sub, call.line)?;
    }
    if execution.refused {
        writeln!(
            f,
            "  it has errors and was not carried out to its end: see `lostmotion lint`"
        )?;
    }
    for action in &execution.actions {
        writeln!(f, "  - {action}")?;
    }
    if execution.action_count > execution.actions.len() {
        writeln!(
            f,
            "  - and {} more",
            execution.action_count - execution.actions.len()
        )?;
    }
    if execution.action_count == 0 {
        writeln!(f, "  - it makes the machine do nothing at once")?;
    }
    state(f, &execution.before, &execution.after)
}

fn position(snapshot: &Snapshot, machine: bool) -> String {
    let values = if machine {
        &snapshot.machine_position
    } else {
        &snapshot.position
    };
    let shown = LETTERS
        .chars()
        .zip(values)
        .enumerate()
        .filter(|(axis, (_, value))| *axis < 3 || **value != 0.0);
    shown
        .map(|(_, (letter, value))| format!("{letter}{value:.4}"))
        .collect::<Vec<_>>()
        .join(" ")
}

fn state(f: &mut Formatter<'_>, before: &Snapshot, after: &Snapshot) -> Result {
    writeln!(f, "  before and after:")?;
    line(
        f,
        "position",
        &position(before, false),
        &position(after, false),
    )?;
    line(
        f,
        "machine",
        &position(before, true),
        &position(after, true),
    )?;
    for (before, after) in before.modes.iter().zip(&after.modes) {
        line(f, before.name, &before.value, &after.value)?;
    }
    Ok(())
}

fn line(f: &mut Formatter<'_>, name: &str, before: &str, after: &str) -> Result {
    if before == after {
        writeln!(f, "    {name:19} {before}")
    } else {
        writeln!(f, "  * {name:19} {before}  ->  {after}")
    }
}
