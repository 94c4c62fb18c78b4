//! Lines of other dialects: what of them is rewritten, skipped or called before the words are carried out.

use super::Interpreter;
use crate::dialect::{Dialect, Leniency};
use crate::exec::corner::is_straight;
use crate::ops::SourcedOp;
use crate::problem::{Code, Problem};
use crate::syntax::evaluate::whole;
use crate::syntax::special::{parse_special, siemens_word};
use crate::syntax::{Fault, Text, Value, Word};

/// Numbers of the parameters that the letters A to Z of a G65 set; 0 for letters that are no arguments.
const ARGUMENTS: [u8; 26] = [1, 2, 3, 7, 8, 9, 0, 11, 4, 5, 6, 0, 13, 0, 0, 0, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26];
/// Highest parameter that an argument sets.
const HIGHEST_ARGUMENT: usize = 26;
/// An M98 P beyond this has the rounds in front of four digits of the program's number.
const PACKED: f64 = 10_000.0;
/// G codes in tenths, and M codes, of printers that mean the same here.
const PRINTER_G: [u16; 25] =
    [0, 10, 20, 30, 40, 50, 170, 180, 190, 200, 210, 280, 530, 540, 550, 560, 570, 580, 590, 591, 592, 593, 900, 910, 920];
const PRINTER_M: [f64; 11] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 30.0];

/// A macro called after every move (G66).
#[derive(Clone, Debug)]
pub(crate) struct ModalMacro {
    name: String,
    arguments: Vec<f64>,
    /// Calls in progress where it was set: its own moves do not call it.
    depth: usize,
}

/// What becomes of a line.
pub(crate) enum Line {
    /// Its words are carried out as usual.
    Words,
    /// It is done.
    Done,
}

impl Interpreter {
    /// Says once that a leniency was made use of.
    pub(crate) fn tell(&mut self, leniency: Leniency) {
        if !self.told.has(leniency) {
            self.told = self.told.with(leniency);
            self.report(Problem::Lenient { leniency });
        }
    }

    /// Reports what a leniency forgives: a warning if it is accepted, an error otherwise.
    pub(crate) fn forgive(&mut self, problem: Problem, leniency: Leniency) {
        self.report(if self.config.leniencies.has(leniency) { problem } else { Problem::NotLenient { leniency } });
    }

    /// Another try at a line that is a fault in RS274/NGC.
    #[cold]
    pub(crate) fn parse_specially(&mut self, fault: Fault) -> Result<(), Fault> {
        let accepted = self.config.leniencies;
        match parse_special(&self.line, &mut self.block, &self.config.limits, accepted) {
            Ok(taken) if !taken.is_empty() => {
                if !self.is_passing() {
                    taken.into_iter().for_each(|leniency| self.tell(leniency));
                }
                return Ok(());
            }
            Err(Fault { rest, problem }) if matches!(*problem, Problem::Checksum { .. }) => return Err(Fault { rest, problem }),
            _ => {}
        }
        match siemens_word(&self.line) {
            Some(what) => Err(Fault { problem: Box::new(Problem::Siemens { what }), ..fault }),
            None => Err(fault),
        }
    }

    /// Exponents: `X1.2E-12` has been read as X1.2 and E-12, which is put right. True if there were any.
    pub(crate) fn merge_exponents(&mut self) -> bool {
        if !self.config.leniencies.has(Leniency::Exponents) {
            return false;
        }
        let mut found = false;
        let mut index = 0;
        while let Some(&word) = self.block.words.get(index) {
            let (from, to) = (word.text.start as usize, (word.text.start + word.text.len) as usize);
            let exponent = self.line.get(from + 1..to).and_then(|text| std::str::from_utf8(text).ok()).map(str::to_owned);
            let signed = self.config.dialect.is_fanuc() || exponent.as_ref().is_some_and(|text| text.starts_with(['+', '-']));
            match exponent.filter(|_| word.letter == b'E' && signed) {
                Some(exponent) if self.merge_exponent(index, word.text, &exponent) => found = true,
                _ => index += 1,
            }
        }
        if found {
            self.tell(Leniency::Exponents);
        }
        found
    }

