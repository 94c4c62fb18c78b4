//! The new text read again: its end points are held against those meant, and what it is refused for
//! is told by the line of the original.

use super::text::refuse;
use super::{Original, ROUNDING_MM, RewriteError, STILL_MM, Text};
use crate::error::SimError;
use crate::machine::Machine;
use crate::options::SimulateOptions;
use crate::program::Program;
use crate::simulation::Simulation;
use lostmotion_gcode::{Diagnostic, Severity};

/// Reads the new program as any other and holds the end points of its moves against those meant.
pub(super) fn read_again(
    new: &Program,
    machine: &Machine,
    options: &SimulateOptions,
    text: &Text,
    steps: &[Original],
) -> Result<(), RewriteError> {
    let refused = |error: SimError| of_new(error.into(), &text.steps, steps);
    let curves = Simulation::new(new, machine)
        .options(options.clone())
        .curves()
        .map_err(refused)?;
    let mut meant = text.ends.iter().peekable();
    let mut check = |line: usize, end: [f64; 3]| {
        // Moves that go nowhere are no moves of the front end. A line that stays as it is may go on the
        // way to its place by more moves than before, from half a gap aside: its last one counts.
        while meant.next_if(|(on, _)| *on < line).is_some() {}
        let mut found = None;
        while let Some((_, place)) = meant.next_if(|(on, _)| *on == line) {
            found = Some(*place);
        }
        let off = found.map_or(f64::INFINITY, |meant| {
            (0..3)
                .map(|axis| (end[axis] - meant[axis]).abs())
                .fold(0.0, f64::max)
        });
        if off <= ROUNDING_MM {
            return Ok(());
        }
        let error = format!(
            "line {line} of the new program does not lead where it is meant to: nothing is written; please report this program"
        );
        let index = text.steps.get(line - 1).copied().flatten();
        Err(match index.and_then(|index| steps.get(index)) {
            Some(step) => refuse(step.line, error),
            None => RewriteError::Machine(error),
        })
    };
    // Where the last move of the present line ends.
    let mut last: Option<(usize, [f64; 3])> = None;
    for item in curves {
        let item = item.map_err(refused)?;
        // A line without a way, such as what an extruder does alone.
        if item.motion.curve.length() <= STILL_MM {
            continue;
        }
        let line = item.motion.block.span.line as usize;
        let end = item.motion.curve.end().linear();
        if let Some((before, end)) = last.replace((line, end)).filter(|(on, _)| *on != line) {
            check(before, end)?;
        }
    }
    last.map_or(Ok(()), |(line, end)| check(line, end))
}

/// Why the new program cannot be run, by the line of the original that it comes from.
pub(super) fn of_new(
    error: RewriteError,
    of_lines: &[Option<usize>],
    steps: &[Original],
) -> RewriteError {
    let found = match &error {
        RewriteError::Sim(SimError::Program { diagnostics, .. }) => {
            let is_error = |found: &&Diagnostic| found.severity() == Severity::Error;
            let first = diagnostics.kept().iter().find(is_error);
            first.map(|found| (found.place, found.message(), found.hint()))
        }
        RewriteError::Sim(SimError::Travel { excesses, hint, .. }) => excesses
            .first()
            .map(|excess| (excess.block, excess.to_string(), Some(hint.clone()))),
        _ => None,
    };
    let Some((block, message, hint)) = found else {
        return error;
    };
    let new = block.span.line as usize;
    let at = new.checked_sub(1).and_then(|line| of_lines.get(line));
    let step = at.copied().flatten().and_then(|index| steps.get(index));
    let what = format!(
        "with half a gap added it cannot be run: {message}{}",
        hint.map_or_else(String::new, |hint| format!("; {hint}"))
    );
    match step {
        Some(step) => RewriteError::Line {
            line: step.line,
            column: None,
            what,
        },
        None => RewriteError::Machine(format!("line {new} of the new program: {what}")),
    }
}
