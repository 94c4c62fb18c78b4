//! Lines of a program: what they say, and their words with other values.

use super::RewriteError;
use super::refusals::Refusals;
use lostmotion_gcode::codes::{Group, find};
use lostmotion_gcode::syntax::{
    Block, CORNER_CHAMFER, CORNER_RADIUS, Keyword, Text, Value, Word, line_checksum,
};
use lostmotion_gcode::{Blocks, Code, InterpreterConfig, Units};
use std::borrow::Cow;

/// Letters of the axes that are moved.
pub(super) const LETTERS: [u8; 3] = *b"XYZ";
/// Letters of words that make a way.
const WAYS: &[u8] = b"XYZABCUVWIJKR";
/// Mark in the header of a new program, by which it is known again.
pub(super) const MARK: &str = "rewritten by lostmotion";

/// G codes that a line may have whose end point is moved.
const PLAIN: [f64; 27] = [
    0.0, 1.0, 2.0, 3.0, 17.0, 18.0, 19.0, 20.0, 21.0, 40.0, 43.0, 49.0, 54.0, 55.0, 56.0, 57.0,
    58.0, 59.0, 61.0, 61.1, 64.0, 80.0, 90.0, 91.1, 94.0, 97.0, 98.0,
];

/// G codes under which end points do not say where the tool is, with what they are.
const REFUSED: [(f64, &str); 13] = [
    (7.0, "diameters (G7)"),
    (41.1, "cutter compensation (G41.1)"),
    (42.1, "cutter compensation (G42.1)"),
    (51.1, "a mirror image (G51.1)"),
    (68.2, "a tilted plane (G68.2)"),
    (90.1, "absolute centres (G90.1)"),
    (41.0, "cutter compensation (G41)"),
    (42.0, "cutter compensation (G42)"),
    (16.0, "polar coordinates (G16)"),
    (51.0, "scaling (G51)"),
    (68.0, "rotated coordinates (G68)"),
    (93.0, "inverse time feed (G93)"),
    (18.2, "another control's plane (G18.2)"),
];

/// What makes plain lines of a program that has other ones.
pub(super) const WRITE: &str = "run `lostmotion gcode write` first, which makes plain lines of it";

/// What to do about a code that stays in a program, or stops it, when plain lines are made of it.
fn kept_by_writing(code: f64) -> Option<&'static str> {
    // In tenths, so that all codes of a kind are one range.
    Some(match (10.0 * code).round() as i32 {
        50..=53 => "write splines as short lines",
        330..=331 | 760..=762 => "it goes with the spindle: put it into a program of its own",
        382..=385 => "it ends where the probe touches: put it into a program of its own",
        160 | 510..=511 => "have the moves written as the machine goes them",
        680 | 682 => {
            "`lostmotion gcode write` cannot make plain lines of it either: have the CAM system write the moves in the coordinates of the machine's axes"
        }
        930 => "write feeds a minute (G94)",
        _ => return None,
    })
}

/// Byte order mark.
const BOM: &[u8] = b"\xef\xbb\xbf";

/// The lines of a program.
#[derive(Clone, Debug, Default)]
pub(super) struct TextLines {
    pub(super) all: Vec<Line>,
    /// What stands before the first of them: a byte order mark, or nothing.
    pub(super) mark: &'static [u8],
    /// How many of them nothing may stand before: up to the last of `%` and the number of the program.
    pub(super) head: usize,
}

impl TextLines {
    /// An error of a whole line with the place of what moves on it.
    pub(super) fn placed(&self, error: RewriteError) -> RewriteError {
        let RewriteError::Line {
            line,
            column: None,
            what,
        } = error
        else {
            return error;
        };
        let found = line.checked_sub(1).and_then(|index| self.all.get(index));
        let words = found.map_or(&[][..], |line| &line.block.words);
        let moves = words.iter().find(|word| WAYS.contains(&word.letter));
        let place = moves
            .or(words.first())
            .map(|word| word.text.start as usize + 1);
        RewriteError::Line {
            line,
            column: place,
            what,
        }
    }
}

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

