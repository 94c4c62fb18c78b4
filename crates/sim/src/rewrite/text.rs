//! Lines of a program: what they say, and their words with other values.

use super::RewriteError;
use lostmotion_gcode::syntax::{Block, Value, parse_block};
use lostmotion_gcode::{Limits, Units};
use std::borrow::Cow;

/// Letters of the axes that are moved.
pub(super) const LETTERS: [u8; 3] = *b"XYZ";
/// Mark in the header of a new program, by which it is known again.
pub(super) const MARK: &str = "rewritten by lostmotion";

/// G codes that a line may have whose end point is moved.
const PLAIN: [f64; 27] = [
    0.0, 1.0, 2.0, 3.0, 17.0, 18.0, 19.0, 20.0, 21.0, 40.0, 43.0, 49.0, 54.0, 55.0, 56.0, 57.0,
    58.0, 59.0, 61.0, 61.1, 64.0, 80.0, 90.0, 91.1, 94.0, 97.0, 98.0,
];

/// G codes under which end points do not say where the tool is, with what they are.
const REFUSED: [(f64, &str); 8] = [
    (90.1, "absolute centres (G90.1)"),
    (41.0, "cutter compensation (G41)"),
    (42.0, "cutter compensation (G42)"),
    (16.0, "polar coordinates (G16)"),
    (51.0, "scaling (G51)"),
    (68.0, "rotated coordinates (G68)"),
    (93.0, "inverse time feed (G93)"),
    (18.2, "another control's plane"),
];

/// A line of the program.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub(super) text: Vec<u8>,
    pub(super) end: Vec<u8>,
    /// mm for a unit of its words.
    pub(super) mm: f64,
    /// Feed in force, as the program wrote it.
    pub(super) feed: Option<String>,
    block: Block,
}

/// The lines of a program, with the unit and the feed that are in force; `units` are those in which it
/// starts.
///
/// # Errors
/// A line that cannot be read, that switches to what is not rewritten, or that marks a program which
/// was rewritten before.
pub(super) fn lines(
    bytes: &[u8],
    units: Units,
    limits: &Limits,
) -> Result<Vec<Line>, RewriteError> {
    let (mut all, mut mm, mut feed, mut is_relative) = (Vec::new(), units.mm(), None, false);
    for (index, raw) in bytes.split_inclusive(|byte| *byte == b'\n').enumerate() {
        let cut = raw.iter().rposition(|byte| !matches!(byte, b'\n' | b'\r'));
        let (text, end) = raw.split_at(cut.map_or(0, |at| at + 1));
        let number = index + 1;
        let mut block = Block::default();
        parse_block(text, &mut block, limits)
            .map_err(|fault| refuse(number, fault.problem.to_string()))?;
        if comment(text, &block).is_some_and(|comment| comment.contains(MARK)) {
            return Err(refuse(
                number,
                "the program has been rewritten already, and would compensate twice: rewrite the original program instead",
            ));
        }
        for code in codes(&block, b'G') {
            if let Some((_, what)) = REFUSED.iter().find(|(refused, _)| *refused == code) {
                return Err(refuse(number, format!("{what} are not rewritten")));
            }
            if code == 20.0 {
                mm = Units::Inch.mm();
            } else if code == 21.0 {
                mm = Units::Mm.mm();
            } else if code == 90.0 || code == 91.0 {
                is_relative = code == 91.0;
            }
        }
        if is_relative && goes_a_distance(&block) {
            return Err(refuse(
                number,
                "distances (G91) are not rewritten, but for a way home like G91 G28 Z0",
            ));
        }
        let line = Line {
            text: text.to_vec(),
            end: end.to_vec(),
            mm,
            feed: None,
            block,
        };
        if let Some(word) = line.word(b'F') {
            feed = Some(word);
        }
        all.push(Line {
            feed: feed.clone(),
            ..line
        });
    }
    Ok(all)
}

/// Whether a line under G91 moves by a distance. `G28 Z0` and `G30 Z0` do not: they go to a place of the machine from
/// where the axis stands.
fn goes_a_distance(block: &Block) -> bool {
    let goes_home = codes(block, b'G').any(|code| code == 28.0 || code == 30.0);
    block.words.iter().any(|word| {
        b"XYZABCUVWIJKR".contains(&word.letter)
            && !(goes_home && matches!(word.value, Value::Number(value) if value == 0.0))
    })
}

/// The comment of a line, in whichever way it is written.
fn comment<'a>(text: &'a [u8], block: &Block) -> Option<Cow<'a, str>> {
    let place = block.comment?;
    let (from, to) = (place.start as usize, (place.start + place.len) as usize);
    text.get(from..to).map(String::from_utf8_lossy)
}

