//! A machine or a program that is better in one thing.

use lostmotion_plan::{FeedLimit, PathControl, PlanItem, PlannerConfig};

/// By what factor each thing is changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LimitChange {
    velocity: f64,
    acceleration: f64,
    jerk: f64,
    feed: f64,
    tolerance: f64,
}

impl LimitChange {
    /// As it is.
    pub(crate) const NONE: LimitChange = LimitChange {
        velocity: 1.0,
        acceleration: 1.0,
        jerk: 1.0,
        feed: 1.0,
        tolerance: 1.0,
    };

    /// The planner's settings.
    pub(crate) fn of_machine(&self, mut config: PlannerConfig) -> PlannerConfig {
        for limits in config.limits.iter_mut().flatten() {
            limits.velocity *= self.velocity;
            limits.acceleration *= self.acceleration;
            limits.jerk *= self.jerk;
        }
        // The machine's tolerance serves moves whose G64 names none; theirs is changed with the
        // item.
        config.default_tolerance_mm *= self.tolerance;
        config
    }

    /// The program's words.
    pub(crate) fn of_item(&self, mut item: PlanItem) -> PlanItem {
        if let PlanItem::Move(item) = &mut item {
            item.feed = match item.feed {
                FeedLimit::Rapid => FeedLimit::Rapid,
                FeedLimit::PerSecond(feed) => FeedLimit::PerSecond(feed * self.feed),
                FeedLimit::Fixed(feed) => FeedLimit::Fixed(feed * self.feed),
                // Inverse time gives the duration: a faster feed makes it shorter.
                FeedLimit::Duration(seconds) => FeedLimit::Duration(seconds / self.feed),
            };
            if let PathControl::Continuous {
                tolerance_mm: Some(tolerance),
                ..
            } = &mut item.control
            {
                *tolerance *= self.tolerance;
            }
        }
        item
    }
}

/// The changes that are tried, with their names.
pub(crate) const CHANGES: [(&str, LimitChange); 6] = [
    (
        "velocity limits +20 %",
        LimitChange {
            velocity: 1.2,
            ..LimitChange::NONE
        },
    ),
    (
        "acceleration limits +20 %",
        LimitChange {
            acceleration: 1.2,
            ..LimitChange::NONE
        },
    ),
    (
        "jerk limits +20 %",
        LimitChange {
            jerk: 1.2,
            ..LimitChange::NONE
        },
    ),
    (
        "all three limits +20 %",
        LimitChange {
            velocity: 1.2,
            acceleration: 1.2,
            jerk: 1.2,
            ..LimitChange::NONE
        },
    ),
    (
        "feed +20 %",
        LimitChange {
            feed: 1.2,
            ..LimitChange::NONE
        },
    ),
    (
        "tolerance of G64 x 2",
        LimitChange {
            tolerance: 2.0,
            ..LimitChange::NONE
        },
    ),
];
