//! Tables of results: blocks, reversals, times of blocks; a row each.

use super::rows::{ColumnKind, ERROR_DECIMALS, Rows, TableCells, columns};
use lostmotion_sim::results::{BlockResult, Cause, ReversalResult};
use lostmotion_sim::time::results::{BlockTime, TimeKind};
use std::io::{self, Write};

use ColumnKind::{Integer, Number, Text};

/// A count, as cells take it.
fn whole(count: u64) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}

/// Columns of [`BlockWriter`].
const BLOCK_COLUMNS: [(&str, ColumnKind); 15] = [
    ("method", Text),
    ("segment", Integer),
    ("file", Integer),
    ("line", Integer),
    ("rapid", Integer),
    ("time_s", Number),
    ("max_um", Number),
    ("rms_um", Number),
    ("command_um", Number),
    ("servo_um", Number),
    ("backlash_um", Number),
    ("cause", Text),
    ("x_mm", Number),
    ("y_mm", Number),
    ("z_mm", Number),
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
pub struct BlockWriter<T> {
    rows: T,
}

impl<W: Write> BlockWriter<Rows<W>> {
    /// Starts the table.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn new(out: W) -> io::Result<BlockWriter<Rows<W>>> {
        BlockWriter::start(out)
    }
}

impl<T: TableCells> BlockWriter<T> {
    /// Starts the table in its form.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn start(out: T::Out) -> io::Result<BlockWriter<T>> {
        Ok(BlockWriter {
            rows: T::start(out, &columns(BLOCK_COLUMNS))?,
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
            rows.integer(whole(block.segment));
            // File 0 is the program, n the nth subroutine file of the JSON.
            rows.integer(i64::from(block.block.span.file));
            rows.integer(i64::from(block.block.span.line));
            // Truth values as 0 and 1, which any program can add up.
            rows.integer(i64::from(block.rapid));
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
    pub fn finish(self) -> io::Result<T::Out> {
        self.rows.finish()
    }
}

/// Columns of [`ReversalWriter`].
const REVERSAL_COLUMNS: [(&str, ColumnKind); 9] = [
    ("method", Text),
    ("axis", Text),
    ("direction", Integer),
    ("file", Integer),
    ("line", Integer),
    ("rapid", Integer),
    ("time_s", Number),
    ("peak_um", Number),
    ("backlash_um", Number),
];

/// Writes the fields of [`ReversalResult`] with the method's name before them.
#[derive(Debug)]
pub struct ReversalWriter<T> {
    rows: T,
}

impl<W: Write> ReversalWriter<Rows<W>> {
    /// Starts the table.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn new(out: W) -> io::Result<ReversalWriter<Rows<W>>> {
        ReversalWriter::start(out)
    }
}

impl<T: TableCells> ReversalWriter<T> {
    /// Starts the table in its form.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn start(out: T::Out) -> io::Result<ReversalWriter<T>> {
        Ok(ReversalWriter {
            rows: T::start(out, &columns(REVERSAL_COLUMNS))?,
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
            rows.integer(i64::from(reversal.direction));
            rows.integer(i64::from(reversal.block.span.file));
            rows.integer(i64::from(reversal.block.span.line));
            rows.integer(i64::from(reversal.rapid));
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
    pub fn finish(self) -> io::Result<T::Out> {
        self.rows.finish()
    }
}

/// Columns of [`TimeWriter`].
const TIME_COLUMNS: [(&str, ColumnKind); 8] = [
    ("segment", Integer),
    ("file", Integer),
    ("line", Integer),
    ("kind", Text),
    ("start_s", Number),
    ("time_s", Number),
    ("limit", Text),
    ("limit_share", Number),
];

/// Writes how long each block takes and what limits it most.
#[derive(Debug)]
pub struct TimeWriter<T> {
    rows: T,
}

impl<W: Write> TimeWriter<Rows<W>> {
    /// Starts the table.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn new(out: W) -> io::Result<TimeWriter<Rows<W>>> {
        TimeWriter::start(out)
    }
}

impl<T: TableCells> TimeWriter<T> {
    /// Starts the table in its form.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn start(out: T::Out) -> io::Result<TimeWriter<T>> {
        Ok(TimeWriter {
            rows: T::start(out, &columns(TIME_COLUMNS))?,
        })
    }

    /// Appends rows.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn push(&mut self, blocks: &[BlockTime]) -> io::Result<()> {
        for block in blocks {
            let rows = &mut self.rows;
            rows.integer(whole(block.segment));
            rows.integer(i64::from(block.block.span.file));
            rows.integer(i64::from(block.block.span.line));
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
    pub fn finish(self) -> io::Result<T::Out> {
        self.rows.finish()
    }
}
