//! Tables of results: blocks, reversals, times of blocks; a row each.

use super::rows::{ERROR_DECIMALS, Rows};
use lostmotion_sim::results::{BlockResult, Cause, ReversalResult};
use lostmotion_sim::time::results::{BlockTime, TimeKind};
use std::io::{self, Write};

/// Columns of [`BlockWriter`].
const BLOCK_COLUMNS: [&str; 15] = [
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
            rows: Rows::new(out, BLOCK_COLUMNS)?,
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
            // File 0 is the program, n the nth subroutine file of the JSON.
            rows.integer(u64::from(block.block.span.file));
            rows.integer(u64::from(block.block.span.line));
            // Truth values as 0 and 1, which any program can add up.
            rows.integer(u64::from(block.rapid));
            // Times to 1 us and places to 1 nm: finer than a servo tick, and than any axis can go.
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

/// Columns of [`ReversalWriter`].
const REVERSAL_COLUMNS: [&str; 9] = [
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
            rows: Rows::new(out, REVERSAL_COLUMNS)?,
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
            // The direction after the reversal.
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

/// Columns of [`TimeWriter`].
const TIME_COLUMNS: [&str; 8] = [
    "segment",
    "file",
    "line",
    "kind",
    "start_s",
    "time_s",
    "limit",
    "limit_share",
];

/// Writes how long each block takes and what limits it most.
#[derive(Debug)]
pub struct TimeWriter<W> {
    rows: Rows<W>,
}

impl<W: Write> TimeWriter<W> {
    /// Starts the table.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn new(out: W) -> io::Result<TimeWriter<W>> {
        Ok(TimeWriter {
            rows: Rows::new(out, TIME_COLUMNS)?,
        })
    }

    /// Appends rows.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn push(&mut self, blocks: &[BlockTime]) -> io::Result<()> {
        for block in blocks {
            let rows = &mut self.rows;
            rows.integer(block.segment);
            rows.integer(u64::from(block.block.span.file));
            rows.integer(u64::from(block.block.span.line));
            rows.text(match block.kind {
                TimeKind::Cutting => "cutting",
                TimeKind::Rapid => "rapid",
                TimeKind::Dwell => "dwell",
            });
            // The limits are sorted: the first holds the block up longest, and is the one worth a
            // cell.
            rows.number(block.start_s, 6);
            rows.number(block.time_s, 6);
            rows.text(
                block
                    .limits
                    .first()
                    .map_or("", |limit| limit.limit.as_str()),
            );
            rows.number(block.limits.first().map_or(0.0, |limit| limit.share), 4);
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
