//! Actions of an operator, and the pace that they ask for.

use crate::{Heeds, PlanError};

/// Least pace, as a part of the planned one, at which places are passed between others of another
/// pace, so that the motion also reaches a place where it is to rest. Record 41 of the decisions.
const LEAST_PASSING_PACE: f64 = 0.03;
/// Part of the least pace asked for at which everything that may come keeps its limits with some
/// room. Record 41 of the decisions.
const SURE_PACE_SHARE: f64 = 0.95;

/// Least override above 0. A choice: a tenth of the finest step of a dial; with less nobody lives to
/// see the end of a part, and a mistyped one would seem to hang.
const LEAST_OVERRIDE: f64 = 1e-3;

/// What an operator does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Comes to rest on the path as fast as the limits allow, and waits.
    Hold,
    /// Goes on.
    Resume,
    /// Comes to rest in the same way, for good.
    Stop,
    /// The feed as a part of the programmed one: 0, or from 0.001 to 2. Rapid moves and those that heed no
    /// override stay as they are. Up to 1 it is the pace of the whole motion along a feed move;
    /// above it the motion gets as fast as the joints allow with that feed. At 0 it rests on a feed
    /// move.
    Override(f64),
    /// The pace of rapid moves as a part of the planned one: 0, or from 0.001 to 1. At 0 it rests on a rapid
    /// move.
    Rapid(f64),
}

impl Action {
    /// Checks it.
    ///
    /// # Errors
    /// An override out of its range.
    pub fn check(self) -> Result<(), PlanError> {
        let within =
            |value: f64, most: f64| value == 0.0 || (LEAST_OVERRIDE..=most).contains(&value);
        match self {
            Action::Override(value) if !within(value, 2.0) => Err(PlanError::Setting {
                what: "feed override",
                value,
                condition: "0, or from 0.001 to 2",
            }),
            Action::Rapid(value) if !within(value, 1.0) => Err(PlanError::Setting {
                what: "rapid override",
                value,
                condition: "0, or from 0.001 to 1",
            }),
            _ => Ok(()),
        }
    }
}

/// The overrides in force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Asked {
    pub(super) feed: f64,
    pub(super) rapid: f64,
}

impl Asked {
    /// The override for a place, as it stands on the dial.
    pub(super) fn of(&self, heeds: Heeds) -> f64 {
        match heeds {
            Heeds::Feed => self.feed,
            Heeds::Rapid => self.rapid,
            Heeds::Nothing => 1.0,
        }
    }

    /// Whether the motion is to rest at a place.
    pub(super) fn rests(&self, heeds: Heeds) -> bool {
        self.of(heeds) == 0.0
    }

    /// The pace at which a place is to be passed between others; above 1 it is the factor on the
    /// programmed feed.
    pub(super) fn cap(&self, heeds: Heeds) -> f64 {
        self.of(heeds).max(LEAST_PASSING_PACE)
    }

    /// A pace within the overrides of all places and within the limits of the joints.
    pub(super) fn sure(&self) -> f64 {
        SURE_PACE_SHARE * self.cap(Heeds::Feed).min(self.cap(Heeds::Rapid)).min(1.0)
    }
}