    /// Joins the E word of an index to the word or setting that ends where it begins.
    fn merge_exponent(&mut self, index: usize, text: Text, exponent: &str) -> bool {
        let ends_here = |other: &Text| other.start + other.len == text.start;
        let power = |value: Value| match value {
            Value::Number(number) => format!("{number:e}").split_once('e').and_then(|(digits, own)| {
                let sum = own.parse::<i64>().ok()?.checked_add(exponent.parse::<i64>().ok()?)?;
                format!("{digits}e{sum}").parse::<f64>().ok().filter(|number| number.is_finite())
            }),
            Value::Ops(..) => None,
        };
        let before = index.checked_sub(1).and_then(|before| self.block.words.get_mut(before));
        if let Some(word) = before.filter(|word| ends_here(&word.text) && !matches!(word.letter, b'G' | b'M' | b'E')) {
            let Some(value) = power(word.value) else { return false };
            (word.value, word.text.len) = (Value::Number(value), word.text.len + text.len);
        } else if let Some(setting) = self.block.settings.iter_mut().find(|setting| ends_here(&setting.text)) {
            let Some(value) = power(setting.value) else { return false };
            (setting.value, setting.text.len) = (Value::Number(value), setting.text.len + text.len);
        } else {
            return false;
        }
        self.block.words.remove(index);
        true
    }

    /// What a dialect other than RS274/NGC makes of a line before its words are collected.
    #[cold]
    pub(crate) fn dialect_line(&mut self, out: &mut Vec<SourcedOp>) -> Result<Line, (Problem, Option<Text>)> {
        let accepted = self.config.leniencies;
        if self.config.dialect == Dialect::Siemens && !(self.block.words.is_empty() && self.block.settings.is_empty()) {
            let what = siemens_word(&self.line).unwrap_or("the program");
            self.state.ended = true;
            return Err((Problem::Siemens { what }, None));
        }
        if accepted.has(Leniency::LowerCase) && !self.told.has(Leniency::LowerCase) {
            let code = self.line.split(|byte| matches!(byte, b'(' | b';')).next().unwrap_or_default();
            if code.iter().any(u8::is_ascii_lowercase) {
                self.tell(Leniency::LowerCase);
            }
        }
        if self.config.dialect.is_printer() {
            return Ok(self.printer_line());
        }
        let has =
            |letter: u8, number: f64| self.block.words.iter().any(|word| word.letter == letter && word.value == Value::Number(number));
        if accepted.has(Leniency::MacroCalls) && (has(b'G', 65.0) || has(b'G', 66.0) || has(b'G', 67.0)) {
            return self.macro_line().map(|()| Line::Done).map_err(|problem| (problem, None));
        }
        if accepted.has(Leniency::LocalCalls) && has(b'M', 97.0) {
            return self.local_call().map(|()| Line::Done).map_err(|problem| (problem, None));
        }
        let patterns = accepted.has(Leniency::HolePatterns) && [70.0, 71.0, 72.0].into_iter().any(|number| has(b'G', number));
        if patterns {
            return self.hole_pattern(out).map(|()| Line::Done);
        }
        Ok(Line::Words)
    }

    /// G65 to G67.
    fn macro_line(&mut self) -> Result<(), Problem> {
        let mut arguments = vec![0.0; HIGHEST_ARGUMENT];
        let (mut code, mut name, mut rounds, mut triples) = (0.0, None, 1.0, 0_usize);
        for index in 0..self.block.words.len() {
            let Some(&word) = self.block.words.get(index) else { break };
            let value = self.value(word.value)?;
            match word.letter {
                b'G' => code = value,
                b'P' => name = whole(value),
                b'L' => rounds = value,
                b'N' | b'O' => {}
                letter => {
                    // I, J and K may come in several sets: #4 to #6, #7 to #9 and so on.
                    triples += usize::from(letter == b'I' && index > 0);
                    let first = usize::from(ARGUMENTS.get(usize::from(letter.wrapping_sub(b'A'))).copied().unwrap_or(0));
                    let shift = if matches!(letter, b'I'..=b'K') { 3 * triples.saturating_sub(1) } else { 0 };
                    match (first, arguments.get_mut((first + shift).wrapping_sub(1))) {
                        (1.., Some(slot)) => *slot = value,
                        _ => return Err(Problem::RepeatedWord { letter: char::from(letter) }),
                    }
                }
            }
        }
        self.tell(Leniency::MacroCalls);
        if code == 67.0 {
            self.modal_macro = None;
            return Ok(());
        }
        let code_name = Code { letter: 'G', tenths: if code == 65.0 { 650 } else { 660 } };
        let name = name.ok_or(Problem::WordMissing { code: code_name, what: "P, the number of the macro" })?;
        let name = format!("{name}");
        let rounds =
            whole(rounds).filter(|rounds| (0.0..=1e15).contains(rounds)).ok_or(Problem::BadWordValue { letter: 'L', value: rounds })?;
        if code == 66.0 {
            self.modal_macro = Some(ModalMacro { name, arguments, depth: self.flow.frames.len() });
            return Ok(());
        }
        self.call(name, Some(&arguments), rounds as u64)
    }

