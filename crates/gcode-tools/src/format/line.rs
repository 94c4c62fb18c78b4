//! One line in the style asked for.

use super::{Case, Formatter, LineNumbers};
use lostmotion_gcode::syntax::{Block, Text, parse_block};

impl Formatter<'_> {
    /// The line in its new form; `None` if it has to stay as it is.
    pub(super) fn line(&mut self, line: &[u8]) -> Option<Vec<u8>> {
        if line.len() > self.options.limits.line_bytes
            || parse_block(line, &mut self.block, &self.options.limits).is_err()
        {
            return None;
        }
        // The level is taken even if the line stays as it is: later lines depend on it.
        let (shown, before) = (self.indent.level(&self.block), self.number);
        let formatted = self.pieces(line, shown * self.options.indent);
        // The new line is parsed again: only if it gives the same block may it replace the old
        // one.
        let mut again = Block::default();
        let is_same = formatted.as_ref().is_some_and(|formatted| {
            formatted.len() <= self.options.limits.line_bytes
                && parse_block(formatted, &mut again, &self.options.limits).is_ok()
                && same(&self.block, line, &again, formatted)
        });
        if !is_same {
            // A line that stays does not use up a number.
            self.number = before;
        }
        formatted.filter(|_| is_same)
    }

    fn pieces(&mut self, line: &[u8], indent: usize) -> Option<Vec<u8>> {
        if self.block.percent {
            return Some(line.trim_ascii().to_vec());
        }
        // The fixed order of a block: `/`, N number, then O-word or items.
        let mut out = Vec::with_capacity(line.len() + 16);
        // Block delete and line number are recognised by their bytes, items by the parser's
        // places.
        let mut at = blanks(line, 0);
        let deletable = line.get(at) == Some(&b'/');
        if deletable {
            at = blanks(line, at + 1);
        }
        let number =
            matches!(line.get(at), Some(b'n' | b'N')).then(|| (at, number_end(line, at + 1)));
        at = number.map_or(at, |(_, end)| end);
        if let Some(number) = self.number(line, number) {
            out.extend_from_slice(&number);
        }
        if self.block.flow.is_some() {
            let rest = line.get(at..)?.trim_ascii_start();
            separate(&mut out);
            // O-words keep their case: LinuxCNC's own programs write them in lower case.
            let case = if self.options.case == Case::Upper {
                Case::Keep
            } else {
                self.options.case
            };
            put_text(&mut out, rest, case);
        } else {
            self.items(line, at, &mut out)?;
        }
        // A line of blanks becomes an empty one, without indentation.
        if out.is_empty() && !deletable {
            return Some(Vec::new());
        }
        let mut whole = vec![b' '; indent];
        if deletable {
            whole.push(b'/');
        }
        whole.extend_from_slice(&out);
        Some(whole)
    }

    /// The line number to show.
    fn number(&mut self, line: &[u8], old: Option<(usize, usize)>) -> Option<Vec<u8>> {
        match self.options.line_numbers {
            LineNumbers::Remove => None,
            LineNumbers::Renumber { step } if self.block.flow.is_none() => {
                // Lines of comments alone are not numbered.
                if self.block.words.is_empty() && self.block.settings.is_empty() {
                    return None;
                }
                self.number += u64::from(step);
                Some(
                    format!(
                        "{}{}",
                        if self.options.case == Case::Lower {
                            'n'
                        } else {
                            'N'
                        },
                        self.number
                    )
                    .into_bytes(),
                )
            }
            _ => {
                let (from, to) = old?;
                let mut out = Vec::new();
                put_value(&mut out, line.get(from..to)?, self.options.case);
                Some(out)
            }
        }
    }

    /// Words, settings and comments with a blank between them.
    fn items(&self, line: &[u8], from: usize, out: &mut Vec<u8>) -> Option<()> {
        let block = &self.block;
        let mut at = from;
        loop {
            at = blanks(line, at);
            let Some(&first) = line.get(at) else {
                return Some(());
            };
            separate(out);
            let starts = |text: &&Text| text.start as usize == at;
            // Comments are copied byte for byte; words and settings get their case and spacing.
            let end = if first == b'(' {
                let end = at + line.get(at..)?.iter().position(|byte| *byte == b')')? + 1;
                out.extend_from_slice(line.get(at..end)?);
                end
            } else if first == b';' {
                out.extend_from_slice(line.get(at..)?);
                line.len()
            } else if let Some(text) = block.words.iter().map(|word| &word.text).find(starts) {
                let end = at + text.len as usize;
                put_value(out, line.get(at..end)?, self.options.case);
                end
            } else {
                let text = block
                    .settings
                    .iter()
                    .map(|setting| &setting.text)
                    .find(starts)?;
                let end = at + text.len as usize;
                put_text(out, line.get(at..end)?, self.options.case);
                end
            };
            at = end;
        }
    }
}

