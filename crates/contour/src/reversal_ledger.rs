//! Errors reversal by reversal.

use crate::worst::Worst;
use crate::{ErrorRecord, Reversal, Shares};
use lostmotion_base::{AXES, BlockRef, Tick};
use serde::{Deserialize, Serialize};

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
    /// Largest share of backlash in the window, with its sign, mm.
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
    /// One that watches so many ticks after each reversal, or until the axis reverses again, and
    /// keeps so many worst rows.
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

    /// Takes a sample and returns the rows whose windows it has passed, in axis order.
    #[must_use]
    pub fn record(&mut self, record: &ErrorRecord) -> Vec<ReversalRow> {
        let tick = record.sample.tick;
        let mut finished = Vec::new();
        for axis in 0..AXES {
            let Some(row) = self.open.get_mut(axis).and_then(Option::as_mut) else {
                continue;
            };
            if tick.saturating_sub(row.reversal.tick) > self.window_ticks {
                finished.extend(self.close(axis));
                continue;
            }
            if record.sample.error_mm.abs() > row.peak_mm.abs() {
                (row.peak_mm, row.peak_tick, row.peak_shares) =
                    (record.sample.error_mm, tick, record.shares);
            }
            if record.shares.backlash_mm.abs() > row.peak_backlash_mm.abs() {
                row.peak_backlash_mm = record.shares.backlash_mm;
            }
        }
        finished
    }

    /// Closes and returns what is left.
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
