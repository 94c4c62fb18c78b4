//! The parts of a line and what they mean.

use super::Part;
use lostmotion_gcode::Code;
use lostmotion_gcode::codes::{self, AxisUse, CodeRow, Group};
use lostmotion_gcode::program::Event;
use lostmotion_gcode::state::{FeedMode, State};
use lostmotion_gcode::syntax::{Block, Keyword, Setting, Target, Text, Value, Word};

/// The parts of a line in its order. With the event of its execution, values and modes are known.
pub(super) fn parts(block: &Block, line: &[u8], event: Option<&Event<'_>>) -> Vec<Part> {
    // The bytes of a part as they are written, for the left column.
    let text = |text: Text| {
        let piece = line
            .get(text.start as usize..(text.start + text.len) as usize)
            .unwrap_or_default();
        String::from_utf8_lossy(piece).into_owned()
    };
    let mut parts: Vec<(u32, Part)> = Vec::new();
    if block.deletable {
        parts.push((
            0,
            Part {
                text: "/".to_owned(),
                meaning: "skipped if block delete is on".to_owned(),
            },
        ));
    }
    if let Some(number) = block.line_number {
        parts.push((
            0,
            Part {
                text: format!("N{number}"),
                meaning: "line number".to_owned(),
            },
        ));
    }
    if block.percent {
        parts.push((
            0,
            Part {
                text: "%".to_owned(),
                meaning: "start or end of the program".to_owned(),
            },
        ));
    }
    if let Some(part) = event.and_then(|event| modal_motion(block, event)) {
        parts.push((0, part));
    }
    if let Some((_, keyword)) = block.flow {
        // An O-word line is one part: its words are arguments, not modes.
        let shown = String::from_utf8_lossy(line.trim_ascii()).into_owned();
        parts.push((
            0,
            Part {
                text: shown,
                meaning: flow(keyword).to_owned(),
            },
        ));
    }
    for word in &block.words {
        parts.push((
            word.text.start,
            Part {
                text: text(word.text),
                meaning: meaning(word, block, event),
            },
        ));
    }
    for setting in &block.settings {
        parts.push((
            setting.text.start,
            Part {
                text: text(setting.text),
                meaning: setting_meaning(setting, event),
            },
        ));
    }
    if let Some(comment) = block.comment.filter(|_| block.flow.is_none()) {
        parts.push((
            comment.start,
            Part {
                text: text(comment),
                meaning: "comment".to_owned(),
            },
        ));
    }
    // Words, settings and comments were collected by kind: back to the order of the line.
    parts.sort_by_key(|(start, _)| *start);
    parts.into_iter().map(|(_, part)| part).collect()
}

/// Letters that call for the motion mode where the line names none.
const MOTION_LETTERS: &[u8] = b"XYZABCUVWIJK@^";

/// The motion mode of an earlier block that a line goes on with, without saying it.
fn modal_motion(block: &Block, event: &Event<'_>) -> Option<Part> {
    let row = event.before.motion.and_then(codes::find)?;
    let has_words = block
        .words
        .iter()
        .any(|word| MOTION_LETTERS.contains(&word.letter));
    // A code of the line may be the motion, or take the axis words itself; one that is computed
    // cannot be told.
    let is_own = |word: &Word| match (word.letter, row_of(word)) {
        (b'G' | b'M', Some(row)) => row.group == Group::Motion || row.axes != AxisUse::None,
        (b'G' | b'M', None) => true,
        _ => false,
    };
    if !has_words || block.words.iter().any(is_own) {
        return None;
    }
    Some(Part {
        text: format!("({})", row.code),
        meaning: format!(
            "not on the line: the {} in force, {}",
            row.group.name(),
            row.meaning
        ),
    })
}

const fn flow(keyword: Keyword) -> &'static str {
    match keyword {
        Keyword::Sub => "begins a subroutine",
        Keyword::EndSub => "ends a subroutine",
        Keyword::Call => "calls a subroutine",
        Keyword::Return => "returns from a subroutine",
        Keyword::If => "goes on here if the condition is not 0, else at the next branch",
        Keyword::ElseIf => "a further branch with a condition",
        Keyword::Else => "the branch that is taken if no other was",
        Keyword::EndIf => "end of the branches",
        Keyword::While => "repeats while the condition is not 0",
        Keyword::EndWhile => "goes back to the while",
        Keyword::Do => "begins a loop whose condition stands at its end",
        Keyword::Repeat => "repeats the lines up to `endrepeat`, as often as the number says",
        Keyword::EndRepeat => "goes back to the repeat",
        Keyword::Break => "leaves the loop",
        Keyword::Continue => "goes on with the next round of the loop",
        Keyword::Goto => "goes on at a line number, if there is a condition only where it is not 0",
        Keyword::Then => "sets a parameter if the condition is not 0",
        Keyword::Bare => "the program's number, or the start of a subroutine that ends with M99",
    }
}

