//! What a line does: its words in plain language, the modes and the position before and after, the
//! motions it makes.

mod modes;
mod text;
mod word;

pub use modes::Mode;

use lostmotion_base::span::Span;
use lostmotion_gcode::ops::Position;
use lostmotion_gcode::program::Program;
use lostmotion_gcode::program::watch;
use lostmotion_gcode::state::State;
use lostmotion_gcode::syntax::{Block, parse_block};
use serde::Serialize;
use std::io::BufRead;
use text::Seen;

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
    /// The file of that line; `None` for the program itself.
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
    fn of(state: &State, compensated: bool) -> Snapshot {
        Snapshot {
            modes: modes::modes(state, compensated),
            position: state.current,
            machine_position: state.machine(),
        }
    }
}

/// Runs a program to its end and explains a line of it; `None` if the program does not have the line.
///
/// ```
/// use lostmotion_gcode::{InterpreterConfig, Program};
/// use lostmotion_gcode_tools::explain::explain;
///
/// let text = b"G21 F600\no1 repeat [3]\nG91 G1 X10\no1 endrepeat\nM2\n";
/// let mut program = Program::new(&text[..], InterpreterConfig::default());
/// let line = explain(&mut program, 3).unwrap();
/// assert_eq!((line.text.as_str(), line.executions), ("G91 G1 X10", 3));
/// assert_eq!(line.last.unwrap().after.position[0], 30.0);
/// ```
pub fn explain<R: BufRead>(program: &mut Program<R>, line: u32) -> Option<Explanation> {
    let mut explanation = Explanation {
        line,
        ..Explanation::default()
    };
    let (mut first, mut last) = (None::<Seen>, None::<Seen>);
    watch(program, |event| {
        let span = event.place.span;
        if (span.file, span.line) == (0, line) && !event.passed {
            // The first time gives the words, with the values and modes that they had.
            if explanation.executions == 0 {
                explanation.text = String::from_utf8_lossy(event.interpreter.line()).into_owned();
                explanation.parts = word::parts(
                    event.interpreter.block(),
                    event.interpreter.line(),
                    Some(event),
                );
            }
            explanation.executions += 1;
            // Only the first and the last time are kept: memory does not grow with the rounds of a
            // loop.
            *(if first.is_none() {
                &mut first
            } else {
                &mut last
            }) = Some(Seen::of(event));
        } else if (span.file, span.line) == (0, line) {
            explanation.passed_over += 1;
            if explanation.text.is_empty() {
                unseen(&mut explanation, event.interpreter.line());
            }
        }
        // Later blocks may emit operations of this line that cutter compensation has held.
        if let Some(seen) = last.as_mut().or(first.as_mut()) {
            seen.take(event, line);
        }
    });
    explanation.first = first.map(|seen| seen.execution(program.interpreter()));
    explanation.last = last.map(|seen| seen.execution(program.interpreter()));
    // Lines that the interpreter was not given: the program ended before them.
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
        explanation.never = Some(
            "it was only passed over: its branch is not taken, or its subroutine is not called",
        );
    }
    Some(explanation)
}

/// A line that was not carried out.
fn unseen(explanation: &mut Explanation, text: &[u8]) {
    let mut block = Block::default();
    explanation.text = String::from_utf8_lossy(text).into_owned();
    if parse_block(text, &mut block, &lostmotion_gcode::Limits::default()).is_ok() {
        explanation.parts = word::parts(&block, text, None);
    }
}
