//! M codes of the machine's builder, which mean what the builder wants: they do what the settings
//! say, and are refused otherwise.
//!
//! A code that calls a subroutine does so after the rest of its line; one that calls a macro takes
//! the line's words as arguments and carries nothing else out (B-62093E, "Difference between
//! Subprogram Call (T, M) and Macro Call (G, M)").

use super::Once;
use crate::codes::row::bit;
use crate::codes::{Code, find};
use crate::config::MCodeUse;
use crate::interpreter::Interpreter;
use crate::ops::SourcedOp;
use crate::problem::Problem;
use crate::syntax::{Text, Value, Word};

/// Words that an M code of a builder may bring along.
const WORDS: [u8; 11] = *b"BDEHIJKLPQR";

/// The words of a builder's M code as bits.
pub(crate) fn words() -> u32 {
    WORDS.into_iter().fold(0, |bits, letter| bits | bit(letter))
}

/// The code of a word with M.
fn m_code(word: &Word) -> Option<Code> {
    match (word.letter, word.value) {
        (b'M', Value::Number(number)) => Code::of('M', number),
        _ => None,
    }
}

impl Interpreter {
    /// Takes M codes off the block that the settings give a meaning, and those that are not known,
    /// which are told once. True if there were any: their other words stand there without a code
    /// then.
    pub(crate) fn take_foreign_m_codes(&mut self) -> bool {
        self.foreign.clear();
        let mut found = false;
        let mut index = 0;
        while let Some(&word) = self.block.words.get(index) {
            match m_code(&word) {
                Some(code) if self.config.m_codes.contains_key(&code) => {
                    self.foreign.extend(self.config.m_codes.get(&code).cloned());
                }
                Some(code) if find(code).is_none() => self.tell_unknown(code, word.text),
                _ => {
                    index += 1;
                    continue;
                }
            }
            found = true;
            self.block.words.remove(index);
        }
        found
    }

    #[cold]
    fn tell_unknown(&mut self, code: Code, text: Text) {
        if self.told_once.insert(Once::Code(code)) {
            self.place_and_report(Problem::UnsupportedCode { code }, Some(text));
        }
    }

    /// The macro that an M code of the line calls, and the place of that code on the line.
    pub(crate) fn foreign_macro(&self) -> Option<(String, usize)> {
        if self.config.m_codes.is_empty() {
            return None;
        }
        let calls = |word: &Word| match self.config.m_codes.get(&m_code(word)?) {
            Some(MCodeUse::Macro(number)) => Some(number.to_string()),
            _ => None,
        };
        let words = self.block.words.iter().enumerate();
        words
            .filter_map(|(index, word)| calls(word).map(|name| (name, index)))
            .next()
    }

    /// The subroutine that an M code of the line calls, if it is not known yet.
    pub(crate) fn wanted_foreign(&self) -> Option<String> {
        let called = self.foreign.iter().find_map(|what| match what {
            MCodeUse::Call(number) => Some(number.to_string()),
            _ => None,
        });
        called.filter(|name| !self.flow.subs.contains_key(name))
    }

    /// Does what the M codes that were taken off the line do, after the rest of it.
    pub(crate) fn run_foreign(&mut self, out: &mut Vec<SourcedOp>) -> Result<(), Problem> {
        for what in std::mem::take(&mut self.foreign) {
            match what {
                MCodeUse::Stop => self.exec(out).stop_program()?,
                MCodeUse::Dwell(seconds) => self.exec(out).pause(seconds)?,
                MCodeUse::Call(number) => self.call(number.to_string(), None, 1)?,
                MCodeUse::Ignore | MCodeUse::Macro(_) => {}
            }
        }
        Ok(())
    }
}
