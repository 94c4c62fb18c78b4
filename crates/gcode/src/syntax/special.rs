//! Lines that RS274/NGC does not have: Macro B of Fanuc, and what printers read. Looked at only
//! when a line is a fault otherwise.

use super::block::{Block, Fault, Keyword, Label, Parsed, Setting, Text, Value, Word, fail};
use super::expression::{PostfixCode, bare_value, bracket_value, expected, target, word_value};
use super::number::skip;
use super::parse;
use super::parse::{flow_line, head, taken, word};
use crate::dialect::{Leniencies, Leniency};
use crate::limits::Limits;
use crate::problem::Problem;
use nom::Err;

/// What stands for `,R` and `,C` among the letters of words.
pub const CORNER_RADIUS: u8 = b'r';
/// See [`CORNER_RADIUS`].
pub const CORNER_CHAMFER: u8 = b'c';

/// Parses a line with the given leniencies, and says which of them it took.
///
/// # Errors
/// The first fault of the line.
pub(crate) fn parse_special(
    line: &[u8],
    block: &mut Block,
    limits: &Limits,
    accepted: Leniencies,
) -> Result<Vec<Leniency>, Fault> {
    block.clear();
    let mut taken = Vec::new();
    // The checksum comes off first: it covers everything before its `*`.
    let mut words = line;
    if accepted.has(Leniency::Checksums)
        && let Some(place) = checksum(line)?
    {
        words = line.get(..place.start as usize).unwrap_or_default();
        block.checksum = Some(place);
        taken.push(Leniency::Checksums);
    }
    let mut reader = Reader {
        line: words,
        limits,
        accepted,
        taken,
    };
    match reader.items(block) {
        Ok(_) => Ok(reader.taken),
        Err(Err::Error(fault) | Err::Failure(fault)) => Err(fault),
        Err(Err::Incomplete(_)) => Err(Fault {
            rest: 0,
            problem: Box::new(Problem::Expected { expected: "more" }),
        }),
    }
}

/// The checksum of a line of RepRap's, from the bytes before its `*`.
///
/// ```
/// assert_eq!(lostmotion_gcode::syntax::line_checksum(b"N3 T0"), 57);
/// ```
pub fn line_checksum(before: &[u8]) -> u8 {
    before.iter().fold(0, |sum, byte| sum ^ byte)
}

/// Where the checksum of a line stands, if it has one.
fn checksum(line: &[u8]) -> Result<Option<Text>, Fault> {
    // A `*` in a comment or in an expression is none: only digits may follow it.
    let comment = line
        .iter()
        .position(|byte| matches!(byte, b'(' | b';'))
        .unwrap_or(line.len());
    let Some(at) = line.iter().take(comment).rposition(|byte| *byte == b'*') else {
        return Ok(None);
    };
    let (before, after) = (
        line.get(..at).unwrap_or_default(),
        line.get(at + 1..comment).unwrap_or_default(),
    );
    let digits = std::str::from_utf8(after)
        .ok()
        .and_then(|text| text.trim().parse::<u8>().ok());
    let Some(found) = digits else {
        return Ok(None);
    };
    let wanted = line_checksum(before);
    if found == wanted {
        return Ok(Some(Text {
            start: at as u32,
            len: 1 + after.trim_ascii_end().len() as u32,
        }));
    }
    Err(Fault {
        rest: line.len() - at,
        problem: Box::new(Problem::Checksum { found, wanted }),
    })
}

struct Reader<'a> {
    line: &'a [u8],
    limits: &'a Limits,
    accepted: Leniencies,
    taken: Vec<Leniency>,
}

impl<'a> Reader<'a> {
    fn take(&mut self, leniency: Leniency) -> bool {
        let accepted = self.accepted.has(leniency);
        if accepted && !self.taken.contains(&leniency) {
            self.taken.push(leniency);
        }
        accepted
    }

