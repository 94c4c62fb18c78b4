//! Reversals of the commanded velocity of joints.

use lostmotion_base::{AXES, AxisId, Coords, Tick};
use serde::{Deserialize, Serialize};

/// When a joint counts as moving.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReversalConfig {
    /// Speeds of linear joints up to this are standing still, mm/s.
    pub deadband_mm_s: f64,
    /// Speeds of rotary joints up to this are standing still, rad/s.
    pub deadband_rad_s: f64,
}

impl Default for ReversalConfig {
    fn default() -> ReversalConfig {
        ReversalConfig {
            deadband_mm_s: 1e-6,
            deadband_rad_s: 1e-8,
        }
    }
}

/// The last direction of each joint and when it last changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReversalState {
    direction: [i8; AXES],
    last: [Option<Tick>; AXES],
}

/// A joint that now moves against its last direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reversal {
    /// Which.
    pub axis: AxisId,
    /// First tick of the new direction.
    pub tick: Tick,
    /// New direction: 1 or -1.
    pub direction: i8,
}

impl ReversalConfig {
    /// Feeds the commanded joint velocities (mm/s, rad/s) of a tick and returns the joints that now
    /// move the other way, in axis order. However long a joint stood still in between, it is one
    /// reversal, at the tick at which it moves again. A joint's first motion is no reversal.
    ///
    /// ```
    /// use lostmotion_base::Coords;
    /// use lostmotion_contour::{ReversalConfig, ReversalState};
    ///
    /// let (config, mut state) = (ReversalConfig::default(), ReversalState::default());
    /// let mut reversals = |tick, speed| {
    ///     config.step(&mut state, tick, &Coords::xyz(speed, 0.0, 0.0)).count()
    /// };
    /// // Forward, a rest, back: one reversal, where the joint moves again.
    /// assert_eq!([reversals(0, 5.0), reversals(1, 0.0), reversals(2, -5.0)], [0, 0, 1]);
    /// ```
    pub fn step(
        &self,
        state: &mut ReversalState,
        tick: Tick,
        velocity: &Coords,
    ) -> impl Iterator<Item = Reversal> + use<> {
        let mut turned = [None; AXES];
        for axis in AxisId::ALL {
            let deadband = if axis.is_rotary() {
                self.deadband_rad_s
            } else {
                self.deadband_mm_s
            };
            let speed = velocity[axis];
            let (Some(was), Some(last)) = (
                state.direction.get_mut(axis.index()),
                state.last.get_mut(axis.index()),
            ) else {
                continue;
            };
            // Standing still keeps the last direction, however long.
            if speed.abs() <= deadband || speed.is_nan() {
                continue;
            }
            let direction = if speed > 0.0 { 1 } else { -1 };
            // Before a joint's first motion its direction is 0, which is against neither.
            if *was == -direction {
                *last = Some(tick);
                turned[axis.index()] = Some(Reversal {
                    axis,
                    tick,
                    direction,
                });
            }
            *was = direction;
        }
        turned.into_iter().flatten()
    }
}

impl ReversalState {
    /// The joint that reversed last, if that was at most `within` ticks before `now`; of several at
    /// the same tick the first in axis order.
    pub fn latest(&self, now: Tick, within: Tick) -> Option<AxisId> {
        let recent = |axis: AxisId| {
            self.last
                .get(axis.index())
                .copied()
                .flatten()
                .filter(|tick| now.saturating_sub(*tick) <= within)
        };
        // The latest of all axes; a later axis replaces it only by a later tick.
        let mut best: Option<(Tick, AxisId)> = None;
        for axis in AxisId::ALL {
            if let Some(tick) =
                recent(axis).filter(|tick| best.is_none_or(|(other, _)| *tick > other))
            {
                best = Some((tick, axis));
            }
        }
        best.map(|(_, axis)| axis)
    }
}
