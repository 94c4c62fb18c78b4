//! Headers of C as Marlin is configured by: the defines that count, and those whose condition is not
//! met or cannot be told.
//!
//! Conditions are those of C and the macros of Marlin's `src/core/macros.h`: ENABLED, DISABLED, ANY,
//! EITHER, ALL, BOTH and NONE. What the headers define is known; names that Marlin makes up from them
//! and from the board (`HAS_...`) are not, but for those about drivers of Trinamic.

use super::expression::{self, Names, Number, Untold, Worth};
use super::problem;
use crate::machine::Problem;
use lostmotion_base::AxisId;
use std::cell::Cell;
use std::collections::BTreeMap;

/// Deepest chain of names that stand for names.
const DEEPEST: usize = 16;

/// Most conditions within each other. A choice: Marlin's own headers have some six.
const MOST_NESTED: usize = 64;

/// Most names that are looked up for all conditions and values. A choice: Marlin's own headers need
/// some ten thousand, and names that stand for twice themselves would go on for ever.
const MOST_LOOKUPS: usize = 1_000_000;

/// Longest text that a name stands for within an expression, bytes. A choice: longer ones are lists and
/// texts.
const LONGEST: usize = 256;

/// What damage like this may come from.
const CUT: &str = "is a part of the file missing?";

/// What may stand behind the hash of a header's line.
const DIRECTIVES: [&str; 13] = [
    "define", "undef", "if", "ifdef", "ifndef", "elif", "else", "endif", "include", "error",
    "warning", "pragma", "line",
];

/// A line `#define NAME VALUE` that is no comment.
pub(super) struct Define {
    /// Its line in the file that is imported.
    pub(super) line: usize,
    pub(super) name: String,
    pub(super) value: String,
    /// Of a further file, where it stands there.
    place: Option<String>,
    /// Why it does not count; `None` if it does.
    pub(super) left_out: Option<String>,
}

impl Define {
    /// Its name, and where it stands in a further file.
    pub(super) fn key(&self) -> String {
        self.placed(&self.name)
    }

    /// Its name with an axis, and where it stands in a further file.
    pub(super) fn key_of(&self, axis: AxisId) -> String {
        self.placed(&format!("{} {axis}", self.name))
    }

    fn placed(&self, name: &str) -> String {
        match &self.place {
            Some(place) => format!("{name} ({place})"),
            None => name.to_owned(),
        }
    }
}

/// A condition that has not ended.
struct Branch {
    line: usize,
    text: String,
    /// Whether this branch is read; `None` where that cannot be told.
    is_met: Option<bool>,
    /// Whether this one or one before it is.
    was_met: Option<bool>,
    has_else: bool,
}

/// The defines of one or more headers, in their order.
#[derive(Default)]
pub(super) struct Header {
    pub(super) defines: Vec<Define>,
    /// What names stand for; `None` where a condition that cannot be told decides it.
    values: BTreeMap<String, Option<String>>,
    /// The last define of a name, in `defines`.
    last: BTreeMap<String, usize>,
    lookups: Cell<usize>,
}

impl Header {
    /// Reads a header behind those that were read; `file` is the name of one that is not imported by
    /// itself.
    ///
    /// # Errors
    /// Directives that are none, and comments and conditions that do not end: of a header that was cut.
    pub(super) fn read(&mut self, text: &str, file: Option<&str>) -> Result<(), Vec<Problem>> {
        let (lines, open) = lines(text);
        let mut reader = HeaderReader {
            header: self,
            file,
            branches: Vec::new(),
            problems: Vec::new(),
        };
        for (line, told) in &lines {
            if let Some(rest) = told.trim().strip_prefix('#') {
                reader.directive(*line, rest.trim_start());
            }
            if reader.branches.len() > MOST_NESTED {
                let message = format!("conditions nest more than {MOST_NESTED} deep");
                reader.fail(*line, "#if", &message, "");
                return Err(reader.problems);
            }
        }
        let condition = reader.branches.last().map(|branch| branch.line);
        for (open, what) in [(condition, "#if"), (open, "/*")] {
            if let Some(line) = open {
                reader.fail(line, what, "does not end", CUT);
            }
        }
        if reader.problems.is_empty() {
            Ok(())
        } else {
            Err(reader.problems)
        }
    }