    fn items(&mut self, block: &mut Block) -> Parsed<'a, ()> {
        let (mut rest, ()) = head(self.line, block, self.limits)?;
        rest = self.skip_number(rest, block)?.0;
        // A colon is the O of program numbers in ISO code.
        if let [b':', after @ ..] = skip(rest)
            && self.take(Leniency::ColonNumbers)
        {
            let (after, ()) =
                flow_line(after, self.line.len(), block, self.limits.expression_depth)?;
            return self.flow_end(after);
        }
        // Control flow and text commands take the whole line; otherwise it is a list of items.
        if let Some(result) = self.flow(skip(rest), block) {
            return result;
        }
        if let Some(result) = self.text(skip(rest), block) {
            return result;
        }
        loop {
            rest = skip(rest);
            let Some(&first) = rest.first() else {
                return Ok((rest, ()));
            };
            let at = self.line.len() - rest.len();
            rest = match first {
                b'(' => parse::parenthesis(rest)?.0,
                b';' => parse::semicolon(rest)?.0,
                b'#' => self.setting(rest, at, block)?.0,
                b',' => self.corner(rest, at, block)?.0,
                _ => self.word(rest, at, block)?.0,
            };
            if block.words.len() + block.settings.len() > self.limits.words {
                return fail(
                    rest,
                    Problem::TooManyWords {
                        limit: self.limits.words,
                    },
                );
            }
        }
    }

    /// `/2`: which switch skips the line. N may follow it.
    fn skip_number(&mut self, rest: &'a [u8], block: &mut Block) -> Parsed<'a, ()> {
        let [digit @ b'1'..=b'9', after @ ..] = skip(rest) else {
            return Ok((rest, ()));
        };
        let is_number = block.deletable && block.line_number.is_none();
        if !is_number || !self.take(Leniency::NumberedSkip) {
            return Ok((rest, ()));
        }
        block.skip_number = digit - b'0';
        match skip(after) {
            [b'N' | b'n', ..] => head(skip(after), block, self.limits),
            _ => Ok((after, ())),
        }
    }

    /// A word; in printers' programs its number may be missing.
    fn word(&mut self, rest: &'a [u8], at: usize, block: &mut Block) -> Parsed<'a, ()> {
        // As usual first; only where that fails does a bare letter count.
        let parsed = word(rest, at, block, self.limits);
        let [letter, after @ ..] = rest else {
            return parsed;
        };
        let alone = letter.is_ascii_alphabetic()
            && !matches!(
                letter.to_ascii_uppercase(),
                b'G' | b'M' | b'N' | b'O' | b'T'
            );
        if parsed.is_err()
            && alone
            && after
                .first()
                .is_none_or(|byte| matches!(byte, b' ' | b'\t' | b';'))
            && self.take(Leniency::BareLetters)
        {
            let text = Text {
                start: at as u32,
                len: 1,
            };
            block.words.push(Word {
                letter: letter.to_ascii_uppercase(),
                value: Value::Number(0.0),
                text,
            });
            return Ok((after, ()));
        }
        parsed
    }

    /// `#5 = expression`, the expression with or without brackets.
    fn setting(&mut self, input: &'a [u8], at: usize, block: &mut Block) -> Parsed<'a, ()> {
        let mut code = PostfixCode::of(block, self.limits.expression_depth);
        let (rest, target) = target(input, &mut code)?;
        let (rest, value) = if self.accepted.has(Leniency::BareArithmetic) {
            let (rest, (value, bare)) = bare_value(rest, &mut code)?;
            if bare {
                self.take(Leniency::BareArithmetic);
            }
            (rest, value)
        } else {
            word_value(rest, &mut code)?
        };
        let text = taken(at, input, rest);
        block.settings.push(Setting {
            target,
            value,
            text,
        });
        Ok((rest, ()))
    }

    /// `,R` and `,C`.
    fn corner(&mut self, input: &'a [u8], at: usize, block: &mut Block) -> Parsed<'a, ()> {
        let after = skip(input.get(1..).unwrap_or_default());
        let letter = match after.first().map(u8::to_ascii_uppercase) {
            Some(b'R') => CORNER_RADIUS,
            Some(b'C') => CORNER_CHAMFER,
            _ => return fail(input, Problem::BadCharacter { byte: b',' }),
        };
        if !self.take(Leniency::CornerWords) {
            return fail(input, Problem::BadCharacter { byte: b',' });
        }
        let mut code = PostfixCode::of(block, self.limits.expression_depth);
        let (rest, value) = word_value(after.get(1..).unwrap_or_default(), &mut code)?;
        let text = taken(at, input, rest);
        block.words.push(Word {
            letter,
            value,
            text,
        });
        Ok((rest, ()))
    }

    /// Control flow of Macro B.
    fn flow(&mut self, input: &'a [u8], block: &mut Block) -> Option<Parsed<'a, ()>> {
        if !self.accepted.has(Leniency::MacroFlow) {
            return None;
        }
        let (keyword, rest) = [
            (&b"while"[..], Keyword::While),
            (b"goto", Keyword::Goto),
            (b"end", Keyword::EndWhile),
            (b"do", Keyword::Do),
            (b"if", Keyword::If),
        ]
        .into_iter()
        .find_map(|(text, keyword)| starts_with(input, text).map(|rest| (keyword, rest)))?;
        // Without a bracket it is no condition, but perhaps a name of another dialect.
        if matches!(keyword, Keyword::While | Keyword::If) && skip(rest).first() != Some(&b'[') {
            return None;
        }
        self.take(Leniency::MacroFlow);
        Some(self.flow_rest(keyword, rest, block))
    }

    fn flow_rest(&mut self, keyword: Keyword, rest: &'a [u8], block: &mut Block) -> Parsed<'a, ()> {
        let mut rest = rest;
        if matches!(keyword, Keyword::While | Keyword::If) {
            let mut code = PostfixCode::of(block, self.limits.expression_depth);
            let (after, condition) = bracket_value(rest, &mut code)?;
            block.arguments.push(condition);
            rest = skip(after);
        }
        let keyword = match keyword {
            Keyword::While => match starts_with(rest, b"do") {
                Some(after) => (Keyword::While, after),
                None => return expected(rest, "DO and its number"),
            },
            Keyword::If => match (starts_with(rest, b"goto"), starts_with(rest, b"then")) {
                (Some(after), _) => (Keyword::Goto, after),
                (_, Some(after)) => (Keyword::Then, after),
                _ => return expected(rest, "GOTO or THEN"),
            },
            // DO without WHILE is a loop whose condition always holds.
            Keyword::Do => {
                block.arguments.push(Value::Number(1.0));
                (Keyword::While, rest)
            }
            other => (other, rest),
        };
        let (keyword, rest) = keyword;
        // IF [..] THEN has a setting in place of a label.
        if keyword == Keyword::Then {
            block.flow = Some((Label::Number(Value::Number(0.0)), keyword));
            let at = self.line.len() - skip(rest).len();
            let (rest, ()) = self.setting(skip(rest), at, block)?;
            return self.flow_end(rest);
        }
        let (rest, label) = word_value(
            rest,
            &mut PostfixCode::of(block, self.limits.expression_depth),
        )?;
        block.flow = Some((Label::Number(label), keyword));
        self.flow_end(rest)
    }

    fn flow_end(&self, rest: &'a [u8]) -> Parsed<'a, ()> {
        match skip(rest).first() {
            None | Some(b'(' | b';') => Ok((&[], ())),
            Some(&byte) => fail(skip(rest), Problem::BadCharacter { byte }),
        }
    }

    /// Commands with text: `M117 Hello`, and names of more than one letter as Klipper has them.
    fn text(&mut self, input: &'a [u8], block: &mut Block) -> Option<Parsed<'a, ()>> {
        if !self.accepted.has(Leniency::StringCommands) {
            return None;
        }
        let is_name = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
        let letters = input
            .iter()
            .take_while(|byte| byte.is_ascii_alphabetic() || **byte == b'_')
            .count();
        let name = input.iter().take_while(|byte| is_name(byte)).count();
        // Two letters or more before a blank or `=` are a command with a name, not words.
        let is_extended =
            letters >= 2 && matches!(input.get(name), None | Some(b' ' | b'\t' | b';' | b'='));
        let is_text = matches!(input, [b'M' | b'm', b'0'..=b'9', ..]);
        if !(is_extended || is_text) {
            return None;
        }
        // What changes coordinates is carried out, not skipped.
        let command = std::str::from_utf8(input).ok().and_then(command_name);
        if command.is_some_and(|(name, _)| STATE_COMMANDS.contains(&name.as_str()))
            && self.take(Leniency::GcodeStates)
        {
            block.words.clear();
            return Some(Ok((&[], ())));
        }
        self.take(Leniency::StringCommands);
        block.words.clear();
        Some(Ok((&[], ())))
    }
}

/// Commands of Klipper about states and coordinates.
pub(crate) const STATE_COMMANDS: [&str; 3] = [
    "SAVE_GCODE_STATE",
    "RESTORE_GCODE_STATE",
    "SET_GCODE_OFFSET",
];

/// The name of a command in upper case, and what follows it.
pub(crate) fn command_name(line: &str) -> Option<(String, &str)> {
    let line = line.trim_start();
    let length = line
        .bytes()
        .take_while(|byte| byte.is_ascii_alphanumeric() || *byte == b'_')
        .count();
    let (name, rest) = line.split_at_checked(length)?;
    (length >= 2).then(|| (name.to_ascii_uppercase(), rest))
}

/// The rest after a keyword, in any case.
fn starts_with<'a>(input: &'a [u8], text: &[u8]) -> Option<&'a [u8]> {
    let head = input.get(..text.len())?;
    if head.eq_ignore_ascii_case(text) {
        input.get(text.len()..)
    } else {
        None
    }
}

/// What a line has that only Sinumerik controls know; `None` if it has nothing of the kind.
pub(crate) fn siemens_word(line: &[u8]) -> Option<&'static str> {
    const WORDS: [&str; 27] = [
        "TRANS", "ATRANS", "ROT", "AROT", "SCALE", "ASCALE", "MIRROR", "AMIRROR", "CYCLE",
        "POCKET", "SLOT", "HOLES", "LONGHOLE", "MCALL", "EXTCALL", "MSG", "DEF", "PROC", "TRAORI",
        "TRAFOOF", "ORIWKS", "SUPA", "CIP", "GOTOF", "GOTOB", "STOPRE", "COMPON",
    ];
    let text = line.trim_ascii();
    // An N number may stand before the name.
    let text = match text {
        [b'N' | b'n', rest @ ..] => rest.trim_ascii_start().trim_start_digits(),
        _ => text,
    };
    let letters = text
        .iter()
        .take_while(|byte| byte.is_ascii_alphabetic())
        .count();
    let name = text.get(..letters).unwrap_or_default();
    let matches = |word: &&&str| name.eq_ignore_ascii_case(word.as_bytes());
    if let Some(word) = WORDS.iter().find(matches) {
        return Some(word);
    }
    // `X=10` is an address with `=`, which RS274/NGC writes without; parameters are set with `#`.
    let comment = text
        .iter()
        .position(|byte| *byte == b';')
        .unwrap_or(text.len());
    let code = text.get(..comment).unwrap_or_default();
    let address = |pair: &[u8]| matches!(pair, [b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9', b'=']);
    let is_parameter = code.contains(&b'#') || code.first() == Some(&b'(');
    if !is_parameter && code.windows(2).any(address) {
        Some("an address with =")
    } else {
        None
    }
}

/// Whether a line is of Heidenhain's conversational language: its number without N, then what every
/// such program begins with.
pub(crate) fn is_heidenhain(line: &[u8]) -> bool {
    let text = line.trim_ascii().trim_start_digits();
    text.len() < line.trim_ascii().len()
        && [&b"BEGIN PGM"[..], b"TOOL CALL", b"BLK FORM"]
            .iter()
            .any(|word| text.starts_with(word))
}

trait Digits {
    fn trim_start_digits(&self) -> &[u8];
}

impl Digits for [u8] {
    fn trim_start_digits(&self) -> &[u8] {
        let digits = self.iter().take_while(|byte| byte.is_ascii_digit()).count();
        self.get(digits..).unwrap_or_default().trim_ascii_start()
    }
}