/// Why something is not rewritten, and where on its line it stands; the whole line if `None`.
#[derive(Clone, Debug)]
pub(super) struct Odd {
    place: Option<Text>,
    what: String,
}

impl Odd {
    fn new(place: Text, what: impl Into<String>) -> Odd {
        Odd {
            place: Some(place),
            what: what.into(),
        }
    }

    /// As an error of a line.
    pub(super) fn on(self, line: usize) -> RewriteError {
        RewriteError::Line {
            line,
            column: self.place.map(|place| place.start as usize + 1),
            what: self.what,
        }
    }
}

/// The lines of a program as its dialect has them, with the unit and the feed that are in force. What
/// cannot be read is left to the front end, which knows whether the program comes there.
///
/// # Errors
/// A program that was rewritten before. Lines that switch to what is not rewritten are told in `refusals`.
pub(super) fn lines(
    bytes: &[u8],
    config: &InterpreterConfig,
    refusals: &mut Refusals,
) -> Result<TextLines, RewriteError> {
    let (mark, bytes) = match bytes.strip_prefix(BOM) {
        Some(rest) => (BOM, rest),
        None => (&b""[..], bytes),
    };
    let (mut all, mut modes) = (Vec::new(), InForce::at_start(config.program_units));
    let mut blocks =
        Blocks::new(bytes, config.limits.clone()).accepting(config.dialect, config.leniencies);
    // Reading from memory does not fail.
    while let Ok(Some(parsed)) = blocks.read() {
        let rest = bytes.get(parsed.place.start as usize..).unwrap_or_default();
        let is_end = |byte: &u8| matches!(byte, b'\n' | b'\r');
        let cut = rest.iter().position(is_end).unwrap_or(rest.len());
        let (text, rest) = rest.split_at(cut);
        let end = usize::from(!rest.is_empty()) + usize::from(rest.starts_with(b"\r\n"));
        let mut line = Line {
            text: text.to_vec(),
            end: rest.get(..end).unwrap_or_default().to_vec(),
            mm: 1.0,
            feed: None,
            block: parsed.block.clone(),
        };
        if parsed.fault.is_some() {
            line.block.clear();
        }
        let number = parsed.place.line as usize;
        if let Some(odd) = line.is_of_a_rewritten_program() {
            return Err(odd.on(number));
        }
        if let Err(odd) = modes.take(&line) {
            refusals.add(odd.on(number));
        }
        (line.mm, line.feed) = (modes.mm, modes.feed.clone());
        all.push(line);
    }
    let words = all.iter().position(Line::says_something);
    let start = all.get(..words.unwrap_or(all.len())).unwrap_or_default();
    Ok(TextLines {
        head: start.iter().rposition(Line::is_head).map_or(0, |at| at + 1),
        mark,
        all,
    })
}

/// What is in force while the lines are gone through.
#[derive(Clone, Debug)]
struct InForce {
    mm: f64,
    feed: Option<String>,
    is_relative: bool,
    /// The program may go on elsewhere than on the next line.
    jumps: bool,
    /// It has ended: what follows is none of its lines.
    has_ended: bool,
}

impl InForce {
    fn at_start(units: Units) -> InForce {
        InForce {
            mm: units.mm(),
            feed: None,
            is_relative: false,
            jumps: false,
            has_ended: false,
        }
    }

    /// Goes over a line.
    fn take(&mut self, line: &Line) -> Result<(), Odd> {
        let block = &line.block;
        if self.has_ended {
            return Ok(());
        }
        if let Some(odd) = line.is_decided_on_the_control() {
            self.jumps |= block.flow.is_some();
            return Err(odd);
        }
        for (code, place) in codes(block, b'G') {
            if let Some((_, what)) = REFUSED.iter().find(|(refused, _)| *refused == code) {
                let hint = kept_by_writing(code).unwrap_or(WRITE);
                return Err(Odd::new(
                    place,
                    format!("what is under {what} is not rewritten: {hint}"),
                ));
            }
            if code == 20.0 {
                self.mm = Units::Inch.mm();
            } else if code == 21.0 {
                self.mm = Units::Mm.mm();
            } else if code == 90.0 || code == 91.0 {
                self.is_relative = code == 91.0;
            }
        }
        if let Some(place) = distance(block).filter(|_| self.is_relative) {
            return Err(Odd::new(
                place,
                format!(
                    "distances (G91) are not rewritten, but for a way home like G91 G28 Z0: {WRITE}"
                ),
            ));
        }
        // An expression may have another value where the feed is said again.
        if block.words.iter().any(|word| word.letter == b'F') {
            self.feed = line.value(b'F').and_then(|_| line.word(b'F'));
        }
        self.jumps |= block.flow.is_some() && !line.is_head();
        let ends = |code: f64| code == 2.0 || code == 30.0;
        self.has_ended =
            !self.jumps && !block.deletable && codes(block, b'M').any(|(code, _)| ends(code));
        Ok(())
    }
}

