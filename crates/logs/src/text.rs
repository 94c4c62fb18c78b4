//! Lines of a text of any size, their cells, and numbers as people's computers write them.

use crate::error::LogError;
use std::borrow::Cow;
use std::io::BufRead;

/// Longest line that is read, bytes. A choice: a row of 4,000 channels has some 100 kB.
pub(crate) const MAX_LINE_BYTES: usize = 1 << 20;

/// Lines of a log.
pub(crate) struct Lines<R> {
    input: R,
    name: String,
    bytes: Vec<u8>,
    text: String,
    line: u64,
    /// Whether the line read last had its end.
    ended: bool,
    /// Whether bytes were taken for Latin-1.
    pub(crate) latin: bool,
}

impl<R: BufRead> Lines<R> {
    pub(crate) fn new(input: R, name: &str) -> Lines<R> {
        Lines {
            input,
            name: name.to_owned(),
            bytes: Vec::new(),
            text: String::new(),
            line: 0,
            ended: true,
            latin: false,
        }
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Number of the line read last, from 1.
    pub(crate) fn line(&self) -> u64 {
        self.line
    }

    /// Whether the line read last had an end; a recording that was killed has none.
    pub(crate) fn ended(&self) -> bool {
        self.ended
    }

    /// The line read last.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Reads the next line without its end; false at the end of the file.
    pub(crate) fn advance(&mut self) -> Result<bool, LogError> {
        self.bytes.clear();
        self.ended = false;
        loop {
            let chunk = self.input.fill_buf().map_err(|source| LogError::Io {
                name: self.name.clone(),
                source,
            })?;
            if chunk.is_empty() {
                break;
            }
            let end = memchr::memchr(b'\n', chunk);
            let take = end.unwrap_or(chunk.len());
            // The whole line is never held where it is too long to be one.
            if self.bytes.len() + take > MAX_LINE_BYTES {
                return Err(LogError::line(
                    &self.name,
                    self.line + 1,
                    format!("the line has more than {MAX_LINE_BYTES} bytes"),
                    "this is no text log",
                ));
            }
            self.bytes
                .extend_from_slice(chunk.get(..take).unwrap_or_default());
            let used = take + usize::from(end.is_some());
            self.input.consume(used);
            if end.is_some() {
                self.ended = true;
                break;
            }
        }
        if !self.ended && self.bytes.is_empty() {
            return Ok(false);
        }
        self.line += 1;
        while self.bytes.last() == Some(&b'\r') {
            self.bytes.pop();
        }
        if self.line == 1 && self.bytes.starts_with(b"\xef\xbb\xbf") {
            self.bytes.drain(..3);
        }
        if let Some(at) = memchr::memchr(0, &self.bytes) {
            return Err(LogError::line(
                &self.name,
                self.line,
                format!("byte 0x00 at place {} of the line: this is no text", at + 1),
                "export the log as text",
            ));
        }
        self.text.clear();
        match std::str::from_utf8(&self.bytes) {
            Ok(text) => self.text.push_str(text),
            // Older Windows programs write Latin-1: every byte is the character of its number.
            Err(_) => {
                self.latin = true;
                self.text
                    .extend(self.bytes.iter().map(|&byte| char::from(byte)));
            }
        }
        Ok(true)
    }
}

/// How cells are parted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Separator {
    /// One character between two cells.
    Char(char),
    /// Any number of blanks and tabs.
    Blanks,
}

impl Separator {
    /// In words.
    pub(crate) fn shown(self) -> &'static str {
        match self {
            Separator::Char('\t') => "tab",
            Separator::Char(';') => "semicolon",
            Separator::Char(',') => "comma",
            Separator::Char(':') => "colon",
            Separator::Char(' ') | Separator::Blanks => "blank",
            Separator::Char(_) => "other",
        }
    }

    /// What splits lines at this separator.
    pub(crate) fn splitter(self) -> Splitter {
        Splitter {
            separator: self,
            quoted: None,
            bytes: Vec::new(),
            ends: Vec::new(),
        }
    }
}

/// Splits lines into cells; one serves all lines of a log.
pub(crate) struct Splitter {
    separator: Separator,
    /// Reads lines with quotes, once there was one. Its tables take longer to build than a line takes
    /// to read.
    quoted: Option<Box<csv_core::Reader>>,
    /// Cells of a line with quotes, one behind the other.
    bytes: Vec<u8>,
    /// Where each of them ends.
    ends: Vec<usize>,
}

