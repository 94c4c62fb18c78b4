//! A TOML text with the place of every key.

use super::problem::Problem;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A machine file has some 20 kB; what is much larger is something else, and would take long to be
/// told what is wrong with it.
const MAX_BYTES: usize = 256 * 1024;
/// The most syntax errors that are worth listing.
const MAX_SYNTAX_ERRORS: usize = 20;

/// A parsed text.
pub(super) struct Document<'a> {
    text: &'a str,
    /// The whole file as a table.
    pub(super) root: DeTable<'a>,
}

impl<'a> Document<'a> {
    /// Parses a text.
    ///
    /// # Errors
    /// All syntax errors; a text that is too long.
    pub(super) fn parse(text: &'a str) -> Result<Document<'a>, Vec<Problem>> {
        if text.len() > MAX_BYTES {
            let message = format!(
                "has {} bytes; a machine file has at most {MAX_BYTES}",
                text.len()
            );
            let hint = "is it a machine file? `lostmotion machine show vmc3` prints one".to_owned();
            return Err(vec![Problem {
                line: 1,
                column: 1,
                key: String::new(),
                message,
                hint,
            }]);
        }
        let (root, errors) = DeTable::parse_recoverable(text);
        let document = Document {
            text,
            root: root.into_inner(),
        };
        if errors.is_empty() {
            return Ok(document);
        }
        let problem = |error: &toml::de::Error| {
            let start = error.span().map_or(0, |span| span.start);
            document.problem_at(
                start,
                String::new(),
                error.message().replace('\n', "; "),
                String::new(),
            )
        };
        Err(errors.iter().take(MAX_SYNTAX_ERRORS).map(problem).collect())
    }

    /// A problem at a byte of the text.
    pub(super) fn problem_at(
        &self,
        byte: usize,
        key: String,
        message: String,
        hint: String,
    ) -> Problem {
        let (line, column) = self.place(byte);
        Problem {
            line,
            column,
            key,
            message,
            hint,
        }
    }

    /// A problem with the value of a dotted key; where the key is not in the text, its nearest
    /// table is pointed at.
    pub(super) fn problem(
        &self,
        key: &str,
        message: impl Into<String>,
        hint: impl Into<String>,
    ) -> Problem {
        self.problem_at(
            self.byte_of(key),
            key.to_owned(),
            message.into(),
            hint.into(),
        )
    }

    /// Line and column in bytes, both from 1, of a byte.
    fn place(&self, byte: usize) -> (u32, u32) {
        let before = self
            .text
            .as_bytes()
            .get(..byte)
            .unwrap_or(self.text.as_bytes());
        let line = before.iter().filter(|b| **b == b'\n').count() + 1;
        let column = before.iter().rev().take_while(|b| **b != b'\n').count() + 1;
        (
            u32::try_from(line).unwrap_or(u32::MAX),
            u32::try_from(column).unwrap_or(u32::MAX),
        )
    }

    /// Where a dotted key stands, or the longest part of it that is there.
    fn byte_of(&self, key: &str) -> usize {
        let mut table = Some(&self.root);
        let mut byte = 0;
        for part in key.split('.') {
            let name = part.split('[').next().unwrap_or(part);
            let Some((found, value)) = table.and_then(|table| table.get_key_value(name)) else {
                break;
            };
            byte = found.span().start;
            let element = match value.get_ref() {
                DeValue::Array(array) => index_of(part)
                    .and_then(|index| array.get(index))
                    .inspect(|element| byte = element.span().start),
                _ => Some(value),
            };
            table = element.and_then(|element| element.get_ref().as_table());
        }
        byte
    }
}

/// The index in `tool[2]`.
fn index_of(part: &str) -> Option<usize> {
    part.split_once('[')?.1.strip_suffix(']')?.parse().ok()
}

/// Dotted path below `value` of the key or value that has a span.
pub(super) fn path_of_span(value: &Spanned<DeValue<'_>>, span: &Range<usize>) -> Option<String> {
    match value.get_ref() {
        DeValue::Table(table) => table.iter().find_map(|(key, inner)| {
            let name = key.get_ref();
            if key.span() == *span || inner.span() == *span {
                return Some(name.to_string());
            }
            path_of_span(inner, span).map(|rest| {
                format!(
                    "{name}{}{rest}",
                    if rest.starts_with('[') { "" } else { "." }
                )
            })
        }),
        DeValue::Array(array) => array.iter().enumerate().find_map(|(index, inner)| {
            if inner.span() == *span {
                return Some(format!("[{index}]"));
            }
            path_of_span(inner, span).map(|rest| format!("[{index}].{rest}"))
        }),
        _ => None,
    }
}

/// Dotted keys of all numbers that are not finite, with what stands there.
pub(super) fn not_finite(table: &DeTable<'_>) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for (key, value) in table.iter() {
        walk(key.get_ref().to_string(), value.get_ref(), &mut found);
    }
    found
}

fn walk(path: String, value: &DeValue<'_>, found: &mut Vec<(String, String)>) {
    match value {
        DeValue::Table(table) => table.iter().for_each(|(key, inner)| {
            walk(format!("{path}.{}", key.get_ref()), inner.get_ref(), found)
        }),
        DeValue::Array(array) => array
            .iter()
            .enumerate()
            .for_each(|(i, inner)| walk(format!("{path}[{i}]"), inner.get_ref(), found)),
        DeValue::Float(float) if !float.as_str().parse::<f64>().is_ok_and(f64::is_finite) => {
            found.push((path, float.as_str().to_owned()))
        }
        _ => {}
    }
}