    /// Whether a switch is on: defined, as nothing, 1 or true.
    pub(super) fn is_on(&self, name: &str) -> Option<bool> {
        self.enabled(name).ok()
    }

    /// Whether a header says anything of a name, be it under a condition that cannot be told.
    pub(super) fn is_told(&self, name: &str) -> bool {
        self.values.contains_key(name)
    }

    /// The number that a text is.
    ///
    /// # Errors
    /// What is not known, and what is no expression.
    pub(super) fn number(&self, text: &str) -> Result<f64, Untold> {
        expression::number(text, self, 0).map(|it| it.value)
    }

    fn enabled(&self, name: &str) -> Result<bool, Untold> {
        let mut name = name;
        for _ in 0..DEEPEST {
            name = match self.values.get(name) {
                Some(Some(value)) => match value.as_str() {
                    "" | "1" | "true" => return Ok(true),
                    value => value,
                },
                Some(None) => return Err(Untold::Unknown(name.to_owned())),
                None if is_made_up(name) => return Err(Untold::Unknown(name.to_owned())),
                None => break,
            };
        }
        Ok(false)
    }

    fn defined(&self, name: &str) -> Result<bool, Untold> {
        match self.values.get(name) {
            Some(Some(_)) => Ok(true),
            None if !is_made_up(name) => Ok(false),
            _ => Err(Untold::Unknown(name.to_owned())),
        }
    }

    /// Whether a driver of Trinamic that the firmware sets up moves one of these motors.
    fn has_trinamic(&self, motors: &[&str]) -> Result<bool, Untold> {
        let mut found = Err(Untold::Unknown(format!(
            "{}_DRIVER_TYPE",
            motors.join(", ")
        )));
        for motor in motors {
            match self.values.get(&format!("{motor}_DRIVER_TYPE")) {
                Some(Some(kind)) => {
                    let is_fixed = kind == "TMC2100" || kind.ends_with("_STANDALONE");
                    if kind.starts_with("TMC") && !is_fixed {
                        return Ok(true);
                    }
                    found = Ok(false);
                }
                Some(None) => return Err(Untold::Unknown(format!("{motor}_DRIVER_TYPE"))),
                None => {}
            }
        }
        found
    }
}

/// Motors of Marlin.
const MOTORS: [&str; 21] = [
    "X", "Y", "Z", "I", "J", "K", "U", "V", "W", "X2", "Y2", "Z2", "Z3", "Z4", "E0", "E1", "E2",
    "E3", "E4", "E5", "E6",
];

/// Longest condition that is shown, characters. A choice: a line of a report.
const MOST_SHOWN: usize = 60;

