//! Tables of results: blocks, reversals, times of blocks, contour errors; a row each.

use super::rows::{ERROR_DECIMALS, Rows};
use lostmotion_sim::ContourPoint;
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

/// Columns of [`ContourWriter`].
const CONTOUR_COLUMNS: [&str; 20] = [
    "method",
    "t_s",
    "foot_x_mm",
    "foot_y_mm",
    "foot_z_mm",
    "normal_x",
    "normal_y",
    "normal_z",
    "error_um",
    "backlash_um",
    "rapid",
    "file",
    "line",
    "commanded_x_mm",
    "commanded_y_mm",
    "commanded_z_mm",
    "tool_x_mm",
    "tool_y_mm",
    "tool_z_mm",
    "moving",
];

/// Writes the fields of [`ContourPoint`] with the method's name before them.
#[derive(Debug)]
pub struct ContourWriter<W> {
    rows: Rows<W>,
}

impl<W: Write> ContourWriter<W> {
    /// Starts the table.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn new(out: W) -> io::Result<ContourWriter<W>> {
        Ok(ContourWriter {
            rows: Rows::new(out, CONTOUR_COLUMNS)?,
        })
    }

    /// Appends rows.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn push(&mut self, method: &str, points: &[ContourPoint]) -> io::Result<()> {
        for point in points {
            let rows = &mut self.rows;
            rows.text(method);
            rows.number(point.time_s, 6);
            for coordinate in point.foot_mm {
                rows.number(coordinate, 6);
            }
            // The error counts positive along this normal: both are needed to draw where the tool
            // was.
            for component in point.normal {
                rows.number(component, 6);
            }
            rows.number(point.error_um, ERROR_DECIMALS);
            rows.number(point.backlash_um, ERROR_DECIMALS);
            // Rapids are in the table, too: sums over cutting moves leave them out by this column.
            rows.integer(u64::from(point.rapid));
            rows.integer(u64::from(point.block.span.file));
            rows.integer(u64::from(point.block.span.line));
            // Where the tool should be and where it is: the foot point and the error along the normal
            // do not tell in space, nor at a corner.
            for coordinate in point.commanded_mm.into_iter().chain(point.actual_mm) {
                rows.number(coordinate, 6);
            }
            rows.integer(u64::from(point.moving));
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
