//! M codes of the machine's builder, which mean what the builder wants: skipped if the settings say
//! so, refused otherwise.

use super::Once;
use crate::codes::row::bit;
use crate::codes::{Code, find};
use crate::interpreter::Interpreter;
use crate::problem::Problem;
use crate::syntax::{Text, Value};

/// Words that an M code of a builder may bring along.
const WORDS: [u8; 11] = *b"BDEHIJKLPQR";

/// The words of a builder's M code as bits.
pub(crate) fn words() -> u32 {
    WORDS.into_iter().fold(0, |bits, letter| bits | bit(letter))
}

impl Interpreter {
    /// Takes M codes off the block that are to be ignored, and those that are not known, which are
    /// told once. True if there were any: their other words stand there without a code then.
    pub(crate) fn take_foreign_m_codes(&mut self) -> bool {
        let mut found = false;
        let mut index = 0;
        while let Some(&word) = self.block.words.get(index) {
            let code = match (word.letter, word.value) {
                (b'M', Value::Number(number)) => Code::of('M', number),
                _ => None,
            };
            match code {
                Some(code) if self.config.ignored_m_codes.contains(&code) => {}
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
}
