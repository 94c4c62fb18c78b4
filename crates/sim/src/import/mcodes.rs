//! M-codes as firmwares of printers take and print them: `M92 X80 Y80 Z400`.

use super::draft::{Draft, Fate, Quantity, Told};
use super::{not_negative, positive, problem};
use crate::machine::Problem;
use lostmotion_base::AxisId;

/// Codes whose words are a letter with numbers, and nothing else.
pub(super) const NUMERIC: [&str; 8] = [
    "M92", "M203", "M201", "M208", "M350", "M906", "M425", "M669",
];

/// A line with a code.
pub(super) struct MCode {
    pub(super) line: usize,
    /// `M92`.
    pub(super) code: String,
    /// Letter and text behind it.
    pub(super) words: Vec<(char, String)>,
    /// The first word that begins with no letter.
    stray: Option<String>,
}

impl MCode {
    /// The text behind a letter.
    pub(super) fn word(&self, letter: char) -> Option<&str> {
        let mut words = self.words.iter();
        words
            .find(|(own, _)| *own == letter)
            .map(|(_, text)| text.as_str())
    }

    /// `M92 X`.
    pub(super) fn name(&self, letter: char) -> String {
        format!("{} {letter}", self.code)
    }

    /// Reports a code that means nothing here.
    pub(super) fn ignore(&self, draft: &mut Draft, note: &str) {
        let words = self.words.iter();
        let text: Vec<String> = words
            .map(|(letter, text)| format!("{letter}{text}"))
            .collect();
        draft.row(self.code.as_str(), text.join(" "), Fate::Ignored, note);
    }

    /// Refuses what a code of numbers does not have.
    pub(super) fn check(&self) -> Result<(), Problem> {
        match &self.stray {
            Some(word) if NUMERIC.contains(&self.code.as_str()) => Err(problem(
                self.line,
                &self.code,
                format!("`{word}` has no letter"),
                "write a letter before each value, as in M92 X80 Y80",
            )),
            _ => Ok(()),
        }
    }
}

/// Without the prefix that a host puts before a line: `Recv: echo:  M92 X80`.
fn without_host(text: &str) -> &str {
    let text = text.rsplit_once("echo:").map_or(text, |(_, rest)| rest);
    text.trim_start_matches("Recv:")
        .trim_start_matches("Send:")
        .trim()
}

/// What a line says that is neither a code nor a comment.
pub(super) fn other(text: &str) -> Option<&str> {
    let told = without_host(text).split(';').next()?.trim();
    Some(told).filter(|told| !told.is_empty() && !told.starts_with("ok"))
}

/// The code of a line, without a host's prefix and without its comment; `None` if it has none.
///
/// # Errors
/// A line that begins like a code and is none; a quotation that does not end.
pub(super) fn code(line: usize, text: &str) -> Result<Option<MCode>, Problem> {
    let text = without_host(text);
    let mut words = Vec::new();
    let (mut word, mut quoted) = (String::new(), false);
    for c in text.chars() {
        match c {
            '"' => quoted = !quoted,
            ';' if !quoted => break,
            c if c.is_whitespace() && !quoted => words.push(std::mem::take(&mut word)),
            c => word.push(c),
        }
    }
    words.push(word);
    let mut words: Vec<String> = words.into_iter().filter(|word| !word.is_empty()).collect();
    let Some(first) = words.first().map(|word| word.to_ascii_uppercase()) else {
        return Ok(None);
    };
    let number = first.strip_prefix(['M', 'G']).unwrap_or_default();
    if !number.starts_with(|c: char| c.is_ascii_digit()) {
        return Ok(None);
    }
    let bad = |message: String, hint: &str| Err(problem(line, "", message, hint));
    if quoted {
        return bad(
            format!("a quotation does not end: {text}"),
            "was the line cut?",
        );
    }
    let digits = number
        .find(|c: char| !c.is_ascii_digit() && c != '.')
        .unwrap_or(number.len());
    let (code, behind) = first.split_at(1 + digits);
    // Firmwares take words without blanks between them.
    if behind.is_empty() {
        words.remove(0);
    } else if behind.starts_with(|c: char| c.is_ascii_alphabetic()) {
        words[0].drain(..code.len());
    } else {
        return bad(
            format!("`{first}` is no code"),
            "codes are written as M92 X80",
        );
    }
    let mut found = MCode {
        line,
        code: code.to_owned(),
        words: Vec::new(),
        stray: None,
    };
    let is_numeric = NUMERIC.contains(&code);
    for word in words {
        match apart(&word).filter(|_| is_numeric) {
            Some(parts) => found.words.extend(parts),
            None => match word.chars().next() {
                Some(letter) if letter.is_ascii_alphabetic() => {
                    let text = word[letter.len_utf8()..].to_owned();
                    found.words.push((letter.to_ascii_uppercase(), text));
                }
                _ => found.stray = found.stray.or(Some(word)),
            },
        }
    }
    Ok(Some(found))
}