fn setting_meaning(setting: &Setting, event: Option<&Event<'_>>) -> String {
    // Only a literal number is a known parameter; #[..] and #<name> are described in general.
    let number = match setting.target {
        Target::Numbered(Value::Number(number)) if (1.0..=5602.0).contains(&number) => {
            number as u16
        }
        _ => return "sets the parameter, after the rest of the line has been read".to_owned(),
    };
    match event {
        Some(event) => format!(
            "parameter #{number} becomes {}",
            event.interpreter.parameters().get(number)
        ),
        None => format!("sets parameter #{number}"),
    }
}

fn row_of(word: &Word) -> Option<&'static CodeRow> {
    match word.value {
        Value::Number(number) => Code::of(char::from(word.letter), number).and_then(codes::find),
        Value::Ops(..) => None,
    }
}

/// What a word means on its line.
fn meaning(word: &Word, block: &Block, event: Option<&Event<'_>>) -> String {
    let letter = char::from(word.letter);
    if matches!(letter, 'G' | 'M') {
        return row_of(word).map_or("a code that is not known".to_owned(), |row| {
            format!("{} ({})", row.meaning, row.group.name())
        });
    }
    // A value from the execution comes before the literal: it is in program units after
    // evaluation.
    let value = match (
        word.value,
        event.and_then(|event| event.interpreter.value_of(word)),
    ) {
        (Value::Number(number), None) => Some(number),
        (_, value) => value,
    };
    let shown = value.map_or("a computed value".to_owned(), |value| value.to_string());
    let state = event.map(|event| event.after);
    // The same letter means another thing for another code: find the code that takes it.
    let user = user(word, block, state);
    match letter {
        'X' | 'Y' | 'Z' | 'A' | 'B' | 'C' | 'U' | 'V' | 'W' => axis(letter, &shown, state, user),
        'F' => format!(
            "feed rate {shown}{}",
            state.map_or(String::new(), feed_unit)
        ),
        'S' => format!("spindle speed {shown}"),
        'T' => format!("selects tool {shown}"),
        'I' | 'J' | 'K' | 'R' | 'P' if user.is_some_and(is_arc) => arc_word(letter, &shown, state),
        _ => user.map_or(format!("{letter} = {shown}"), |row| {
            format!("{letter} of {}: {shown}", row.code)
        }),
    }
}

fn is_arc(row: &CodeRow) -> bool {
    row.code.letter == 'G' && matches!(row.code.tenths, 20 | 30)
}

/// The code of the line that takes a word, or the motion mode in force.
fn user(word: &Word, block: &Block, state: Option<&State>) -> Option<&'static CodeRow> {
    let letter = char::from(word.letter);
    let takes = |row: &&'static CodeRow| row.words.contains(letter);
    // A code of the line comes before the motion mode that is in force.
    let modal = state.and_then(|state| state.motion).and_then(codes::find);
    block
        .words
        .iter()
        .filter_map(row_of)
        .find(takes)
        .or(modal.filter(takes))
}

fn axis(letter: char, shown: &str, state: Option<&State>, _: Option<&CodeRow>) -> String {
    let Some(state) = state else {
        return format!("{letter} {shown}");
    };
    let unit = if "ABC".contains(letter) {
        "degrees"
    } else {
        state.units.name()
    };
    let diameter = if letter == 'X' && state.diameter {
        ", a diameter"
    } else {
        ""
    };
    let how = if state.absolute { "to" } else { "by" };
    format!("{letter} {how} {shown} {unit}{diameter}")
}

fn arc_word(letter: char, shown: &str, state: Option<&State>) -> String {
    match letter {
        'R' => format!("radius {shown}; negative: the longer way round"),
        'P' => format!("{shown} turns begun"),
        _ if state.is_some_and(|state| state.arc_absolute) => {
            format!("centre at {shown} in {}", axis_of(letter))
        }
        _ => format!("centre {shown} from the start in {}", axis_of(letter)),
    }
}

const fn axis_of(letter: char) -> char {
    match letter {
        'I' => 'X',
        'J' => 'Y',
        _ => 'Z',
    }
}

fn feed_unit(state: &State) -> String {
    match state.feed_mode {
        FeedMode::InverseTime => " per minute: one move takes 1/F min".to_owned(),
        FeedMode::PerMinute => format!(" {}/min", state.units.name()),
        FeedMode::PerRevolution => format!(" {}/rev", state.units.name()),
    }
}