/// The first word by which a line under G91 moves a distance. `G28 Z0` and `G30 Z0` have none: they go to a
/// place of the machine from where the axis stands.
fn distance(block: &Block) -> Option<Text> {
    let goes_home = codes(block, b'G').any(|(code, _)| code == 28.0 || code == 30.0);
    let moves = |word: &&Word| {
        WAYS.contains(&word.letter)
            && !(goes_home && matches!(word.value, Value::Number(value) if value == 0.0))
    };
    block.words.iter().find(moves).map(|word| word.text)
}

pub(super) fn refuse(line: usize, what: impl Into<String>) -> RewriteError {
    RewriteError::Line {
        line,
        column: None,
        what: what.into(),
    }
}

/// The literal codes of a letter on a line, and where they stand.
fn codes(block: &Block, letter: u8) -> impl Iterator<Item = (f64, Text)> {
    block.words.iter().filter_map(move |word| match word.value {
        Value::Number(value) if word.letter == letter => Some((value, word.text)),
        _ => None,
    })
}

impl Line {
    /// The comment, in whichever way it is written.
    fn comment(&self) -> Option<(Text, Cow<'_, str>)> {
        let place = self.block.comment?;
        Some((place, String::from_utf8_lossy(self.piece(place)?)))
    }

    fn piece(&self, place: Text) -> Option<&[u8]> {
        let (from, to) = (place.start as usize, (place.start + place.len) as usize);
        self.text.get(from..to)
    }

    /// Whether it marks a program that was rewritten before.
    fn is_of_a_rewritten_program(&self) -> Option<Odd> {
        let (place, _) = self
            .comment()
            .filter(|(_, comment)| comment.contains(MARK))?;
        Some(Odd::new(
            place,
            "the program has been rewritten already, and would compensate twice: rewrite the original program instead",
        ))
    }

    /// Why only the control knows whether what follows is done, if so: take-ups are those of one way.
    fn is_decided_on_the_control(&self) -> Option<Odd> {
        let block = &self.block;
        let is_open = |value: &Value| !matches!(value, Value::Number(_));
        let asks = match block.flow.as_ref().map(|(_, keyword)| keyword) {
            Some(Keyword::If | Keyword::ElseIf | Keyword::While | Keyword::Then) => true,
            Some(Keyword::Goto) => block.arguments.iter().any(is_open),
            // A count of figures alone is the same everywhere.
            Some(Keyword::Repeat) => {
                let text = self.piece(block.flow_text).unwrap_or_default();
                let count = text.iter().skip_while(|byte| **byte != b'[');
                count
                    .into_iter()
                    .any(|byte| *byte == b'#' || byte.is_ascii_alphabetic())
            }
            _ => false,
        };
        if asks {
            let what = "what the control decides (IF, WHILE, GOTO, a count of REPEAT) may go another way there than here, with other reversals: put each way into a program of its own; `lostmotion gcode write` writes the one that is taken with the values of the program";
            return Some(Odd::new(block.flow_text, what));
        }
        let sets = codes(block, b'G').any(|(code, _)| code != 4.0);
        (block.deletable && (sets || self.has_way())).then(|| self.may_be_skipped())
    }

