//! What has been set last, so that setting it again can be left out.

use lostmotion_gcode::ops::{CanonicalOp, PathControl, Plane, Units};

/// The last operation of each kind that only sets something.
#[derive(Clone, Debug)]
pub(super) struct Settled {
    last: Vec<Option<CanonicalOp>>,
}

/// Kinds of settings that are remembered.
const KIND_COUNT: usize = 17;
/// That of feed rates.
const RATE_KIND: usize = 1;
/// That of the first spindle's turning.
const SPINDLE_KIND: usize = 9;

/// The kind of an operation that only sets something; `None` for all others.
fn kind(op: &CanonicalOp) -> Option<usize> {
    use CanonicalOp as O;
    Some(match op {
        O::UseLengthUnits(_) => 0,
        O::SetFeedRate { .. } => RATE_KIND,
        O::SetFeedMode { .. } => 2,
        O::SelectPlane(_) => 3,
        O::SetMotionControlMode(_) => 4,
        O::SetNaiveCamTolerance(_) => 5,
        O::UseToolLengthOffset(_) => 6,
        O::SetSpindleSpeed { spindle: 0, .. } => 7,
        O::SetSpindleMode { spindle: 0, .. } => 8,
        O::StartSpindle { spindle: 0, .. } | O::StopSpindle { spindle: 0 } => SPINDLE_KIND,
        O::Mist(_) => 10,
        O::Flood(_) => 11,
        O::FeedOverride(_) => 12,
        O::SpeedOverride(_) => 13,
        O::AdaptiveFeed(_) => 14,
        O::FeedHold(_) => 15,
        O::StartSpeedFeedSync(_) | O::StopSpeedFeedSync => 16,
        _ => return None,
    })
}

impl Settled {
    /// What is in force before a program.
    pub(super) fn new(units: Units) -> Settled {
        use CanonicalOp as O;
        let mut settled = Settled {
            last: vec![None; KIND_COUNT],
        };
        let start = [
            O::UseLengthUnits(units),
            O::SetFeedRate {
                rate: 0.0,
                inverse_time: None,
            },
            O::SetFeedMode {
                per_revolution: false,
            },
            O::SelectPlane(Plane::Xy),
            O::SetMotionControlMode(PathControl::Continuous { tolerance: 0.0 }),
            O::SetNaiveCamTolerance(0.0),
            O::UseToolLengthOffset([0.0; 9]),
            O::SetSpindleSpeed {
                spindle: 0,
                speed: 0.0,
            },
            O::SetSpindleMode {
                spindle: 0,
                highest: 0.0,
            },
            O::StopSpindle { spindle: 0 },
            O::Mist(false),
            O::Flood(false),
            O::FeedOverride(true),
            O::SpeedOverride(true),
            O::AdaptiveFeed(false),
            O::FeedHold(true),
            O::StopSpeedFeedSync,
        ];
        for op in start {
            settled.is_news(&op);
        }
        settled
    }

    /// Whether an operation changes anything; it is remembered.
    pub(super) fn is_news(&mut self, op: &CanonicalOp) -> bool {
        // Other units: remembered lengths no longer compare.
        if matches!(op, CanonicalOp::UseLengthUnits(_))
            && kind(op).is_some_and(|kind| self.last.get(kind) != Some(&Some(op.clone())))
        {
            self.forget_lengths();
        }
        // A spindle that has been turned to an angle stands still.
        if matches!(
            op,
            CanonicalOp::OrientSpindle { spindle: 0, .. }
                | CanonicalOp::WaitOrient { spindle: 0, .. }
        ) {
            self.forget(SPINDLE_KIND);
        }
        let Some(slot) = kind(op).and_then(|kind| self.last.get_mut(kind)) else {
            return true;
        };
        // The rate of an inverse time holds for one move.
        let lasting = !matches!(
            op,
            CanonicalOp::SetFeedRate {
                inverse_time: Some(_),
                ..
            }
        );
        let news = slot.as_ref() != Some(op);
        *slot = lasting.then(|| op.clone());
        // Each feed mode begins without a rate, so that the next F is news.
        if news && matches!(op, CanonicalOp::SetFeedMode { .. }) {
            self.forget(RATE_KIND);
        }
        news
    }

    /// The rate is of another kind, or gone.
    fn forget(&mut self, kind: usize) {
        if let Some(slot) = self.last.get_mut(kind) {
            *slot = None;
        }
    }

    /// In other units the same numbers mean something else.
    fn forget_lengths(&mut self) {
        for kind in [RATE_KIND, 4, 5, 6, 16] {
            if let Some(slot) = self.last.get_mut(kind) {
                *slot = slot
                    .take()
                    .filter(|op| matches!(op, CanonicalOp::StopSpeedFeedSync));
            }
        }
    }
}