    /// Calls the macro of a G66 after a move of the level that set it.
    pub(crate) fn call_modal_macro(&mut self) -> Result<(), Problem> {
        let Some(modal) = self.modal_macro.as_ref().filter(|modal| modal.depth == self.flow.frames.len()) else { return Ok(()) };
        if self.words.motion.is_none() || !self.flow.subs.contains_key(&modal.name) {
            return Ok(());
        }
        let (name, arguments) = (modal.name.clone(), modal.arguments.clone());
        self.call(name, Some(&arguments), 1)
    }

    /// The macro of a G66, if the block moves and the macro is not known yet.
    pub(crate) fn wanted_macro(&self) -> Option<String> {
        let modal = self.modal_macro.as_ref().filter(|modal| modal.depth == self.flow.frames.len())?;
        let moves = self.words.mask & crate::exec::words::AXIS_BITS != 0;
        (moves && !self.flow.subs.contains_key(&modal.name)).then(|| modal.name.clone())
    }

    /// M97: the lines from an N number to M99 as a subroutine.
    fn local_call(&mut self) -> Result<(), Problem> {
        let (mut number, mut rounds) = (None, 1.0);
        for index in 0..self.block.words.len() {
            let Some(&word) = self.block.words.get(index) else { break };
            let value = self.value(word.value)?;
            match word.letter {
                b'P' => number = whole(value),
                b'L' => rounds = whole(value).filter(|rounds| (0.0..=1e15).contains(rounds)).unwrap_or(1.0),
                _ => {}
            }
        }
        let code = Code { letter: 'M', tenths: 970 };
        let number = number.ok_or(Problem::WordMissing { code, what: "P, the line number of the subroutine" })?;
        self.tell(Leniency::LocalCalls);
        self.call(format!("n{number}"), None, rounds as u64)
    }

    /// G70 to G72 of Haas: the cycle in force at the places of a pattern.
    fn hole_pattern(&mut self, out: &mut Vec<SourcedOp>) -> Result<(), (Problem, Option<Text>)> {
        let is_pattern = |word: &Word| word.letter == b'G' && matches!(word.value, Value::Number(70.0 | 71.0 | 72.0));
        let Some(at) = self.block.words.iter().position(is_pattern) else { return Ok(()) };
        let word = self.block.words.remove(at);
        self.collect_words()?;
        let tenths = if let Value::Number(number) = word.value { (number * 10.0) as u16 } else { 0 };
        let code = Code { letter: 'G', tenths };
        let cycle = match (self.words.codes().iter().find(|used| used.row.group == crate::codes::Group::Motion), self.state.motion) {
            (Some(used), _) => return Err((Problem::TwoAxisUsers { code, other: used.row.code }, Some(word.text))),
            (None, Some(cycle)) if matches!(cycle.tenths, 730 | 740 | 810..=890) => cycle,
            _ => {
                return Err((
                    Problem::Cycle { message: "a pattern of holes needs a canned cycle (G73, G74, G81 to G89) before it" },
                    Some(word.text),
                ));
            }
        };
        self.tell(Leniency::HolePatterns);
        self.exec(out).pattern(code, cycle).map_err(|problem| (problem, Some(word.text)))
    }

