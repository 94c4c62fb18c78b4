//! Errors block by block.

use crate::worst::Worst;
use crate::{Cause, ContourSample, Shares};
use lostmotion_base::{BlockRef, Tick};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One sample with everything that is known about its error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorRecord {
    /// What the tracker measured.
    pub sample: ContourSample,
    /// Parts of its error.
    pub shares: Shares,
    /// What makes most of it.
    pub cause: Cause,
    /// Commanded tip from the program's zero, mm.
    pub commanded_tip_mm: [f64; 3],
}

/// The errors of one programmed segment: of all samples whose foot point lies on it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlockRow {
    /// Running number of the segment.
    pub segment: u64,
    /// Block that commanded it.
    pub block: BlockRef,
    /// Whether it is a G0 move.
    pub rapid: bool,
    /// First tick with its foot point on it.
    pub first_tick: Tick,
    /// Number of samples.
    pub samples: u64,
    /// Sum of squared errors, mm2.
    pub sum_of_squares_mm2: f64,
    /// Sum of squared backlash shares, mm2.
    pub backlash_sum_of_squares_mm2: f64,
    /// Largest orientation error, rad.
    pub max_orientation_rad: f64,
    /// The sample with the largest error.
    pub worst: ErrorRecord,
}

impl BlockRow {
    fn open(record: &ErrorRecord) -> BlockRow {
        BlockRow {
            segment: record.sample.segment,
            block: record.sample.block,
            rapid: record.sample.rapid,
            first_tick: record.sample.tick,
            samples: 0,
            sum_of_squares_mm2: 0.0,
            backlash_sum_of_squares_mm2: 0.0,
            max_orientation_rad: 0.0,
            worst: *record,
        }
    }

    fn add(&mut self, record: &ErrorRecord) {
        let error = record.sample.error_mm;
        self.samples += 1;
        self.sum_of_squares_mm2 += error * error;
        self.backlash_sum_of_squares_mm2 += record.shares.backlash_mm * record.shares.backlash_mm;
        self.max_orientation_rad = self
            .max_orientation_rad
            .max(record.sample.orientation_error_rad);
        if error.abs() > self.worst.sample.error_mm.abs() {
            self.worst = *record;
        }
    }

    /// Largest error with its sign, mm.
    pub const fn max_mm(&self) -> f64 {
        self.worst.sample.error_mm
    }

    /// Root mean square error, mm.
    pub fn rms_mm(&self) -> f64 {
        (self.sum_of_squares_mm2 / self.samples.max(1) as f64).sqrt()
    }

    /// Root mean square of what backlash adds, mm.
    pub fn backlash_rms_mm(&self) -> f64 {
        (self.backlash_sum_of_squares_mm2 / self.samples.max(1) as f64).sqrt()
    }
}

/// Errors block by block: rows of finished blocks are handed out, the worst are kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlockLedger {
    open: BTreeMap<u64, BlockRow>,
    worst: Worst<BlockRow>,
    worst_rapids: Worst<BlockRow>,
}

impl BlockLedger {
    /// A ledger that keeps the given number of worst rows of cutting moves, and as many of G0 moves.
    pub fn new(keep: usize) -> BlockLedger {
        BlockLedger {
            open: BTreeMap::new(),
            worst: Worst::new(keep),
            worst_rapids: Worst::new(keep),
        }
    }

    /// Takes a sample.
    pub fn record(&mut self, record: &ErrorRecord) {
        self.open
            .entry(record.sample.segment)
            .or_insert_with(|| BlockRow::open(record))
            .add(record);
    }

    /// Closes and returns the rows of all segments before one: the oldest that the tracker still
    /// holds ([`crate::ContourTracker::release`]).
    #[must_use]
    pub fn finish_before(&mut self, segment: u64) -> Vec<BlockRow> {
        let later = self.open.split_off(&segment);
        self.close(later)
    }

    /// Closes the open rows and returns the ledger's result.
    #[must_use]
    pub fn finish(&mut self) -> Vec<BlockRow> {
        self.close(BTreeMap::new())
    }

    fn close(&mut self, later: BTreeMap<u64, BlockRow>) -> Vec<BlockRow> {
        let rows: Vec<_> = std::mem::replace(&mut self.open, later)
            .into_values()
            .collect();
        for row in &rows {
            let kind = if row.rapid {
                &mut self.worst_rapids
            } else {
                &mut self.worst
            };
            kind.offer(row.max_mm().abs(), *row);
        }
        rows
    }

    /// The finished rows of cutting moves with the largest errors, worst first.
    pub fn worst(&self) -> impl Iterator<Item = &BlockRow> {
        self.worst.iter()
    }

    /// The finished rows of G0 moves with the largest errors, worst first.
    pub fn worst_rapids(&self) -> impl Iterator<Item = &BlockRow> {
        self.worst_rapids.iter()
    }
}
