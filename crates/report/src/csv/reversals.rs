//! Reversals: a row each.

use super::rows::{ERROR_DECIMALS, Rows};
use lostmotion_sim::results::ReversalResult;
use std::io::{self, Write};

const COLUMNS: [&str; 9] = [
    "method",
    "axis",
    "direction",
    "file",
    "line",
    "rapid",
    "time_s",
    "peak_um",
    "backlash_um",
];

/// Writes the fields of [`ReversalResult`] with the method's name before them.
#[derive(Debug)]
pub struct ReversalWriter<W> {
    rows: Rows<W>,
}

impl<W: Write> ReversalWriter<W> {
    /// Starts the table.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn new(out: W) -> io::Result<ReversalWriter<W>> {
        Ok(ReversalWriter {
            rows: Rows::new(out, COLUMNS)?,
        })
    }

    /// Appends rows.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn push(&mut self, method: &str, reversals: &[ReversalResult]) -> io::Result<()> {
        for reversal in reversals {
            let rows = &mut self.rows;
            rows.text(method);
            rows.text(&reversal.axis.letter().to_string());
            rows.signed(reversal.direction);
            rows.integer(u64::from(reversal.block.span.file));
            rows.integer(u64::from(reversal.block.span.line));
            rows.integer(u64::from(reversal.rapid));
            rows.number(reversal.time_s, 6);
            rows.number(reversal.peak_um, ERROR_DECIMALS);
            rows.number(reversal.backlash_um, ERROR_DECIMALS);
            rows.end()?;
        }
        Ok(())
    }

    /// Writes what is left and gives the writer back.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(self) -> io::Result<W> {
        self.rows.finish()
    }
}