    /// Why a block with `/` is refused.
    fn may_be_skipped(&self) -> Odd {
        let start = self.text.iter().position(|byte| *byte == b'/');
        let place = start.map(|start| Text {
            start: start as u32,
            len: 1,
        });
        let what = format!(
            "a block that may be skipped (/) is not rewritten: take the / or the block out, or {WRITE}"
        );
        Odd { place, what }
    }

    /// Why its end point cannot be moved, if it cannot.
    pub(super) fn is_not_plain(&self) -> Option<Odd> {
        let block = &self.block;
        if block.flow.is_some() {
            let what = format!("a line of control flow is not rewritten: {WRITE}");
            return Some(Odd::new(block.flow_text, what));
        }
        if let Some(setting) = block.settings.first() {
            let what = "a move beside a setting of a parameter is not rewritten: put the setting on a line of its own";
            return Some(Odd::new(setting.text, what));
        }
        if block.deletable {
            return Some(self.may_be_skipped());
        }
        let is_expression = |word: &&Word| !matches!(word.value, Value::Number(_));
        if let Some(word) = block.words.iter().find(is_expression) {
            let letter = char::from(word.letter);
            let what = format!(
                "{letter} is an expression, and stays as it is: write its number, or {WRITE}"
            );
            return Some(Odd::new(word.text, what));
        }
        let is_corner = |word: &&Word| matches!(word.letter, CORNER_RADIUS | CORNER_CHAMFER);
        if let Some(word) = block.words.iter().find(is_corner) {
            let what = format!("a corner with ,R or ,C is not rewritten: {WRITE}");
            return Some(Odd::new(word.text, what));
        }
        let odd = codes(block, b'G').find(|(code, _)| !PLAIN.contains(code));
        let Some((code, place)) = odd else {
            let what = "what moves without a word of an axis is not rewritten";
            return (!self.has_way()).then(|| Odd {
                place: None,
                what: what.to_owned(),
            });
        };
        let row = find(Code::g((10.0 * code).round() as u16));
        let moves = row.is_none_or(|row| row.group == Group::Motion || row.leniency.is_some());
        let hint = if moves {
            kept_by_writing(code).unwrap_or(WRITE)
        } else {
            "put the move on a line of its own"
        };
        Some(Odd::new(place, format!("G{code} is not rewritten: {hint}")))
    }

    /// The value of a word as a number, in the line's unit.
    pub(super) fn value(&self, letter: u8) -> Option<f64> {
        codes(&self.block, letter).next().map(|(value, _)| value)
    }

    /// A word as it stands.
    fn word(&self, letter: u8) -> Option<String> {
        let word = self.block.words.iter().find(|word| word.letter == letter)?;
        Some(String::from_utf8_lossy(self.piece(word.text)?).into_owned())
    }

    /// Whether it has a word of an axis, or of an arc.
    pub(super) fn has_way(&self) -> bool {
        let mut words = self.block.words.iter();
        words.any(|word| WAYS.contains(&word.letter))
    }

    /// Whether it goes to a home of the machine.
    pub(super) fn goes_home(&self) -> bool {
        codes(&self.block, b'G').any(|(code, _)| code == 28.0 || code == 30.0)
    }

    /// Whether it sends an axis somewhere: its home has all axes that it names, or all.
    pub(super) fn sends(&self, axis: usize) -> bool {
        let words = &self.block.words;
        let names = |letter: u8| words.iter().any(|word| word.letter == letter);
        names(LETTERS[axis]) || self.goes_home() && !b"XYZABCUVW".iter().any(|axis| names(*axis))
    }

    /// Whether it changes the tool.
    pub(super) fn changes_the_tool(&self) -> bool {
        codes(&self.block, b'M').any(|(code, _)| code == 6.0)
    }

    /// Whether it says which motion it makes.
    pub(super) fn has_motion(&self) -> bool {
        codes(&self.block, b'G').any(|(code, _)| code <= 3.0)
    }