/// A blank between two pieces.
fn separate(out: &mut Vec<u8>) {
    if !out.is_empty() {
        out.push(b' ');
    }
}

/// The place after blanks.
fn blanks(line: &[u8], from: usize) -> usize {
    let rest = line.get(from..).unwrap_or_default();
    from + rest
        .iter()
        .take_while(|byte| matches!(byte, b' ' | b'\t'))
        .count()
}

/// Where a literal number ends that may have blanks inside.
fn number_end(line: &[u8], from: usize) -> usize {
    let mut end = from;
    loop {
        let next = blanks(line, end);
        match line.get(next) {
            Some(b'0'..=b'9' | b'.' | b'+' | b'-') => end = next + 1,
            _ => return end,
        }
    }
}

/// Whether two parsed lines mean the same, apart from line numbers.
fn same(one: &Block, line: &[u8], other: &Block, formatted: &[u8]) -> bool {
    let comment = |block: &Block, line: &[u8]| {
        block.comment.and_then(|text| {
            line.get(text.start as usize..(text.start + text.len) as usize)
                .map(<[u8]>::to_vec)
        })
    };
    // Words and settings are compared in order: a modal group may depend on it.
    let words = one.words.len() == other.words.len()
        && one
            .words
            .iter()
            .zip(&other.words)
            .all(|(a, b)| a.letter == b.letter && a.value == b.value);
    let settings = one.settings.len() == other.settings.len()
        && one
            .settings
            .iter()
            .zip(&other.settings)
            .all(|(a, b)| a.target == b.target && a.value == b.value);
    words
        && settings
        && (one.deletable, one.percent, one.flow) == (other.deletable, other.percent, other.flow)
        && one.arguments == other.arguments
        && one.ops == other.ops
        && one.names == other.names
        && comment(one, line) == comment(other, formatted)
}

/// A letter with its value, without blanks between them or inside a plain number.
pub(super) fn put_value(out: &mut Vec<u8>, word: &[u8], case: Case) {
    let Some((&letter, value)) = word.split_first() else {
        return;
    };
    out.push(cased(letter, case));
    // A literal number may hold blanks, which mean nothing; expressions keep one blank between
    // tokens.
    let is_plain = value
        .iter()
        .all(|byte| matches!(byte, b'0'..=b'9' | b'.' | b'+' | b'-' | b' ' | b'\t'));
    if is_plain {
        out.extend(value.iter().filter(|byte| !matches!(byte, b' ' | b'\t')));
    } else {
        put_text(out, value.trim_ascii_start(), case);
    }
}

/// Text with runs of blanks made one, and one blank around the `=` of a setting; names and comments
/// stay as they are.
pub(super) fn put_text(out: &mut Vec<u8>, text: &[u8], case: Case) {
    let mut closing = None;
    let mut pending = false;
    for &byte in text {
        // Inside a name or comment every byte counts.
        if let Some(end) = closing {
            out.push(byte);
            if byte == end {
                closing = None;
            }
            continue;
        }
        if matches!(byte, b' ' | b'\t') {
            pending = true;
            continue;
        }
        // One blank where there were several, and on both sides of `=`.
        let after_equals = out.last() == Some(&b'=');
        if (pending || byte == b'=' || after_equals) && out.last().is_some_and(|last| *last != b' ')
        {
            out.push(b' ');
        }
        pending = false;
        closing = match byte {
            b'<' => Some(b'>'),
            b'(' => Some(b')'),
            b';' => Some(b'\n'),
            _ => None,
        };
        out.push(if closing.is_some() {
            byte
        } else {
            cased(byte, case)
        });
    }
}

const fn cased(byte: u8, case: Case) -> u8 {
    match case {
        Case::Upper => byte.to_ascii_uppercase(),
        Case::Lower => byte.to_ascii_lowercase(),
        Case::Keep => byte,
    }
}
