//! Exponents of numbers: `X1.2E-12`.

use super::super::Interpreter;
use crate::dialect::Leniency;
use crate::syntax::{Text, Value};

impl Interpreter {
    /// Exponents: `X1.2E-12` has been read as X1.2 and E-12, which is put right. True if there were
    /// any.
    pub(crate) fn merge_exponents(&mut self) -> bool {
        if !self.config.leniencies.has(Leniency::Exponents) {
            return false;
        }
        let mut found = false;
        let mut index = 0;
        while let Some(&word) = self.block.words.get(index) {
            let (from, to) = (
                word.text.start as usize,
                (word.text.start + word.text.len) as usize,
            );
            let exponent = self
                .line
                .get(from + 1..to)
                .and_then(|text| std::str::from_utf8(text).ok())
                .map(str::to_owned);
            let signed = self.config.dialect.is_fanuc()
                || exponent
                    .as_ref()
                    .is_some_and(|text| text.starts_with(['+', '-']));
            match exponent.filter(|_| word.letter == b'E' && signed) {
                Some(exponent) if self.merge_exponent(index, word.text, &exponent) => found = true,
                _ => index += 1,
            }
        }
        if found {
            self.habit_at(Leniency::Exponents, self.span);
        }
        found
    }

    /// Joins the E word of an index to the word or setting that ends where it begins.
    fn merge_exponent(&mut self, index: usize, text: Text, exponent: &str) -> bool {
        let ends_here = |other: &Text| other.start + other.len == text.start;
        let power = |value: Value| match value {
            Value::Number(number) => {
                format!("{number:e}")
                    .split_once('e')
                    .and_then(|(digits, own)| {
                        let sum = own
                            .parse::<i64>()
                            .ok()?
                            .checked_add(exponent.parse::<i64>().ok()?)?;
                        format!("{digits}e{sum}")
                            .parse::<f64>()
                            .ok()
                            .filter(|number| number.is_finite())
                    })
            }
            Value::Ops(..) => None,
        };
        let before = index
            .checked_sub(1)
            .and_then(|before| self.block.words.get_mut(before));
        if let Some(word) = before
            .filter(|word| ends_here(&word.text) && !matches!(word.letter, b'G' | b'M' | b'E'))
        {
            let Some(value) = power(word.value) else {
                return false;
            };
            (word.value, word.text.len) = (Value::Number(value), word.text.len + text.len);
        } else if let Some(setting) = self
            .block
            .settings
            .iter_mut()
            .find(|setting| ends_here(&setting.text))
        {
            let Some(value) = power(setting.value) else {
                return false;
            };
            (setting.value, setting.text.len) = (Value::Number(value), setting.text.len + text.len);
        } else {
            return false;
        }
        self.block.words.remove(index);
        true
    }
}
