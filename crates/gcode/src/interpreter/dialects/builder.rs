//! M codes of the machine's builder, which mean what the builder wants: they do what the settings
//! say, and are refused otherwise.
//!
//! A code that calls a subroutine does so after the rest of its line; one that calls a macro takes
//! the line's words as arguments and carries nothing else out (B-62093E, "Difference between
//! Subprogram Call (T, M) and Macro Call (G, M)"). In what an M code has called, M codes are ordinary
//! ones (B-63944EN, "Macro Call Using an M Code"): a tool change of one's own may end with M6.

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
    /// What the settings make of an M code here.
    fn told_use(&self, code: Code) -> Option<&MCodeUse> {
        let what = self.config.m_codes.get(&code)?;
        let calls = matches!(what, MCodeUse::Call(_) | MCodeUse::Macro(_));
        if !calls || !self.flow.frames.iter().any(|frame| frame.by_m_code) {
            return Some(what);
        }
        // Ordinary there: its own meaning, or none that moves an axis.
        find(code).is_none().then_some(&MCodeUse::Ignore)
    }

    /// Calls what an M code stands for.
    pub(crate) fn call_by_m_code(
        &mut self,
        name: String,
        arguments: Option<&[f64]>,
    ) -> Result<(), Problem> {
        let depth = self.flow.frames.len();
        self.call(name, arguments, 1)?;
        // It may be looked for first.
        if let Some(frame) = self.flow.frames.get_mut(depth) {
            frame.by_m_code = true;
        }
        Ok(())
    }

    /// Takes M codes off the block that the settings give a meaning, and those that are not known,
    /// which are told once. True if there were any: their other words stand there without a code
    /// then.
    pub(crate) fn take_foreign_m_codes(&mut self) -> bool {
        self.foreign.clear();
        let mut found = false;
        let mut index = 0;
        while let Some(&word) = self.block.words.get(index) {
            let code = m_code(&word);
            match (code, code.and_then(|code| self.told_use(code)).cloned()) {
                (_, Some(what)) => self.foreign.push(what),
                (Some(code), None) if find(code).is_none() => self.tell_unknown(code, word.text),
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
        let calls = |word: &Word| match self.told_use(m_code(word)?) {
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
                MCodeUse::Call(number) => self.call_by_m_code(number.to_string(), None)?,
                MCodeUse::Ignore | MCodeUse::Macro(_) => {}
            }
        }
        Ok(())
    }
}
