//! What a line does: its words in plain language, the modes and the position before and after, the motions it makes.

mod action;
mod modes;
mod text;
mod word;

pub use modes::Mode;

use crate::interpreter::Interpreter;
use crate::ops::{Position, SourcedOp};
use crate::program::Program;
use crate::state::State;
use crate::syntax::{Block, parse_block};
use crate::trace::{Event, watch};
use lostmotion_base::span::Span;
use serde::Serialize;
use std::io::BufRead;

/// Most actions that are listed for one execution.
const ACTIONS: usize = 100;

/// A line explained.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Explanation {
    /// Its number.
    pub line: u32,
    /// Its text; bytes that are not UTF-8 are replaced.
    pub text: String,
    /// What its parts mean, in the order of the line.
    pub parts: Vec<Part>,
    /// How often it was carried out.
    pub executions: u64,
    /// How often it was passed over: in a branch that is not taken, or in a definition.
    pub passed_over: u64,
    /// Why it was never carried out, if so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub never: Option<&'static str>,
    /// The first time it was carried out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first: Option<Execution>,
    /// The last time, if there was more than one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub last: Option<Execution>,
}

/// A part of a line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Part {
    /// As it is written.
    pub text: String,
    /// What it means.
    pub meaning: String,
}

/// One time that a line was carried out.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Execution {
    /// The calls that led to it, innermost first.
    pub calls: Vec<Call>,
    /// It has errors, and was not carried out to its end.
    pub refused: bool,
    /// Before it.
    pub before: Snapshot,
    /// After it.
    pub after: Snapshot,
    /// What it makes the machine do, the first of it.
    pub actions: Vec<String>,
    /// How many actions there were.
    pub action_count: usize,
}

/// A call of a subroutine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Call {
    /// The subroutine.
    pub sub: String,
    /// The line that calls it.
    pub line: u32,
    /// The file of that line; none for the program itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
}

/// Modes and position at one moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Snapshot {
    /// The modes.
    pub modes: Vec<Mode>,
    /// X Y Z A B C U V W of the program, program units and degrees.
    pub position: Position,
    /// The same of the machine: with all offsets, those of the tool too.
    pub machine_position: Position,
}

impl Snapshot {
    fn of(state: &State) -> Snapshot {
        Snapshot { modes: modes::modes(state), position: state.current, machine_position: state.machine() }
    }
}

/// Runs a program to its end and explains a line of it; none if the program does not have the line.
pub fn explain<R: BufRead>(program: &mut Program<R>, line: u32) -> Option<Explanation> {
    let mut explanation = Explanation { line, ..Explanation::default() };
    let mut known = false;
    watch(program, |event| {
        let span = event.place.span;
        let is_here = (span.file, span.line) == (0, line);
        if is_here && !event.passed {
            if !known {
                explanation.text = String::from_utf8_lossy(event.interpreter.line()).into_owned();
                explanation.parts = word::parts(event.interpreter.block(), event.interpreter.line(), Some(event));
                known = true;
            }
            explanation.executions += 1;
            *slot(&mut explanation) = Some(execution(event));
        } else if is_here {
            explanation.passed_over += 1;
            if explanation.text.is_empty() {
                unseen(&mut explanation, event.interpreter.line());
            }
        }
        if explanation.executions > 0 {
            add_actions(&mut explanation, event, line);
        }
    });
    while let Some((text, Span { line: number, .. })) = program.next_line() {
        if number == line {
            unseen(&mut explanation, text);
            explanation.never = Some("the program ends before it");
            return Some(explanation);
        }
    }
    if explanation.executions == 0 {
        if explanation.passed_over == 0 {
            return None;
        }
        explanation.never = Some("it was only passed over: its branch is not taken, or its subroutine is not called");
    }
    Some(explanation)
}

/// The execution that an event belongs to.
fn slot(explanation: &mut Explanation) -> &mut Option<Execution> {
    if explanation.executions > 1 { &mut explanation.last } else { &mut explanation.first }
}

/// A line that was not carried out.
fn unseen(explanation: &mut Explanation, text: &[u8]) {
    let mut block = Block::default();
    explanation.text = String::from_utf8_lossy(text).into_owned();
    if parse_block(text, &mut block, &crate::Limits::default()).is_ok() {
        explanation.parts = word::parts(&block, text, None);
    }
}

fn execution(event: &Event<'_>) -> Execution {
    Execution {
        calls: calls(event.interpreter, event.place.call_stack),
        refused: event.errors > 0,
        before: Snapshot::of(event.before),
        after: Snapshot::of(event.after()),
        actions: Vec::new(),
        action_count: 0,
    }
}

fn calls(interpreter: &Interpreter, call_stack: u32) -> Vec<Call> {
    let call = |site: &crate::CallSite| Call {
        sub: site.name.clone(),
        line: site.call.line,
        file: interpreter.file_name(site.call.file).map(str::to_owned),
    };
    interpreter.call_stacks().trace(call_stack).map(call).collect()
}

/// Actions of the line, which under cutter compensation come with later blocks.
fn add_actions(explanation: &mut Explanation, event: &Event<'_>, line: u32) {
    let Some(execution) = slot(explanation) else { return };
    let mut at = event.before.current;
    for SourcedOp { op, block } in event.ops {
        let text = action::describe(op, &mut at, event.after().units);
        if (block.span.file, block.span.line) == (0, line) {
            execution.action_count += 1;
            if execution.actions.len() < ACTIONS {
                execution.actions.push(text);
            }
        }
    }
}
