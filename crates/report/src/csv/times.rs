//! Times of blocks: a row each time a block runs.

use super::rows::Rows;
use lostmotion_sim::time::results::{BlockTime, TimeKind};
use std::io::{self, Write};

const COLUMNS: [&str; 8] = [
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
            rows: Rows::new(out, COLUMNS)?,
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
