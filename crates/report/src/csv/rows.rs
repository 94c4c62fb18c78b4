//! Rows into a writer, in blocks.

use crate::number::{push_fixed, push_integer, push_seconds};
use std::io::{self, Write};

/// Bytes collected before they go to the writer: few calls, little memory. A choice.
const BLOCK_BYTES: usize = 1 << 16;

/// Decimals of positions: 1e-12 mm, so that a third difference over 1 ms still means something.
pub(super) const POSITION_DECIMALS: usize = 12;
/// Decimals of velocities, accelerations, currents and torques: far below what any is known to.
pub(super) const RATE_DECIMALS: usize = 9;
/// Decimals of errors in um: 0.1 nm.
pub(super) const ERROR_DECIMALS: usize = 4;

/// What stands in a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnKind {
    /// Text that repeats often, as a method's name.
    Text,
    /// A number; nothing where it is not finite.
    Number,
    /// A whole number.
    Integer,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TableColumn {
    /// Its name, with the unit.
    pub name: String,
    /// What stands in it.
    pub kind: ColumnKind,
}

impl TableColumn {
    /// A column.
    pub fn new(name: impl Into<String>, kind: ColumnKind) -> TableColumn {
        TableColumn {
            name: name.into(),
            kind,
        }
    }
}

/// Columns from their names and kinds.
pub(super) fn columns<const N: usize>(named: [(&str, ColumnKind); N]) -> Vec<TableColumn> {
    named
        .map(|(name, kind)| TableColumn::new(name, kind))
        .to_vec()
}

/// A table that takes its rows cell by cell, whatever its form. Private to this crate: cells have to
/// come in the order of the columns.
pub trait TableCells: Sized {
    /// What it writes to.
    type Out;

    /// Starts a table with these columns.
    #[doc(hidden)]
    fn start(out: Self::Out, columns: &[TableColumn]) -> io::Result<Self>;
    #[doc(hidden)]
    fn text(&mut self, text: &str);
    #[doc(hidden)]
    fn number(&mut self, value: f64, decimals: usize);
    /// A number with as many digits as tell it from all others.
    #[doc(hidden)]
    fn exact(&mut self, value: f64) {
        self.number(value, usize::MAX);
    }
    #[doc(hidden)]
    fn integer(&mut self, value: i64);
    /// The time `tick * period_ns` in s.
    #[doc(hidden)]
    fn seconds(&mut self, tick: u64, period_ns: u64) {
        // An integer of nanoseconds over 1e9 is the number nearest to the decimal fraction.
        self.number(tick.saturating_mul(period_ns) as f64 / 1e9, 9);
    }
    #[doc(hidden)]
    fn end(&mut self) -> io::Result<()>;
    /// Writes what is left and gives the writer back.
    #[doc(hidden)]
    fn finish(self) -> io::Result<Self::Out>;
}

impl<W: Write> TableCells for Rows<W> {
    type Out = W;

    fn start(out: W, columns: &[TableColumn]) -> io::Result<Rows<W>> {
        Rows::new(out, columns.iter().map(|column| column.name.as_str()))
    }

    fn text(&mut self, text: &str) {
        Rows::text(self, text);
    }

    fn number(&mut self, value: f64, decimals: usize) {
        Rows::number(self, value, decimals);
    }

    fn exact(&mut self, value: f64) {
        self.comma();
        if value.is_finite() {
            // The shortest decimal that reads back to the same number; into memory it cannot fail.
            let _ = write!(self.buffer, "{value}");
        }
    }

    fn integer(&mut self, value: i64) {
        self.comma();
        if value < 0 {
            self.buffer.push(b'-');
        }
        push_integer(&mut self.buffer, value.unsigned_abs());
    }

    fn seconds(&mut self, tick: u64, period_ns: u64) {
        self.comma();
        push_seconds(&mut self.buffer, tick.saturating_mul(period_ns), period_ns);
    }

    fn end(&mut self) -> io::Result<()> {
        Rows::end(self)
    }

    fn finish(self) -> io::Result<W> {
        Rows::finish(self)
    }
}

/// Builds rows cell by cell. TableCells after the first of a row get their comma.
#[derive(Debug)]
pub struct Rows<W> {
    out: W,
    buffer: Vec<u8>,
    row_started: bool,
}

impl<W: Write> Rows<W> {
    /// Starts a table with its header line.
    pub(super) fn new<'a>(
        out: W,
        header: impl IntoIterator<Item = &'a str>,
    ) -> io::Result<Rows<W>> {
        let mut rows = Rows {
            out,
            // With room for the row that fills the block, the buffer never grows.
            buffer: Vec::with_capacity(BLOCK_BYTES + 1024),
            row_started: false,
        };
        for name in header {
            rows.text(name);
        }
        rows.end()?;
        Ok(rows)
    }

    fn comma(&mut self) {
        if self.row_started {
            self.buffer.push(b',');
        }
        self.row_started = true;
    }

    /// A number; empty if it is not finite.
    pub(super) fn number(&mut self, value: f64, decimals: usize) {
        self.comma();
        push_fixed(&mut self.buffer, value, decimals);
    }

    /// Text, quoted where it has to be. Line breaks inside become blanks, so that a row is a line.
    pub(super) fn text(&mut self, text: &str) {
        self.comma();
        if text
            .bytes()
            .any(|b| matches!(b, b',' | b'"' | b'\n' | b'\r'))
        {
            self.buffer.push(b'"');
            for byte in text.bytes() {
                match byte {
                    // RFC 4180: a quote inside quotes is doubled.
                    b'"' => self.buffer.extend_from_slice(b"\"\""),
                    b'\n' | b'\r' => self.buffer.push(b' '),
                    other => self.buffer.push(other),
                }
            }
            self.buffer.push(b'"');
        } else {
            self.buffer.extend_from_slice(text.as_bytes());
        }
    }

    /// Ends the row.
    pub(super) fn end(&mut self) -> io::Result<()> {
        self.buffer.push(b'\n');
        self.row_started = false;
        // Rows go out whole: a reader of the growing file sees no half row but the last.
        if self.buffer.len() >= BLOCK_BYTES {
            self.drain()
        } else {
            Ok(())
        }
    }

    fn drain(&mut self) -> io::Result<()> {
        self.out.write_all(&self.buffer)?;
        self.buffer.clear();
        Ok(())
    }

    /// Writes what is left and gives the writer back.
    pub(super) fn finish(mut self) -> io::Result<W> {
        self.drain()?;
        self.out.flush()?;
        Ok(self.out)
    }
}