impl Splitter {
    /// The cells of a line, without blanks around them. Quoted cells (RFC 4180) may hold the
    /// separator.
    pub(crate) fn split<'a>(&mut self, line: &'a str, cells: &mut Vec<Cow<'a, str>>) {
        cells.clear();
        match self.separator {
            Separator::Blanks => cells.extend(line.split_whitespace().map(Into::into)),
            Separator::Char(separator) if separator.is_ascii() && line.contains('"') => {
                let reader = self.quoted.get_or_insert_with(|| {
                    let mut builder = csv_core::ReaderBuilder::new();
                    Box::new(builder.delimiter(separator as u8).build())
                });
                // Cells are never longer than their line, and never more than its bytes and one.
                self.bytes.resize(line.len() + 1, 0);
                self.ends.resize(line.len() + 2, 0);
                reader.reset();
                let (bytes, ends) = (&mut self.bytes, &mut self.ends);
                let (_, _, filled, count) = reader.read_record(line.as_bytes(), bytes, ends);
                // Nothing more to read: the end of the last cell.
                let (bytes, ends) = (
                    bytes.get_mut(filled..).unwrap_or_default(),
                    ends.get_mut(count..).unwrap_or_default(),
                );
                let (_, _, _, last) = reader.read_record(&[], bytes, ends);
                let mut start = 0;
                for &end in self.ends.iter().take(count + last) {
                    let cell = self.bytes.get(start..end).unwrap_or_default();
                    let cell = String::from_utf8_lossy(cell);
                    cells.push(cell.trim().to_owned().into());
                    start = end;
                }
            }
            Separator::Char(separator) => {
                cells.extend(line.split(separator).map(|cell| cell.trim().into()));
            }
        }
    }
}

/// Largest size of a number in a log. A choice: counters of 64 bits are far below, and sums of its squares
/// are finite.
const MOST: f64 = 1e30;

/// Whether a number can have been measured: not `inf`, `nan` or 1e300.
pub(crate) fn is_measured(value: f64) -> bool {
    value.abs() <= MOST
}

/// A number with this decimal mark that can have been measured; `inf` and `nan` are none.
pub(crate) fn number(cell: &str, decimal: char) -> Option<f64> {
    let cell = cell.trim();
    let value: f64 = if decimal == ',' && cell.contains(',') {
        if cell.contains('.') {
            return None;
        }
        cell.replacen(',', ".", 1).parse().ok()?
    } else {
        cell.parse().ok()?
    };
    // Rust reads the words `inf` and `nan` as numbers, too.
    is_measured(value).then_some(value)
}

/// Why a cell is no number, for a message.
pub(crate) fn no_number(cell: &str, decimal: char) -> (&'static str, &'static str) {
    if cell.is_empty() {
        return ("is empty", "every row needs a number here");
    }
    match cell.parse::<f64>() {
        Ok(value) if !value.is_finite() => (
            "is not a finite number",
            "remove the row, or the channel from the log",
        ),
        Ok(value) if !is_measured(value) => (
            "is larger than anything measured (1e30)",
            "remove the row, or the channel from the log",
        ),
        _ if decimal == '.' && cell.contains(',') => (
            "is not a number with the decimal mark `.` of the other rows",
            "export the log with one decimal mark",
        ),
        _ => ("is not a number", "every row needs a number here"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_their_numbers_and_ends() {
        let mut lines = Lines::new(&b"\xef\xbb\xbfa\r\nb\xb5\n\nlast"[..], "f");
        let mut seen = Vec::new();
        while lines.advance().unwrap() {
            seen.push((lines.line(), lines.text().to_owned(), lines.ended()));
        }
        let expected = [
            (1, "a", true),
            (2, "bµ", true),
            (3, "", true),
            (4, "last", false),
        ];
        let expected = expected.map(|(line, text, ended)| (line, text.to_owned(), ended));
        assert_eq!(seen, expected);
        assert!(lines.latin);
    }

    #[test]
    fn long_lines_and_zero_bytes_are_refused() {
        let long = vec![b'1'; MAX_LINE_BYTES + 1];
        assert!(Lines::new(&long[..], "f").advance().is_err());
        let error = Lines::new(&b"1 2\n3 \0"[..], "f");
        let mut error = error;
        assert!(error.advance().unwrap());
        assert!(
            error
                .advance()
                .unwrap_err()
                .to_string()
                .contains("line 2: byte 0x00 at place 3")
        );
    }

    #[test]
    fn numbers_have_one_decimal_mark() {
        assert_eq!(number("+7,92", ','), Some(7.92));
        assert_eq!(number(" -2.9e-001 ", '.'), Some(-0.29));
        assert_eq!(number("7", ','), Some(7.0));
        for bad in ["1,2", "nan", "inf", "", "1.2.3", "0x10"] {
            assert_eq!(number(bad, '.'), None, "{bad}");
        }
        assert_eq!(number("1.234,5", ','), None);
    }

    #[test]
    fn quoted_cells_hold_the_separator() {
        let mut cells = Vec::new();
        let mut splitter = Separator::Char(',').splitter();
        let table: &[(&str, &[&str])] = &[
            ("\"a, b\",2, 3", &["a, b", "2", "3"]),
            ("\"a \"\"b\"\"\", µ ,", &["a \"b\"", "µ", ""]),
            // Not closed: the rest of the line.
            ("1,\"2,3", &["1", "2,3"]),
            ("1,2", &["1", "2"]),
            ("\"\"", &[""]),
        ];
        for (line, expected) in table {
            splitter.split(line, &mut cells);
            assert_eq!(cells, *expected, "{line}");
        }
    }
}
