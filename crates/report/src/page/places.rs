//! What the tool does around the worst places, tick by tick.

use lostmotion_base::BlockRef;
use lostmotion_sim::ContourPoint;
use std::collections::VecDeque;

/// Places that are kept of a method. A choice: as many as a list of worst blocks has.
const MOST_PLACES: usize = 10;
/// Ticks that are kept before and after the worst one. A choice: 0.1 s at 4 kHz, which a spike at
/// a reversal takes.
const TICKS_AROUND: usize = 400;

/// A tick near a worst place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Near {
    /// Time, s.
    pub(super) time_s: f64,
    /// Foot point on the programmed path, mm.
    pub(super) foot_mm: [f64; 3],
    /// From there to the tool, mm.
    pub(super) off_mm: [f32; 3],
    /// Error, um.
    pub(super) error_um: f32,
}

/// The surroundings of the worst tick of a block.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// The block.
    pub(super) block: BlockRef,
    /// The largest error of the block so far, um.
    pub(super) worst_um: f32,
    /// Time of that tick, s.
    pub(super) time_s: f64,
    /// The ticks around it, in their order.
    pub(super) near: Vec<Near>,
}

/// Keeps the surroundings of the worst ticks of the worst blocks of one method.
#[derive(Clone, Debug, Default)]
pub(super) struct PlaceRecorder {
    ring: VecDeque<Near>,
    /// Block and worst error of the place that waits for its following ticks.
    waiting: Option<(BlockRef, f32, usize)>,
    /// Places so far, in no order.
    pub(super) places: Vec<Place>,
    /// Error below which nothing is a worst place any more, um.
    least_um: f32,
}

impl PlaceRecorder {
    /// Takes a servo tick.
    pub(super) fn push(&mut self, point: &ContourPoint) {
        if self.ring.len() > 2 * TICKS_AROUND {
            self.ring.pop_front();
        }
        let error = point.error_um as f32;
        self.ring.push_back(Near {
            time_s: point.time_s,
            foot_mm: point.foot_mm,
            off_mm: [0, 1, 2].map(|axis| (point.actual_mm[axis] - point.foot_mm[axis]) as f32),
            error_um: error,
        });
        if let Some((block, worst, since)) = &mut self.waiting {
            *since += 1;
            // A larger one of the same block moves the window; one of another block ends it.
            let counts = point.moving && !point.rapid && error.abs() > worst.abs();
            if *block == point.block && counts {
                (*worst, *since) = (error, 0);
                return;
            }
            if *since >= TICKS_AROUND || counts {
                self.keep();
            } else {
                return;
            }
        }
        if point.moving && !point.rapid && error.abs() > self.least_um {
            let known = self.places.iter().find(|place| place.block == point.block);
            if known.is_none_or(|place| error.abs() > place.worst_um.abs()) {
                self.waiting = Some((point.block, error, 0));
            }
        }
    }

    /// Copies the window of the place that waits.
    fn keep(&mut self) {
        let Some((block, worst_um, since)) = self.waiting.take() else {
            return;
        };
        let at = self.ring.len().saturating_sub(1 + since);
        let Some(worst) = self.ring.get(at) else {
            return;
        };
        let from = at.saturating_sub(TICKS_AROUND);
        let place = Place {
            block,
            worst_um,
            time_s: worst.time_s,
            near: self.ring.range(from..).copied().collect(),
        };
        self.places.retain(|place| place.block != block);
        self.places.push(place);
        if self.places.len() > MOST_PLACES {
            let least = (0..self.places.len()).min_by(|a, b| {
                let of = |index: &usize| self.places[*index].worst_um.abs();
                of(a).total_cmp(&of(b))
            });
            if let Some(least) = least {
                self.places.swap_remove(least);
            }
            let all = self.places.iter().map(|place| place.worst_um.abs());
            self.least_um = all.fold(f32::INFINITY, f32::min);
        }
    }

    /// The place of a block, with its window as far as the run went.
    pub(super) fn finish(mut self) -> Vec<Place> {
        self.keep();
        self.places
    }
}