    /// What it takes from where X, Y and Z stand, if anything: an offset or a place that is kept.
    pub(super) fn takes_the_place(&self) -> Option<Odd> {
        let has_axis = [b'X', b'Y', b'Z']
            .into_iter()
            .any(|letter| self.block.words.iter().any(|word| word.letter == letter));
        let level = self.value(b'L');
        codes(&self.block, b'G').find_map(|(code, place)| {
            let code = match code {
                92.0 if has_axis => "G92",
                10.0 if has_axis && level == Some(20.0) => "G10 L20",
                10.0 if has_axis && level == Some(10.0) => "G10 L10",
                10.0 if has_axis && level == Some(11.0) => "G10 L11",
                28.1 => "G28.1",
                30.1 => "G30.1",
                _ => return None,
            };
            // Offsets of plain lines are in their end points; places of the machine are kept as they are.
            let more = if code.ends_with(".1") {
                String::new()
            } else {
                format!(", or {WRITE}")
            };
            Some(Odd::new(place, format!(
                "{code} takes where the axes stand, which is half a gap aside in a rewritten program: put it before the first move{more}"
            )))
        })
    }

    /// What to do about a word for which its move has to stay one, if it has such a word.
    pub(super) fn keeps_its_move_whole(&self) -> Option<Odd> {
        let stops = [0.0, 1.0, 2.0, 5.0, 9.0, 30.0, 60.0];
        let odd = |place, hint: &str| {
            let what = format!("the arc has to be cut at its reversals: {hint}");
            Some(Odd::new(place, what))
        };
        let mut codes_m = codes(&self.block, b'M');
        if let Some((_, place)) = codes_m.find(|(code, _)| stops.contains(code)) {
            return odd(place, "put the M code on a line of its own");
        }
        let (_, place) = codes(&self.block, b'E').next()?;
        let hint = "what an arc extrudes (E) is not shared out: have the slicer write lines";
        odd(place, hint)
    }

    /// Whether it is `%` or the number of the program, before which nothing may stand.
    fn is_head(&self) -> bool {
        self.block.percent || matches!(self.block.flow, Some((_, Keyword::Bare)))
    }

    /// Whether it is more than a comment or of the head.
    fn says_something(&self) -> bool {
        let block = &self.block;
        !(block.words.is_empty() && block.settings.is_empty())
            || block.flow.is_some() && !self.is_head()
    }

    /// The line with these words: those that it has get the values, or go where there is none; the others are put
    /// behind its last word, its motion before the first.
    pub(super) fn with(&self, words: &[(u8, String)]) -> Vec<u8> {
        let of = &self.block.words;
        let (mut motion, mut missing) = (String::new(), String::new());
        let mut changes: Vec<(usize, usize, &str)> = Vec::new();
        for (letter, value) in words {
            match of.iter().find(|word| word.letter == *letter) {
                // Printers have their code first.
                _ if *letter == b'G' => motion = format!("G{value} "),
                // Without a value the word goes, and the blank before it.
                Some(word) if value.is_empty() => {
                    let start = word.text.start as usize;
                    let end = start + word.text.len as usize;
                    let blank = start > 0 && self.text.get(start - 1) == Some(&b' ');
                    changes.push((start - usize::from(blank), end, ""));
                }
                // Behind the letter.
                Some(word) => {
                    let start = word.text.start as usize;
                    changes.push((start + 1, start + word.text.len as usize, value));
                }
                None => missing.push_str(&format!(" {}{value}", char::from(*letter))),
            }
        }
        let ends = of
            .iter()
            .map(|word| (word.text.start + word.text.len) as usize);
        let behind = ends.max().unwrap_or(self.text.len());
        let before = of.iter().map(|word| word.text.start as usize).min();
        let before = before.unwrap_or(behind);
        changes.push((behind, behind, &missing));
        changes.push((before, before, &motion));
        // From the end on, so that places before stay right.
        changes.sort_by_key(|(from, ..)| std::cmp::Reverse(*from));
        let mut text = self.text.clone();
        for (from, to, value) in &changes {
            text.splice(*from..*to, value.bytes());
        }
        if let Some(place) = self.block.checksum {
            // All changes stand before it.
            let start = (place.start as usize + text.len()).saturating_sub(self.text.len());
            let sum = line_checksum(text.get(..start).unwrap_or_default());
            let stretch = start..(start + place.len as usize).min(text.len());
            text.splice(stretch, format!("*{sum}").bytes());
        }
        text
    }
}
