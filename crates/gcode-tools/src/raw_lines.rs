//! Lines with their terminators, as they are.

use std::io::{self, BufRead};

/// A line and what ended it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct RawLine {
    pub(crate) text: Vec<u8>,
    /// LF, CR LF, CR, or nothing at the end of the file.
    pub(crate) end: &'static [u8],
}

/// Reads the next line into `line`, whose buffer is reused; false at the end.
///
/// # Errors
/// Those of the reader.
pub(crate) fn read_line(reader: &mut impl BufRead, line: &mut RawLine) -> io::Result<bool> {
    line.text.clear();
    line.end = b"";
    loop {
        let buffer = reader.fill_buf()?;
        if buffer.is_empty() {
            return Ok(!line.text.is_empty());
        }
        // A line may span several fills of the buffer.
        let at = buffer.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        let piece = buffer.get(..at.unwrap_or(buffer.len())).unwrap_or_default();
        line.text.extend_from_slice(piece);
        let terminator = at.and_then(|at| buffer.get(at)).copied();
        let used = piece.len() + usize::from(terminator.is_some());
        reader.consume(used);
        match terminator {
            None => {}
            Some(b'\n') => {
                line.end = b"\n";
                return Ok(true);
            }
            Some(_) => {
                // CR LF may be cut by the buffer's end: refill before looking at the next byte.
                let pair = reader.fill_buf()?.first() == Some(&b'\n');
                if pair {
                    reader.consume(1);
                }
                line.end = if pair { b"\r\n" } else { b"\r" };
                return Ok(true);
            }
        }
    }
}