    /// Rounds and number in one P of M98.
    pub(crate) fn unpack_call(&mut self) {
        if !self.config.leniencies.has(Leniency::PackedCalls) || self.words.has(b'L') {
            return;
        }
        let is_call = self.words.codes().iter().any(|used| used.row.code == Code { letter: 'M', tenths: 980 });
        if let (true, Some(number)) = (is_call, self.words.get(b'P').and_then(whole).filter(|number| *number >= PACKED)) {
            self.words.put(b'P', number % PACKED);
            self.words.put(b'L', (number / PACKED).floor());
            self.tell(Leniency::PackedCalls);
        }
    }

    /// Dwells in milliseconds: P without a decimal point; X and U are seconds.
    pub(crate) fn fanuc_dwell(&mut self) {
        let is_dwell = self.words.has_g(40);
        let is_cycle = |code: Code| matches!(code.tenths, 730..=742 | 810..=890) && code.letter == 'G';
        let named = self.words.codes().iter().any(|used| is_cycle(used.row.code));
        let motion = self.words.codes().iter().any(|used| used.row.group == crate::codes::Group::Motion);
        if is_dwell && !self.words.has(b'P') {
            for letter in *b"XU" {
                if let Some(seconds) = self.words.get(letter) {
                    self.words.drop_word(letter);
                    self.words.put(b'P', seconds);
                }
            }
        } else if (is_dwell || named || (!motion && self.state.motion.is_some_and(is_cycle)))
            && let Some(value) = self.words.get(b'P')
        {
            let text = self.words.text(b'P');
            let written = self.line.get(text.start as usize..(text.start + text.len) as usize).unwrap_or_default();
            if !written.iter().any(|byte| matches!(byte, b'.' | b'[' | b'#')) {
                self.words.put(b'P', value / 1000.0);
            }
        }
    }

    /// What a printer's line means on a machine tool.
    fn printer_line(&mut self) -> Line {
        let accepted = self.config.leniencies;
        let foreign = self.block.words.iter().any(|word| match (word.letter, word.value) {
            (b'G', Value::Number(number)) => {
                whole(number * 10.0).is_none_or(|tenths| !PRINTER_G.iter().any(|known| f64::from(*known) == tenths))
            }
            (b'M', Value::Number(number)) => !PRINTER_M.contains(&number),
            _ => false,
        });
        if foreign && accepted.has(Leniency::PrinterCodes) {
            self.tell(Leniency::PrinterCodes);
            return Line::Done;
        }
        if accepted.has(Leniency::ExtruderWords) && self.block.words.iter().any(|word| word.letter == b'E') {
            self.tell(Leniency::ExtruderWords);
            self.block.words.retain(|word| word.letter != b'E');
            let has_axis = self.block.words.iter().any(|word| matches!(word.letter, b'X'..=b'Z' | b'A'..=b'C' | b'U'..=b'W'));
            self.block.words.retain(|word| has_axis || word.letter != b'G' || word.value != Value::Number(92.0));
        }
        self.printer_dwell();
        Line::Words
    }

    /// G4 of printers: P in milliseconds, S in seconds.
    fn printer_dwell(&mut self) {
        if !self.block.words.iter().any(|word| word.letter == b'G' && word.value == Value::Number(4.0)) {
            return;
        }
        let has_s = self.block.words.iter().any(|word| word.letter == b'S');
        self.block.words.retain(|word| !(has_s && word.letter == b'P'));
        for word in &mut self.block.words {
            match (word.letter, word.value) {
                (b'S', _) => word.letter = b'P',
                (b'P', Value::Number(ms)) => word.value = Value::Number(ms / 1000.0),
                _ => {}
            }
        }
    }

    /// Leniencies about words that contradict one another. True if the block can be tried again.
    #[cold]
    pub(crate) fn reconcile(&mut self, problem: &Problem) -> bool {
        let accepted = self.config.leniencies;
        if let (Problem::TwoAxisUsers { code, other }, true) = (problem, accepted.has(Leniency::ExtraMotion))
            && matches!(code.tenths, 280 | 300)
            && is_straight(*other)
        {
            self.words.drop_motion();
            self.state.motion = Some(*other);
            self.tell(Leniency::ExtraMotion);
            return true;
        }
        false
    }
}
