//! What is used of a gap that is known.

use super::{Adaptive, AdaptiveState};
use crate::crossing::HalfGap;
use crate::readings::Readings;

/// What is used while the axis moves on as it does: the half gap, and the one that is known, rad. It follows from the
/// rest of the state, and is kept until that decides otherwise.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Kept(Option<(HalfGap, Option<f64>)>);

impl PartialEq for Kept {
    fn eq(&self, _: &Kept) -> bool {
        true
    }
}

/// Half gaps that are used of one that is known so, in motion and at rest, rad; `nil`: it is too small to matter.
pub(super) fn used_of(gap: &Readings, nil: bool) -> (f64, f64) {
    let used = if nil { 0.0 } else { gap.used() };
    let at_rest = if nil || by_hints(gap, used) {
        used
    } else {
        gap.used_at_rest()
    };
    (used, at_rest)
}

/// The part of a gap that is used while so many readings agree on it; 0 readings where hints alone tell
/// it. First ones may be too large by a tenth, and what is too small only leaves a part of the error.
/// Tuned: with the whole gap at once
/// three of 107 drawn cells threw their loads (20261124-21, 773109-27, 31337-42).
fn by_degrees(readings: u32) -> f64 {
    match readings {
        0 | 1 => 0.8,
        2 => 0.95,
        _ => 1.0,
    }
}

/// Whether hints alone tell a half gap that is used in motion, rad.
fn by_hints(gap: &Readings, used: f64) -> bool {
    gap.count == 0 && used > 0.0
}

impl Adaptive {
    /// Half gap that is used at a tick, and the one that is known, rad; `rests`: the reference does.
    #[inline(always)]
    pub(super) fn use_of(&self, state: &mut AdaptiveState, rests: bool) -> (HalfGap, Option<f64>) {
        match state.kept {
            Kept(Some(kept)) if !rests => kept,
            _ => {
                // used as far as this axis and those that move with it are ready
                let used = self.now_used(state);
                state.trust.places(used.resting > 0.0);
                let known = state.trust.known(self.half_gap(state, rests));
                state.kept = Kept((!rests).then_some((used, known)));
                (used, known)
            }
        }
    }

    /// Half gap that could be used in motion, or at rest, rad.
    fn half_gap(&self, state: &AdaptiveState, rests: bool) -> f64 {
        // what is not enough in motion is used in a long rest alone: in short ones it would spoil the readings to come
        if rests && (state.used > 0.0 || state.trust.rests_long()) {
            state.at_rest
        } else {
            state.used
        }
    }

    /// Half gap that is used at the moment, rad.
    pub(super) fn now_used(&self, state: &AdaptiveState) -> HalfGap {
        let (degrees, share) = (by_degrees(state.gap.count), state.trust.share());
        HalfGap {
            moving: share * (degrees * state.used),
            resting: share
                * if by_hints(&state.gap, state.used) {
                    degrees * state.used
                } else {
                    self.half_gap(state, true)
                },
        }
    }
}
