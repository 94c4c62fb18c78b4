//! Words and expressions: blanks and case, outside names and comments.

use super::Case;

/// A letter with its value, without blanks between them or inside a plain number.
pub(super) fn put_value(out: &mut Vec<u8>, word: &[u8], case: Case) {
    let Some((&letter, value)) = word.split_first() else {
        return;
    };
    out.push(cased(letter, case));
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