pub(super) fn refuse(line: usize, what: impl Into<String>) -> RewriteError {
    RewriteError::Line {
        line,
        what: what.into(),
    }
}

/// The literal codes of a letter on a line.
fn codes(block: &Block, letter: u8) -> impl Iterator<Item = f64> {
    block.words.iter().filter_map(move |word| match word.value {
        Value::Number(value) if word.letter == letter => Some(value),
        _ => None,
    })
}

impl Line {
    /// Why its end point cannot be moved, if it cannot.
    pub(super) fn is_not_plain(&self) -> Option<String> {
        let block = &self.block;
        if block.flow.is_some() || !block.settings.is_empty() {
            return Some("O-words and parameters are not rewritten".to_owned());
        }
        if block.deletable {
            return Some("a block that may be skipped (/) is not rewritten".to_owned());
        }
        let expression =
            |word: &&lostmotion_gcode::syntax::Word| !matches!(word.value, Value::Number(_));
        if let Some(word) = block.words.iter().find(expression) {
            return Some(format!(
                "{} is an expression: write the number",
                char::from(word.letter)
            ));
        }
        let odd = codes(block, b'G').find(|code| !PLAIN.contains(code));
        odd.map(|code| format!("G{code} is not rewritten: put the move on a line of its own"))
    }

    /// The value of a word as a number, in the line's unit.
    pub(super) fn value(&self, letter: u8) -> Option<f64> {
        codes(&self.block, letter).next()
    }

    /// A word as it stands.
    fn word(&self, letter: u8) -> Option<String> {
        let word = self.block.words.iter().find(|word| word.letter == letter)?;
        let (from, to) = (
            word.text.start as usize,
            (word.text.start + word.text.len) as usize,
        );
        let text = self.text.get(from..to)?;
        Some(String::from_utf8_lossy(text).into_owned())
    }

    /// Whether it says which motion it makes.
    pub(super) fn has_motion(&self) -> bool {
        codes(&self.block, b'G').any(|code| code <= 3.0)
    }

    /// What it takes from where X, Y and Z stand, if anything: an offset or a place that is kept.
    pub(super) fn takes_the_place(&self) -> Option<&'static str> {
        let has_axis = [b'X', b'Y', b'Z']
            .into_iter()
            .any(|letter| self.block.words.iter().any(|word| word.letter == letter));
        let level = self.value(b'L');
        codes(&self.block, b'G').find_map(|code| match code {
            92.0 if has_axis => Some("G92"),
            10.0 if has_axis && level == Some(20.0) => Some("G10 L20"),
            10.0 if has_axis && level == Some(10.0) => Some("G10 L10"),
            10.0 if has_axis && level == Some(11.0) => Some("G10 L11"),
            28.1 => Some("G28.1"),
            30.1 => Some("G30.1"),
            _ => None,
        })
    }

    /// Whether nothing may come between its move and its other words.
    pub(super) fn has_code_behind_the_move(&self) -> bool {
        let stops = [0.0, 1.0, 2.0, 5.0, 9.0, 30.0, 60.0];
        codes(&self.block, b'M').any(|code| stops.contains(&code)) || self.value(b'E').is_some()
    }

    /// Whether it is `%` or the number of the program, before which nothing may stand.
    pub(super) fn is_head(&self) -> bool {
        self.block.percent || self.block.words.is_empty() && self.text.first() == Some(&b'O')
    }

    /// The line with these words: those that it has get the values, the others are put behind its
    /// last word.
    pub(super) fn with(&self, words: &[(u8, String)]) -> Vec<u8> {
        let mut text = self.text.clone();
        let mut missing = String::new();
        // From the end on, so that places before stay right.
        let mut found: Vec<(usize, usize, &str)> = Vec::new();
        for (letter, value) in words {
            let word = self.block.words.iter().find(|word| word.letter == *letter);
            match word {
                // Behind the letter.
                Some(word) if *letter != b'G' => found.push((
                    word.text.start as usize + 1,
                    (word.text.start + word.text.len) as usize,
                    value,
                )),
                _ => missing.push_str(&format!(" {}{value}", char::from(*letter))),
            }
        }
        let behind = self
            .block
            .words
            .iter()
            .map(|word| (word.text.start + word.text.len) as usize);
        let behind = behind.max().unwrap_or(text.len());
        found.push((behind, behind, &missing));
        found.sort_by_key(|(from, ..)| std::cmp::Reverse(*from));
        for (from, to, value) in found {
            text.splice(from..to, value.bytes());
        }
        text
    }
}
