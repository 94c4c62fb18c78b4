//! What an operation does, in words.

use super::axes;
use super::{Call, Execution, Explanation, Snapshot};
use lostmotion_base::math;
use lostmotion_gcode::interpreter::Interpreter;
use lostmotion_gcode::ops::{ArcFeed, CanonicalOp, Position, SourcedOp, Units};
use lostmotion_gcode::program::Event;
use lostmotion_gcode::provenance::CallSite;
use lostmotion_gcode::state::State;
use std::fmt::{Display, Formatter, Result};

impl Display for Explanation {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        writeln!(f, "line {}: {}", self.line, self.text.trim())?;
        // The column of meanings starts after the widest word; a long expression does not widen
        // it.
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
            "  it has errors and was not carried out to its end: see `lostmotion check`"
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
    // X, Y and Z are always shown, other axes where they are not at zero.
    let shown = LETTERS
        .into_iter()
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

/// Letters of the axes by index.
const LETTERS: [char; 9] = ['X', 'Y', 'Z', 'A', 'B', 'C', 'U', 'V', 'W'];

/// Describes an operation; motion goes from `at`.
pub(super) fn describe(op: &CanonicalOp, at: &Position, units: Units) -> String {
    use CanonicalOp as O;
    let unit = units.name();
    match op {
        O::StraightTraverse(end) => straight("rapid", at, end, unit),
        O::StraightFeed(end) => straight("feed", at, end, unit),
        O::ArcFeed(feed) => arc(feed, at, unit),
        O::NurbsFeed(curve) => format!(
            "feed along a curve with {} control points to {}",
            curve.points.len(),
            targets(at, &curve.end)
        ),
        O::StraightProbe(probe) => format!("probe towards {}", targets(at, &probe.end)),
        O::Dwell(seconds) => format!("wait for {seconds} s"),
        O::SetFeedRate { rate, .. } => format!("feed rate {rate}"),
        O::SetG5xOffset { offset, .. } => format!("work offset {}", axes(offset)),
        O::SetG92Offset(offset) => format!("G92 offset {}", axes(offset)),
        O::UseToolLengthOffset(offset) => format!("tool offset {}", axes(offset)),
        O::SelectTool(tool) => format!("make tool {tool} ready"),
        O::ChangeTool(tool) => format!("put tool {tool} into the spindle"),
        O::SetSpindleSpeed { speed, .. } => format!("spindle speed {speed}"),
        O::StartSpindle { clockwise, .. } => format!(
            "start the spindle, {}",
            if *clockwise {
                "clockwise"
            } else {
                "counter-clockwise"
            }
        ),
        O::StopSpindle { .. } => "stop the spindle".to_owned(),
        O::ProgramStop => "stop until told to go on".to_owned(),
        O::ProgramEnd => "end the program".to_owned(),
        other => other.to_string(),
    }
}

/// Moves a place to the end of an operation.
pub(super) fn advance(op: &CanonicalOp, at: &mut Position) {
    match op {
        CanonicalOp::StraightTraverse(end) | CanonicalOp::StraightFeed(end) => *at = *end,
        CanonicalOp::ArcFeed(feed) => *at = feed.position(),
        CanonicalOp::NurbsFeed(curve) => *at = curve.end,
        CanonicalOp::StraightProbe(probe) => *at = probe.stop,
        _ => {}
    }
}

/// Axes that move with their ends.
fn targets(from: &Position, to: &Position) -> String {
    // An axis counts as moved where its coordinate changes to the bit.
    let moved = LETTERS
        .iter()
        .zip(from)
        .zip(to)
        .filter(|((_, from), to)| from != to);
    let texts: Vec<String> = moved
        .map(|((letter, from), to)| format!("{letter}{to} (from {from})"))
        .collect();
    if texts.is_empty() {
        "where it is".to_owned()
    } else {
        texts.join(" ")
    }
}

fn length(from: &Position, to: &Position) -> f64 {
    from.iter()
        .zip(to)
        .take(3)
        .map(|(from, to)| (to - from) * (to - from))
        .sum::<f64>()
        .sqrt()
}

fn straight(how: &str, from: &Position, to: &Position, unit: &str) -> String {
    let length = length(from, to);
    let length = if length > 0.0 {
        format!(", {length:.4} {unit}")
    } else {
        String::new()
    };
    format!("{how} to {}{length}", targets(from, to))
}

fn arc(arc: &ArcFeed, from: &Position, unit: &str) -> String {
    let [first, second, _] = arc.plane.axes();
    let letter = |axis: usize| LETTERS.get(axis).copied().unwrap_or('?');
    // The radius at the start; that of the end agrees with it within the arc tolerance.
    let radius = math::hypot(from[first] - arc.center[0], from[second] - arc.center[1]);
    // Canonical turns: the sign is the direction, the size counts begun turns.
    let way = if arc.turns < 0 {
        "clockwise"
    } else {
        "counter-clockwise"
    };
    let turns = if arc.turns.abs() > 1 {
        format!(", {} turns begun", arc.turns.abs())
    } else {
        String::new()
    };
    let center = format!(
        "{}{} {}{}",
        letter(first),
        arc.center[0],
        letter(second),
        arc.center[1]
    );
    format!(
        "{way} arc about {center} of radius {radius:.4} {unit}{turns} to {}",
        targets(from, &arc.position())
    )
}

/// Most actions that are listed for one execution.
const MOST_ACTIONS: usize = 100;

/// What one execution needs to be told.
pub(super) struct Seen {
    call_stack: u32,
    refused: bool,
    before: (State, bool),
    after: (State, bool),
    /// Operations with the places where they begin.
    ops: Vec<(Position, CanonicalOp)>,
    count: usize,
}

impl Seen {
    pub(super) fn of(event: &Event<'_>) -> Seen {
        Seen {
            call_stack: event.place.call_stack,
            refused: event.errors > 0,
            before: (event.before.clone(), event.compensated),
            after: (event.after.clone(), event.compensates),
            ops: Vec::new(),
            count: 0,
        }
    }

    /// Takes the operations of the line, which under cutter compensation come with later blocks.
    pub(super) fn take(&mut self, event: &Event<'_>, line: u32) {
        // Each operation starts where the one before it has ended.
        let mut at = event.before.current;
        for SourcedOp { op, block, .. } in event.ops {
            // Held operations keep the place of the block that they come from.
            if (block.span.file, block.span.line) == (0, line) {
                self.count += 1;
                if self.ops.len() < MOST_ACTIONS {
                    self.ops.push((at, op.clone()));
                }
            }
            advance(op, &mut at);
        }
    }

    pub(super) fn execution(&self, interpreter: &Interpreter) -> Execution {
        // The call stack of the execution, innermost call first.
        let call = |site: &CallSite| Call {
            sub: site.name.clone(),
            line: site.call.line,
            file: interpreter.file_name(site.call.file).map(str::to_owned),
        };
        Execution {
            calls: interpreter
                .call_stacks()
                .trace(self.call_stack)
                .map(call)
                .collect(),
            refused: self.refused,
            before: Snapshot::of(&self.before.0, self.before.1, interpreter.dialect()),
            after: Snapshot::of(&self.after.0, self.after.1, interpreter.dialect()),
            actions: self
                .ops
                .iter()
                .map(|(at, op)| describe(op, at, self.after.0.units))
                .collect(),
            action_count: self.count,
        }
    }
}
