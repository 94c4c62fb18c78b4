//! Numbers and comments of blocks.

use lostmotion_gcode::ops::{Position, TextKind};

const LETTERS: [char; 9] = ['X', 'Y', 'Z', 'A', 'B', 'C', 'U', 'V', 'W'];

/// A letter with the shortest decimal that is read as this number.
pub(super) fn word(letter: char, value: f64) -> String {
    format!("{letter}{value}")
}

/// Words of the axes whose end is not where they are; X if there is none.
pub(super) fn axes(from: &Position, to: &Position) -> String {
    let moved = |(_, (from, to)): &(usize, (&f64, &f64))| from.to_bits() != to.to_bits();
    let words: Vec<String> = from
        .iter()
        .zip(to)
        .enumerate()
        .filter(moved)
        .map(|(axis, (_, to))| word(LETTERS[axis], *to))
        .collect();
    if words.is_empty() {
        word('X', to[0])
    } else {
        words.join(" ")
    }
}

/// Words of the axes that differ, none if there is none.
pub(super) fn changed(from: &Position, to: &Position) -> String {
    if from
        .iter()
        .zip(to)
        .all(|(from, to)| from.to_bits() == to.to_bits())
    {
        String::new()
    } else {
        axes(from, to)
    }
}

/// A text as a comment.
pub(super) fn comment(kind: TextKind, text: &str) -> String {
    let prefix = match kind {
        TextKind::Comment => "",
        TextKind::Message => "MSG,",
        TextKind::Print => "PRINT,",
        TextKind::Log => "LOG,",
    };
    if text.contains(['(', ')']) {
        format!(";{prefix}{text}")
    } else {
        format!("({prefix}{text})")
    }
}