/// A condition as it is shown.
fn shown(text: &str) -> String {
    match text.char_indices().nth(MOST_SHOWN) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

/// Whether Marlin makes a name up from others, so that the headers do not tell it.
fn is_made_up(name: &str) -> bool {
    ["HAS_", "IS_", "USE_", "USES_", "NEED_", "NEEDS_", "__"]
        .iter()
        .any(|begin| name.starts_with(begin))
}

fn truth(is_true: bool) -> Number {
    Number {
        value: f64::from(u8::from(is_true)),
        is_whole: true,
    }
}

impl Names for Header {
    fn name(&self, name: &str, depth: usize) -> Worth {
        self.lookups.set(self.lookups.get() + 1);
        let unknown = || Untold::Unknown(name.to_owned());
        if self.lookups.get() > MOST_LOOKUPS {
            return Err(unknown());
        }
        match (name, self.values.get(name)) {
            ("true", None) => Ok(truth(true)),
            ("false", None) => Ok(truth(false)),
            ("HAS_TRINAMIC_CONFIG" | "HAS_TRINAMIC_DRIVER", None) => {
                self.has_trinamic(&MOTORS).map(truth)
            }
            (_, Some(None)) => Err(unknown()),
            (_, Some(Some(value)))
                if !value.is_empty() && value.len() <= LONGEST && depth < DEEPEST =>
            {
                // A name behind the last one is what is no number.
                expression::number(value, self, depth + 1)
            }
            _ => Err(unknown()),
        }
    }

    fn function(&self, name: &str, words: &[&str]) -> Worth {
        let unknown = Untold::Unknown(format!("{name}({})", words.join(", ")));
        let is_name = |word: &&str| word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
        if words.is_empty() || !words.iter().all(is_name) {
            return Err(unknown);
        }
        // One that decides goes before those that cannot be told.
        let any = |wanted: bool| -> Result<bool, Untold> {
            let mut found = Ok(false);
            for word in words {
                match self.enabled(word) {
                    Ok(is_on) if is_on == wanted => return Ok(true),
                    Ok(_) => {}
                    Err(why) => found = Err(why),
                }
            }
            found
        };
        let found = match name {
            "defined" => self.defined(words[0]),
            "ENABLED" | "ALL" | "BOTH" => any(false).map(|is_one_off| !is_one_off),
            "ANY" | "EITHER" => any(true),
            "DISABLED" | "NONE" => any(true).map(|is_one_on| !is_one_on),
            "AXIS_IS_TMC" | "AXIS_IS_TMC_CONFIG" => self.has_trinamic(&words[..1]),
            _ => Err(unknown),
        };
        found.map(truth)
    }
}

/// The lines of a header without comments, those that a backslash joins as one, and the line of a
/// comment that does not end.
fn lines(text: &str) -> (Vec<(usize, String)>, Option<usize>) {
    let mut found: Vec<(usize, String)> = Vec::new();
    let (mut comment, mut goes_on) = (None, false);
    for (index, line) in text.lines().enumerate() {
        let number = index + 1;
        let (mut rest, mut told) = (line, String::new());
        loop {
            if comment.is_some() {
                let Some((_, behind)) = rest.split_once("*/") else {
                    break;
                };
                (comment, rest) = (None, behind);
                told.push(' ');
            }
            let (one, more) = (rest.find("//"), rest.find("/*"));
            match more {
                Some(at) if one.is_none_or(|one| at < one) => {
                    told.push_str(&rest[..at]);
                    (comment, rest) = (Some(number), &rest[at + 2..]);
                }
                _ => {
                    told.push_str(&rest[..one.unwrap_or(rest.len())]);
                    break;
                }
            }
        }
        let whole = told.trim_end();
        let (own, joins) = match whole.strip_suffix('\\') {
            Some(own) => (own, true),
            None => (whole, false),
        };
        match found.last_mut().filter(|_| goes_on) {
            Some((_, before)) => {
                before.push(' ');
                before.push_str(own);
            }
            None => found.push((number, own.to_owned())),
        }
        goes_on = joins;
    }
    (found, comment)
}

/// A header as it is read.
struct HeaderReader<'a> {
    header: &'a mut Header,
    file: Option<&'a str>,
    branches: Vec<Branch>,
    problems: Vec<Problem>,
}

