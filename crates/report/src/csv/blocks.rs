//! Blocks: a row a move.

use super::rows::{ERROR_DECIMALS, Rows};
use lostmotion_sim::results::{BlockResult, Cause};
use std::io::{self, Write};

const COLUMNS: [&str; 15] = [
    "method",
    "segment",
    "file",
    "line",
    "rapid",
    "time_s",
    "max_um",
    "rms_um",
    "command_um",
    "servo_um",
    "backlash_um",
    "cause",
    "x_mm",
    "y_mm",
    "z_mm",
];

/// Name of a cause in a cell: `reversal-x`, `gap`, `blend`, `corner`, `servo-lag`.
fn cause(cause: Cause) -> String {
    match cause {
        Cause::Reversal(axis) => format!("reversal-{}", axis.letter().to_ascii_lowercase()),
        Cause::Gap => "gap".to_owned(),
        Cause::Blend => "blend".to_owned(),
        Cause::Corner => "corner".to_owned(),
        Cause::ServoLag => "servo-lag".to_owned(),
    }
}

/// Writes how far the tool left each block: the fields of [`BlockResult`] with the method's name
/// before them and without the block's text, which stands in the program.
#[derive(Debug)]
pub struct BlockWriter<W> {
    rows: Rows<W>,
}

impl<W: Write> BlockWriter<W> {
    /// Starts the table.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn new(out: W) -> io::Result<BlockWriter<W>> {
        Ok(BlockWriter {
            rows: Rows::new(out, COLUMNS)?,
        })
    }

    /// Appends rows.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn push(&mut self, method: &str, blocks: &[BlockResult]) -> io::Result<()> {
        for block in blocks {
            let rows = &mut self.rows;
            rows.text(method);
            rows.integer(block.segment);
            rows.integer(u64::from(block.block.span.file));
            rows.integer(u64::from(block.block.span.line));
            rows.integer(u64::from(block.rapid));
            rows.number(block.time_s, 6);
            let parts = block.parts_um;
            for error in [
                block.max_um,
                block.rms_um,
                parts.command,
                parts.servo,
                parts.backlash,
            ] {
                rows.number(error, ERROR_DECIMALS);
            }
            rows.text(&cause(block.cause));
            for coordinate in block.at_mm {
                rows.number(coordinate, 6);
            }
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
