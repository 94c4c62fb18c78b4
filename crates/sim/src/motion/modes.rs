//! Which kinematics the coordinates of a move go through.

use lostmotion_kinematics::{Cartesian, Kinematics};
use std::sync::Arc;

/// With tool-centre-point control or without, by running number of the segment.
#[derive(Clone, Debug)]
pub(crate) struct Modes {
    tip: Arc<dyn Kinematics>,
    plain: Arc<dyn Kinematics>,
    /// First segment of each stretch, and whether its coordinates are the tip's; they come in turn.
    changes: Vec<(u64, bool)>,
}

impl Modes {
    pub(crate) fn new(kinematics: &Arc<dyn Kinematics>) -> Modes {
        Modes {
            tip: Arc::clone(kinematics),
            plain: Arc::new(Cartesian),
            changes: Vec::new(),
        }
    }

    pub(crate) fn kinematics(&self, tip: bool) -> &Arc<dyn Kinematics> {
        if tip { &self.tip } else { &self.plain }
    }

    /// From a segment on coordinates are of this kind. False if they have been.
    pub(crate) fn begin(&mut self, segment: u64, tip: bool) -> bool {
        let changed = self.changes.last().is_none_or(|(_, last)| *last != tip);
        if changed {
            self.changes.push((segment, tip));
        }
        changed
    }

    /// That of a segment.
    pub(crate) fn at(&self, segment: u64) -> &dyn Kinematics {
        // The last change at or before the segment holds; there are few changes and many look-ups.
        let after = self.changes.partition_point(|(first, _)| *first <= segment);
        let tip = after
            .checked_sub(1)
            .and_then(|index| self.changes.get(index))
            .is_none_or(|(_, tip)| *tip);
        self.kinematics(tip).as_ref()
    }
}