impl HeaderReader<'_> {
    fn fail(&mut self, line: usize, key: &str, message: &str, hint: &str) {
        self.problems.push(match self.file {
            Some(file) => problem(1, key, format!("{message} (line {line} of {file})"), hint),
            None => problem(line, key, message, hint),
        });
    }

    /// Takes what stands behind the hash.
    fn directive(&mut self, line: usize, rest: &str) {
        let end = rest
            .find(|c: char| !c.is_ascii_alphanumeric() && c != '_')
            .unwrap_or(rest.len());
        let (word, rest) = rest.split_at(end);
        let rest = rest.trim();
        match word {
            "define" => self.define(line, rest),
            "undef" => self.undefine(line, rest),
            "if" | "ifdef" | "ifndef" => {
                let text = match word {
                    "if" => rest.to_owned(),
                    "ifdef" => format!("defined({rest})"),
                    _ => format!("!defined({rest})"),
                };
                let is_met = self.is_met(&text);
                self.branches.push(Branch {
                    line,
                    text: shown(&text),
                    is_met,
                    was_met: is_met,
                    has_else: false,
                });
            }
            "elif" | "else" => self.next_branch(line, word, rest),
            "endif" if self.branches.pop().is_none() => {
                self.fail(line, "#endif", "there is no #if before it", CUT);
            }
            word if !DIRECTIVES.contains(&word) => {
                let key = format!("#{word}");
                self.fail(line, &key, "is no directive", "write #define NAME VALUE");
            }
            _ => {}
        }
    }

    /// Whether a condition is met; `None` where it cannot be told.
    fn is_met(&self, text: &str) -> Option<bool> {
        let found = expression::number(text, self.header, 0);
        found.ok().map(|it| it.value != 0.0)
    }

    /// `#elif` and `#else`.
    fn next_branch(&mut self, line: usize, word: &str, rest: &str) {
        let own = if word == "else" {
            Some(true)
        } else {
            self.is_met(rest)
        };
        let Some(branch) = self.branches.last_mut().filter(|branch| !branch.has_else) else {
            let key = format!("#{word}");
            let message = if self.branches.is_empty() {
                "there is no #if before it"
            } else {
                "there is an #else before it"
            };
            return self.fail(line, &key, message, CUT);
        };
        branch.is_met = match (branch.was_met, own) {
            (Some(true), _) | (_, Some(false)) => Some(false),
            (Some(false), own) => own,
            (None, _) => None,
        };
        branch.was_met = match (branch.was_met, own) {
            (Some(true), _) | (_, Some(true)) => Some(true),
            (Some(false), own) => own,
            (None, _) => None,
        };
        (branch.line, branch.has_else) = (line, word == "else");
        branch.text = if word == "else" {
            format!("#else of `{}`", branch.text)
        } else {
            shown(rest)
        };
    }

    /// Why a line here does not count, and whether that is certain.
    fn left_out(&self) -> Option<(String, bool)> {
        let own = |branch: &Branch| format!("`{}` (line {})", branch.text, branch.line);
        let not_met = self.branches.iter().find(|it| it.is_met == Some(false));
        let unknown = self.branches.iter().find(|it| it.is_met.is_none());
        match (not_met, unknown) {
            (Some(branch), _) => Some((format!("its condition {} is not met", own(branch)), true)),
            (None, Some(branch)) => {
                let why = format!("its condition {} cannot be told from the file", own(branch));
                Some((why, false))
            }
            (None, None) => None,
        }
    }

    fn define(&mut self, line: usize, rest: &str) {
        let end = rest
            .find(|c: char| !c.is_ascii_alphanumeric() && c != '_')
            .unwrap_or(rest.len());
        let (name, value) = rest.split_at(end);
        if name.is_empty() {
            return self.fail(line, "#define", "has no name", CUT);
        }
        let left_out = self.left_out();
        match &left_out {
            // What a macro with arguments stands for is no value.
            None if value.starts_with('(') => self.set(name, None),
            None => self.set(name, Some(value.trim())),
            Some((_, false)) => self.set(name, None),
            Some(_) => {}
        }
        let defines = &mut self.header.defines;
        if left_out.is_none() {
            self.header.last.insert(name.to_owned(), defines.len());
        }
        defines.push(Define {
            line: if self.file.is_some() { 1 } else { line },
            name: name.to_owned(),
            value: value.trim().to_owned(),
            place: self.file.map(|file| format!("line {line} of {file}")),
            left_out: left_out.map(|(why, _)| why),
        });
    }

    fn set(&mut self, name: &str, value: Option<&str>) {
        let values = &mut self.header.values;
        values.insert(name.to_owned(), value.map(str::to_owned));
    }

    fn undefine(&mut self, line: usize, name: &str) {
        match self.left_out() {
            None => {
                self.header.values.remove(name);
                if let Some(index) = self.header.last.remove(name)
                    && let Some(define) = self.header.defines.get_mut(index)
                {
                    define.left_out = Some(format!("line {line} takes it back"));
                }
            }
            Some((_, false)) => self.set(name, None),
            Some(_) => {}
        }
    }
}
