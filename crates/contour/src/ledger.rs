//! Errors block by block and reversal by reversal, the worst of each kept.

use crate::{Cause, ContourSample, Reversal, Shares};
use lostmotion_base::{AXES, BlockRef, Tick};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One sample with everything that is known about its error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorRecord {
    /// The measured sample.
    pub sample: ContourSample,
    /// Parts of its error.
    pub shares: Shares,
    /// Cause of its largest part.
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
    /// Sum of squared lengths of what backlash adds, mm2.
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
        self.backlash_sum_of_squares_mm2 +=
            record.shares.backlash_size_mm * record.shares.backlash_size_mm;
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
    /// A ledger that keeps the given number of worst rows of cutting moves, and as many of G0
    /// moves.
    pub fn new(keep: usize) -> BlockLedger {
        BlockLedger {
            open: BTreeMap::new(),
            worst: Worst::new(keep),
            worst_rapids: Worst::new(keep),
        }
    }

    /// Adds a sample.
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
        // Rows are in order of segments: the later ones stay open.
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
            // G0 moves apart: their errors leave no mark on the part, and would crowd out those
            // that do.
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

/// One reversal and the errors in the window after it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReversalRow {
    /// Axis, tick and direction.
    pub reversal: Reversal,
    /// Programmed segment on which the command was.
    pub segment: u64,
    /// Its block.
    pub block: BlockRef,
    /// Whether it is a G0 move.
    pub rapid: bool,
    /// Largest error in the window, with its sign, mm.
    pub peak_mm: f64,
    /// When.
    pub peak_tick: Tick,
    /// Parts of that error.
    pub peak_shares: Shares,
    /// Largest length of what backlash adds in the window, mm.
    pub peak_backlash_mm: f64,
}

/// Errors reversal by reversal: finished rows are handed out, the worst are kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReversalLedger {
    window_ticks: Tick,
    open: [Option<ReversalRow>; AXES],
    worst: Worst<ReversalRow>,
    counts: [u64; AXES],
}

impl ReversalLedger {
    /// A ledger that watches `window_ticks` after each reversal, or until the axis reverses again,
    /// and keeps the `keep` worst rows.
    pub fn new(window_ticks: Tick, keep: usize) -> ReversalLedger {
        ReversalLedger {
            window_ticks,
            open: [None; AXES],
            worst: Worst::new(keep),
            counts: [0; AXES],
        }
    }

    /// Opens a row, and returns the one of the axis' reversal before it, if its window was still
    /// open.
    #[must_use]
    pub fn open(
        &mut self,
        reversal: Reversal,
        segment: u64,
        block: BlockRef,
        rapid: bool,
    ) -> Option<ReversalRow> {
        let axis = reversal.axis.index();
        // A new reversal ends the window of the one before.
        let before = self.close(axis);
        if let (Some(open), Some(count)) = (self.open.get_mut(axis), self.counts.get_mut(axis)) {
            *count += 1;
            *open = Some(ReversalRow {
                reversal,
                segment,
                block,
                rapid,
                peak_mm: 0.0,
                peak_tick: reversal.tick,
                peak_shares: Shares::default(),
                peak_backlash_mm: 0.0,
            });
        }
        before
    }

    /// Adds a sample and returns the rows whose windows have passed, in axis order.
    #[must_use]
    pub fn record(&mut self, record: &ErrorRecord) -> Vec<ReversalRow> {
        let tick = record.sample.tick;
        let mut finished = Vec::new();
        for axis in 0..AXES {
            let Some(row) = self.open.get_mut(axis).and_then(Option::as_mut) else {
                continue;
            };
            // Past the window: the row is finished, and this sample is not part of it.
            if tick.saturating_sub(row.reversal.tick) > self.window_ticks {
                finished.extend(self.close(axis));
                continue;
            }
            // The peak of the error and that of its backlash share, which may be at different
            // ticks.
            if record.sample.error_mm.abs() > row.peak_mm.abs() {
                (row.peak_mm, row.peak_tick, row.peak_shares) =
                    (record.sample.error_mm, tick, record.shares);
            }
            row.peak_backlash_mm = row.peak_backlash_mm.max(record.shares.backlash_size_mm);
        }
        finished
    }

    /// Closes and returns the rows that are still open.
    #[must_use]
    pub fn finish(&mut self) -> Vec<ReversalRow> {
        (0..AXES).filter_map(|axis| self.close(axis)).collect()
    }

    fn close(&mut self, axis: usize) -> Option<ReversalRow> {
        let row = self.open.get_mut(axis)?.take()?;
        self.worst.offer(row.peak_mm.abs(), row);
        Some(row)
    }

    /// The finished rows with the largest errors, worst first.
    pub fn worst(&self) -> impl Iterator<Item = &ReversalRow> {
        self.worst.iter()
    }

    /// Reversals so far of each axis, by its index.
    pub const fn counts(&self) -> [u64; AXES] {
        self.counts
    }
}

/// Keeps the `keep` items of largest size, largest first; of equal ones those that came first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Worst<T> {
    keep: usize,
    items: Vec<(f64, T)>,
}

impl<T> Worst<T> {
    fn new(keep: usize) -> Worst<T> {
        Worst {
            keep,
            items: Vec::new(),
        }
    }

    fn offer(&mut self, size: f64, item: T) {
        // Behind those of equal size, which came first.
        let at = self.items.partition_point(|(other, _)| *other >= size);
        if at < self.keep {
            self.items.insert(at, (size, item));
            self.items.truncate(self.keep);
        }
    }

    fn iter(&self) -> impl Iterator<Item = &T> {
        self.items.iter().map(|(_, item)| item)
    }
}
