//! Time added up: for the program, by kind, and block by block in bounded memory.

use super::results::{BlockTime, LimitShare, TimeKind};
use crate::limiter::{Interval, Limiter};
use lostmotion_base::{BlockRef, Clock, Tick};

/// Ticks by limiter.
pub(super) type Counts = [Tick; Limiter::COUNT];

/// One block on its way.
#[derive(Clone, Debug)]
struct Open {
    block: BlockRef,
    kind: TimeKind,
    segment: u64,
    start: Tick,
    ticks: Tick,
    counts: Counts,
}

/// Takes intervals in their order.
#[derive(Debug)]
pub(super) struct Ledger {
    clock: Clock,
    keep: usize,
    open: Option<Open>,
    now: Tick,
    /// Blocks that took longest, longest first; the earlier one first among equals.
    kept: Vec<Open>,
    finished: Vec<Open>,
    pub(super) count: u64,
    pub(super) counts: Counts,
    pub(super) kinds: [Tick; 3],
}

impl Ledger {
    pub(super) fn new(clock: Clock, keep: usize) -> Ledger {
        Ledger {
            clock,
            keep,
            open: None,
            now: 0,
            kept: Vec::new(),
            finished: Vec::new(),
            count: 0,
            counts: [0; Limiter::COUNT],
            kinds: [0; 3],
        }
    }

    /// Ticks taken so far.
    pub(super) fn ticks(&self) -> Tick {
        self.now
    }

    /// Takes the time between two samples.
    pub(super) fn add(&mut self, interval: &Interval) {
        let Interval { block, segment, .. } = *interval;
        let kind = match interval.limiter {
            Limiter::Dwell => TimeKind::Dwell,
            _ if interval.rapid => TimeKind::Rapid,
            _ => TimeKind::Cutting,
        };
        let limiter = interval.limiter.index();
        self.counts[limiter] += 1;
        self.kinds[kind as usize] += 1;
        if !self
            .open
            .as_ref()
            .is_some_and(|open| open.block == block && open.kind == kind)
        {
            // A block that runs again (a loop, a subroutine) after another one has a row of its
            // own.
            self.close();
            self.open = Some(Open {
                block,
                kind,
                segment,
                start: self.now,
                ticks: 0,
                counts: [0; Limiter::COUNT],
            });
        }
        if let Some(open) = &mut self.open {
            open.ticks += 1;
            open.counts[limiter] += 1;
        }
        self.now += 1;
    }

    /// Ends the block on its way.
    pub(super) fn close(&mut self) {
        let Some(open) = self.open.take() else { return };
        self.count += 1;
        // Insertion into the sorted list of the longest, which is bounded.
        let place = self.kept.partition_point(|kept| kept.ticks >= open.ticks);
        if place < self.keep {
            self.kept.insert(place, open.clone());
            self.kept.truncate(self.keep);
        }
        self.finished.push(open);
    }

    /// Rows of the blocks that ended since the last call.
    pub(super) fn take_finished(&mut self) -> Vec<BlockTime> {
        let finished = std::mem::take(&mut self.finished);
        finished.iter().map(|open| self.row(open)).collect()
    }

    /// Rows of the blocks that took longest.
    pub(super) fn longest(&self) -> Vec<BlockTime> {
        self.kept.iter().map(|open| self.row(open)).collect()
    }

    fn row(&self, open: &Open) -> BlockTime {
        BlockTime {
            block: open.block,
            text: String::new(),
            segment: open.segment,
            kind: open.kind,
            start_s: self.clock.seconds(open.start),
            time_s: self.clock.seconds(open.ticks),
            limits: shares(&open.counts, open.ticks, self.clock),
        }
    }
}

/// Shares of a number of ticks, longest first.
pub(super) fn shares(counts: &Counts, ticks: Tick, clock: Clock) -> Vec<LimitShare> {
    let every = Limiter::ALL.into_iter().zip(counts.iter().copied());
    let mut used: Vec<(Limiter, Tick)> = every.filter(|(_, count)| *count > 0).collect();
    // The sort is stable: ties stay in the order of the limiters.
    used.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let share = |(limiter, count): (Limiter, Tick)| LimitShare {
        limit: limiter.to_string(),
        time_s: clock.seconds(count),
        share: count as f64 / ticks.max(1) as f64,
    };
    used.into_iter().map(share).collect()
}
