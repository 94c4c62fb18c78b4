//! A load that rests is put in its place, whichever flank it lies on.
//!
//! The motor goes to where it would be with the load on its flank. A load that lies short of its place is met on the
//! way and pushed to it; then the shaft carries the load's friction. One that does not show in the motor's torque was
//! not met: it went on as the motor stopped, across its gap, and lies beyond its place by up to a gap. It is fetched
//! back from the other flank, and the motor returns.

use super::{Crossing, CrossingState, NEGLIGIBLE_CHANGE_RAD, TAKE_UP_TORQUE_SHARE};
use crate::traverse::ticks_for;
use lostmotion_drive::twin::{LoadModel, Shown};
use serde::{Deserialize, Serialize};

/// Part of the half gap by which a load may have been pushed too little at rest. A choice.
const LACKING_SHARE: f64 = 0.05;
/// Part of its friction that a load at rest takes where it is certainly on its flank. A choice: half way
/// between one that was pushed, which takes all of it, and one that was not met, which takes none.
const HELD_SHARE: f64 = 0.5;

/// A half gap that was applied at rest, rad, and whether the load was pushed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Rested {
    pub(super) half_gap: f64,
    pushed: bool,
    fetched: Fetched,
}

/// Whether a load that lay beyond its place was fetched back from the other flank in this rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Fetched {
    No,
    /// The motor is on its way to the place, or there.
    Under,
    Yes,
}

impl Crossing {
    /// Applies a half gap, rad, at rest: the motor goes to the place that is right for a load on this flank.
    /// Where it lies elsewhere in its gap it is met on the way and taken along to where the twin's lies, or
    /// not at all: then it lies beyond, and is fetched back.
    pub(super) fn take_up_at_rest(
        &self,
        state: &mut CrossingState,
        now: &Shown,
        load: &LoadModel,
        half_gap: f64,
    ) {
        // before the first flank nothing is known of where the load is
        if state.side == 0 {
            return;
        }
        let side = f64::from(state.side);
        let taken = side * state.traverse.now();
        let before = state.rested.unwrap_or(Rested {
            half_gap: taken,
            pushed: false,
            fetched: Fetched::No,
        });
        let pushed = before.pushed || half_gap > before.half_gap;
        // what takes a good part of its friction beyond the motor's own is on its flank for certain
        let holds = |side: f64| {
            side * state.holding[1] - self.twin.motor_coulomb() > HELD_SHARE * load.coulomb
        };
        let pressed = side * now.torque;
        let constant = self.weighed(load, now.load_position).constant;
        // what the shaft is wound up more by pushing from a side than that of the twin
        let more = |side: f64| {
            let more = load.coulomb + side * constant - side * now.torque;
            (more / load.stiffness).max(0.0)
        };
        let changed = (half_gap - before.half_gap).abs() > NEGLIGIBLE_CHANGE_RAD;
        if before.fetched == Fetched::Under {
            // the load lies where it is to be, and the motor goes back to the flank
            state.engaged |= holds(-side);
            let to = side * half_gap;
            self.place(state, to, load);
            state.rested = Some(Rested {
                fetched: Fetched::Yes,
                half_gap,
                ..before
            });
            return;
        }
        state.engaged |= pushed && holds(side);
        // A load that a push did not meet lies beyond its place: it is fetched back from the other flank.
        let fetches = half_gap > 0.0 && before.pushed && !changed && before.fetched == Fetched::No;
        if fetches && !holds(side) {
            let to = -side * (half_gap + more(-side));
            self.place(state, to, load);
            state.rested = Some(Rested {
                fetched: Fetched::Under,
                ..before
            });
            return;
        }
        // No farther than the gap: a load that lies in its place already would be pushed beyond it.
        let wound = if pushed && pressed > 0.0 && before.fetched == Fetched::No {
            more(side).min(half_gap)
        } else {
            0.0
        };
        // the motor of the twin creeps to its place, too, and its shaft lets go meanwhile
        let lacks = pushed && half_gap + wound - taken > LACKING_SHARE * half_gap;
        if changed || lacks {
            self.place(state, side * (half_gap + wound), load);
            state.rested = Some(Rested {
                half_gap,
                pushed,
                ..before
            });
        }
    }

    /// Starts to an offset, rad, at rest, so that a load that is met stays in contact.
    fn place(&self, state: &mut CrossingState, to: f64, load: &LoadModel) {
        let way = to - state.traverse.now();
        let ticks = self.gentle_ticks(way, load, self.take_up_ticks[1]);
        let ticks = ticks.max(self.rest_take_up_ticks);
        state.traverse.start(to, ticks, &self.current);
        state.taking_up = true;
    }

    /// Servo ticks of a way, rad, on which a load that rests stays in contact once it is met.
    pub(super) fn gentle_ticks(&self, way: f64, load: &LoadModel, most: u32) -> u32 {
        let acceleration = TAKE_UP_TORQUE_SHARE * load.coulomb / load.inertia;
        ticks_for(
            way,
            acceleration,
            self.period,
            [self.take_up_ticks[0], most],
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::AxisConfig;
    use crate::crossing::TORQUE_SHARE;

    /// Ticks of a rest from which on a load is put in its place, whose motor gives so much torque, N m, until
    /// nothing moves any more: the offsets that it came to, in half gaps.
    fn offsets(torque: f64) -> Vec<f64> {
        let config = AxisConfig::paper();
        let crossing = Crossing::new(&config, TORQUE_SHARE, 0.0).taking_up();
        let load = LoadModel {
            coulomb: 0.2,
            ..LoadModel::told(&config)
        };
        let mut state = crossing.initial(0.0, &load);
        (state.side, state.held_ticks) = (-1, crossing.rest_ticks);
        let (now, half_gap) = (state.before, 1e-3);
        let mut offsets = Vec::new();
        for _ in 0..10 {
            crossing.take_up_at_rest(&mut state, &now, &load, half_gap);
            if !state.traverse.moving() {
                break;
            }
            while state.traverse.moving() {
                state.traverse.step(&crossing.current, crossing.period);
            }
            state.holding = [torque; 2];
            offsets.push(state.traverse.now() / half_gap);
        }
        offsets
    }

    #[test]
    fn a_load_that_was_met_stays_and_one_that_was_not_is_fetched_back() {
        let config = AxisConfig::paper();
        let met = offsets(-config.motor.coulomb_nm - 0.15);
        assert_eq!(met.len(), 1, "{met:?}");
        let missed = offsets(0.0);
        let [pushed, fetched, back] = missed[..] else {
            unreachable!("{missed:?}");
        };
        assert!((pushed + 1.0).abs() < 1e-9, "{missed:?}");
        // beyond the half gap by what the load's friction winds up the shaft
        let beyond = 0.2 / LoadModel::told(&config).stiffness / 1e-3;
        assert!((fetched - 1.0 - beyond).abs() < 1e-9, "{missed:?}");
        assert!((back + 1.0).abs() < 1e-9, "{missed:?}");
    }
}