/// The words of `X80Y80:80`; `None` if it is anything else, such as a single word.
fn apart(word: &str) -> Option<Vec<(char, String)>> {
    let is_number = |text: &str| text.split(':').all(|part| part.parse::<f64>().is_ok());
    // `Y1e3` is a number, not an extruder.
    if word.get(1..).is_some_and(is_number) {
        return None;
    }
    let mut parts: Vec<(char, String)> = Vec::new();
    for c in word.chars() {
        match parts.last_mut() {
            _ if c.is_ascii_alphabetic() => parts.push((c.to_ascii_uppercase(), String::new())),
            Some((_, text)) => text.push(c),
            None => return None,
        }
    }
    parts
        .iter()
        .all(|(_, text)| is_number(text))
        .then_some(parts)
}

/// Units of a firmware.
pub(super) struct Firmware {
    /// What M203 is in, of a mm or deg per s.
    pub(super) speed: f64,
    /// Amplitude for what M906 says, A.
    pub(super) peak_a: f64,
}

/// Takes what both firmwares say in the same way; false if it is something else.
pub(super) fn limits(draft: &mut Draft, code: &MCode, units: &Firmware) -> Result<bool, Problem> {
    let (quantity, factor) = match code.code.as_str() {
        "M92" => (Quantity::StepsPerUnit, 1.0),
        "M203" => (Quantity::Velocity, units.speed),
        "M201" => (Quantity::Acceleration, 1.0),
        "M350" => (Quantity::Microsteps, 1.0),
        "M906" => (Quantity::PeakCurrent, units.peak_a),
        "M425" => (Quantity::Gap, 1.0),
        _ => return Ok(false),
    };
    code.check()?;
    if !code
        .words
        .iter()
        .any(|(letter, _)| *letter == 'E' || AxisId::from_letter(*letter).is_some())
    {
        code.ignore(draft, "sets no axis");
    }
    for (letter, text) in &code.words {
        let name = code.name(*letter);
        // E is the extruder; other letters are settings of the code.
        let Some(axis) = AxisId::from_letter(*letter) else {
            if *letter == 'E' {
                draft.row(name, text.as_str(), Fate::Ignored, "the extruder");
            }
            continue;
        };
        let mut amounts = Vec::new();
        for part in text.split(':') {
            amounts.push(match quantity {
                Quantity::Gap => not_negative(code.line, &name, part)?,
                _ => positive(code.line, &name, part)?,
            });
        }
        // Several drivers of an axis usually have the same values.
        let amount = amounts[0];
        if amounts.iter().any(|other| *other != amount) {
            let note = "drivers of one axis differ: the first counts";
            draft.row(name.as_str(), text.as_str(), Fate::Guessed, note);
        }
        let told = Told {
            value: amount * factor,
            from: name,
            line: code.line,
        };
        draft.tell(axis, quantity, told, text);
    }
    Ok(true)
}

/// A problem of a file that names no axis.
pub(super) fn no_axes(draft: &Draft, hint: &str) -> Option<Problem> {
    draft
        .axes
        .is_empty()
        .then(|| problem(1, "", "there is no setting of an axis", hint))
}
