//! M-codes as firmwares of printers take and print them: `M92 X80 Y80 Z400`.

use super::draft::{Draft, Fate, Quantity, Told};
use super::{not_negative, positive, problem};
use crate::machine::Problem;
use lostmotion_base::AxisId;

/// A line with a code.
pub(super) struct MCode {
    pub(super) line: usize,
    /// `M92`.
    pub(super) code: String,
    /// Letter and text behind it.
    pub(super) words: Vec<(char, String)>,
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
}

/// The code of a line, without a host's prefix and without its comment; `None` if it has none.
pub(super) fn code(line: usize, text: &str) -> Option<MCode> {
    // Hosts write `Recv: echo:  M92 X80`.
    let text = text.rsplit_once("echo:").map_or(text, |(_, rest)| rest);
    let text = text.trim_start_matches("Recv:").trim_start_matches("Send:");
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
    let mut words = words.into_iter().filter(|word| !word.is_empty());
    let code = words.next()?.to_ascii_uppercase();
    let digits = code.strip_prefix(['M', 'G'])?;
    if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit() || b == b'.') {
        return None;
    }
    let words = words.filter_map(|word| {
        let letter = word.chars().next()?.to_ascii_uppercase();
        letter
            .is_ascii_alphabetic()
            .then(|| (letter, word[letter.len_utf8()..].to_owned()))
    });
    let words = words.collect();
    Some(MCode { line, code, words })
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
    for (letter, text) in &code.words {
        let name = code.name(*letter);
        // E is the extruder; other letters are settings of the code.
        let Some(axis) = AxisId::from_letter(*letter) else {
            if *letter == 'E' {
                draft.row(name, text.as_str(), Fate::Ignored, "the extruder");
            }
            continue;
        };
        // Several drivers of an axis have the same values.
        let first = text.split(':').next().unwrap_or_default();
        let amount = match quantity {
            Quantity::Gap => not_negative(code.line, &name, first)?,
            _ => positive(code.line, &name, first)?,
        };
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
