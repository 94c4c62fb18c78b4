//! What a line does: its words in plain language, the modes and the position before and after, the
//! motions it makes.

mod text;
mod word;

use lostmotion_base::span::Span;
use lostmotion_gcode::Dialect;
use lostmotion_gcode::ops::{PathControl, Plane, Position, Units};
use lostmotion_gcode::program::{Program, watch};
use lostmotion_gcode::state::{FeedMode, State};
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
    fn of(state: &State, compensated: bool, dialect: Dialect) -> Snapshot {
        Snapshot {
            modes: modes(state, compensated, dialect),
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

/// One mode.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Mode {
    /// What it is.
    pub name: &'static str,
    /// What it is set to.
    pub value: String,
}

/// Axis letters with values that are not zero.
pub(super) fn axes(position: &Position) -> String {
    // Axes at zero are left out: most offsets name two or three.
    let one = |(letter, value): (char, &f64)| format!("{letter}{value}");
    let some: Vec<String> = "XYZABCUVW"
        .chars()
        .zip(position)
        .filter(|(_, value)| **value != 0.0)
        .map(one)
        .collect();
    if some.is_empty() {
        "none".to_owned()
    } else {
        some.join(" ")
    }
}

fn switch(on: bool) -> &'static str {
    if on { "on" } else { "off" }
}

fn path(control: PathControl, merge: f64) -> String {
    match control {
        PathControl::ExactPath => "exact path (G61)".to_owned(),
        PathControl::ExactStop => "exact stop (G61.1)".to_owned(),
        PathControl::Continuous { tolerance: 0.0 } => "continuous (G64)".to_owned(),
        PathControl::Continuous { tolerance } => {
            format!("continuous within {tolerance} (G64 P), merging within {merge}")
        }
    }
}

fn feed(state: &State) -> String {
    let unit = state.units.name();
    match state.feed_mode {
        FeedMode::InverseTime => "inverse time, one F a move (G93)".to_owned(),
        FeedMode::PerMinute => format!("{} {unit}/min (G94)", state.feed),
        FeedMode::PerRevolution => format!("{} {unit}/rev (G95)", state.feed),
    }
}

fn spindle(state: &State) -> String {
    let spindle = &state.spindle;
    let turns = match spindle.clockwise {
        None => "stopped (M5)",
        Some(true) => "clockwise (M3)",
        Some(false) => "counter-clockwise (M4)",
    };
    // Under G96 the S is a cutting speed, otherwise revolutions per minute.
    let unit = if spindle.surface_limit.is_some() {
        "surface speed (G96)"
    } else {
        "rev/min"
    };
    format!("{turns}, S{} {unit}", spindle.speed)
}

/// All modes of a state.
pub(super) fn modes(state: &State, compensated: bool, dialect: Dialect) -> Vec<Mode> {
    let mode = |name, value: String| Mode { name, value };
    let plane = match state.plane {
        Plane::Xy => "XY (G17)",
        Plane::Zx => "ZX (G18)",
        Plane::Yz => "YZ (G19)",
    };
    let offsets = &state.offsets;
    let system = dialect.system_name(state.system);
    let compensation = if compensated {
        "on (G41, G42)"
    } else {
        "off (G40)"
    };
    vec![
        mode(
            "motion",
            state
                .motion
                .map_or("none (G80)".to_owned(), |code| code.to_string()),
        ),
        mode(
            "units",
            if state.units == Units::Mm {
                "mm (G21)"
            } else {
                "inch (G20)"
            }
            .to_owned(),
        ),
        mode(
            "distances",
            if state.absolute {
                "absolute (G90)"
            } else {
                "incremental (G91)"
            }
            .to_owned(),
        ),
        mode(
            "arc centres",
            if state.arc_absolute {
                "absolute (G90.1)"
            } else {
                "relative (G91.1)"
            }
            .to_owned(),
        ),
        mode("plane", plane.to_owned()),
        mode("feed", feed(state)),
        mode("spindle", spindle(state)),
        mode(
            "tool",
            format!(
                "T{} in the spindle, {}",
                state.loaded_tool,
                state
                    .selected_tool
                    .map_or("none selected".to_owned(), |tool| format!(
                        "T{tool} selected"
                    ))
            ),
        ),
        mode("tool offset", axes(&offsets.tool)),
        mode("work offset", format!("{system}: {}", axes(&offsets.g5x))),
        mode("rotation", format!("{} degrees", offsets.rotation_deg)),
        mode("G92 offset", axes(&offsets.g92)),
        mode("cutter compensation", compensation.to_owned()),
        mode("path", path(state.path_control, state.merge_tolerance)),
        mode(
            "coolant",
            format!("flood {}, mist {}", switch(state.flood), switch(state.mist)),
        ),
        mode(
            "cycles return to",
            if state.retract_to_start {
                "where they began (G98)"
            } else {
                "R (G99)"
            }
            .to_owned(),
        ),
        mode(
            "X",
            if state.diameter {
                "a diameter (G7)"
            } else {
                "a radius (G8)"
            }
            .to_owned(),
        ),
    ]
}
