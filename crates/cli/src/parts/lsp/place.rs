//! Names of files and places in texts, as the protocol of language servers has them.

use serde_json::{Value, json};
use std::path::PathBuf;

/// The path of a `file:` address; `None` for a text that is no file yet.
pub(super) fn path_of(uri: &str) -> Option<PathBuf> {
    let rest = uri.strip_prefix("file://")?;
    // A host before the path, mostly none.
    let path = &rest[rest.find('/')?..];
    let mut bytes = Vec::with_capacity(path.len());
    let mut rest = path.as_bytes();
    while let Some((first, tail)) = rest.split_first() {
        let code = (*first == b'%').then(|| tail.get(..2)).flatten();
        let code = code.and_then(|digits| std::str::from_utf8(digits).ok());
        match code.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    let path = String::from_utf8(bytes).ok()?;
    // `/C:/part.ngc` of Windows is `C:/part.ngc`.
    let drive = path.as_bytes().get(2) == Some(&b':');
    Some(PathBuf::from(if drive { &path[1..] } else { &path }))
}

/// A text with the beginnings of its lines.
#[derive(Clone, Debug, Default)]
pub(super) struct OpenText {
    pub(super) text: String,
    starts: Vec<usize>,
}

impl OpenText {
    pub(super) fn new(text: String) -> OpenText {
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let starts = std::iter::once(0)
            .chain(ends.map(|(at, _)| at + 1))
            .collect();
        OpenText { text, starts }
    }

    /// Number of lines; the last one may be empty.
    pub(super) fn lines(&self) -> usize {
        self.starts.len()
    }

    /// A line from 0, without its end.
    fn line(&self, line: usize) -> &str {
        let from = self.starts.get(line).copied().unwrap_or(self.text.len());
        let to = self
            .starts
            .get(line + 1)
            .copied()
            .unwrap_or(self.text.len());
        self.text[from..to].trim_end_matches(['\n', '\r'])
    }

    /// The place of a byte of a line, in the protocol's units of UTF-16.
    fn position(&self, line: usize, byte: usize) -> Value {
        let text = self.line(line);
        let mut byte = byte.min(text.len());
        while !text.is_char_boundary(byte) {
            byte -= 1;
        }
        json!({ "line": line, "character": text[..byte].encode_utf16().count() })
    }

    /// So many bytes of a line from 1, from a column from 1 on; of no length to the line's end.
    /// Line 0 is the first one as a whole.
    pub(super) fn range(&self, line: u32, column: u32, len: u32) -> Value {
        let at = (line.max(1) - 1) as usize;
        let from = if line == 0 {
            0
        } else {
            (column.max(1) - 1) as usize
        };
        let to = match len {
            0 => usize::MAX,
            len => from + len as usize,
        };
        json!({ "start": self.position(at, from), "end": self.position(at, to) })
    }

    /// Behind the last character of a line from 1.
    pub(super) fn end_of(&self, line: u32) -> Value {
        self.position((line.max(1) - 1) as usize, usize::MAX)
    }

    /// Everything.
    pub(super) fn whole(&self) -> Value {
        let last = self.lines() - 1;
        json!({ "start": { "line": 0, "character": 0 }, "end": self.position(last, usize::MAX) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_paths() {
        let path = |uri| path_of(uri).map(|path| path.display().to_string());
        assert_eq!(
            path("file:///a/my%20part%C3%A4.ngc").as_deref(),
            Some("/a/my part\u{e4}.ngc")
        );
        assert_eq!(path("file:///C:/a.ngc").as_deref(), Some("C:/a.ngc"));
        assert_eq!(path("file:///100%").as_deref(), Some("/100%"));
        assert_eq!(path("untitled:part"), None);
        assert_eq!(path("file:///%ff"), None);
    }

    /// Columns count bytes in findings and units of UTF-16 in the protocol.
    #[test]
    fn places_are_counted_in_utf16() {
        let text = OpenText::new("G1 (\u{e4}\u{1f600}) X1\r\nX2".to_owned());
        let word = "G1 (\u{e4}\u{1f600}) ".len() as u32 + 1;
        assert_eq!(
            text.range(1, word, 2),
            json!({ "start": { "line": 0, "character": 9 }, "end": { "line": 0, "character": 11 } })
        );
        assert_eq!(text.end_of(1), json!({ "line": 0, "character": 11 }));
        // Past the end of the text is its end.
        assert_eq!(
            text.range(9, 4, 1)["start"],
            json!({ "line": 8, "character": 0 })
        );
        assert_eq!(text.whole()["end"], json!({ "line": 1, "character": 2 }));
        // The middle of a character is its beginning.
        assert_eq!(text.range(1, 6, 0)["start"]["character"], 4);
    }
}
