//! The flank that has to carry the load, foreseen by half a traverse.
//!
//! A need that has turned around before the motor arrives was on the other side of zero for less than a traverse: it
//! hovers around zero. What it presses with is little, so that a load on the other flank loses little; but it is
//! extrapolated as a straight line, which soon is wrong again, and a motor that goes to and fro meets its load at
//! speed and throws it. For the time of two traverses only a notable need brings it back.

use super::{Crossing, CrossingState, HOLDING_MEAN_TICKS, SLIDING_RAD_S};
use crate::traverse::STANDING_RAD_S;
use lostmotion_base::Number;
use lostmotion_drive::Signals;
use lostmotion_drive::twin::{LoadModel, Shown};

/// Servo ticks by which a traverse starts earlier: detection and the loops take about two.
const EARLY_START_TICKS: f64 = 2.0;
/// Part of the load's Coulomb friction that the shaft of an axis at rest has to pull with for the
/// flank to change. Tuned (0.05 was tried and taken back).
const PULL_SHARE_OF_FRICTION: f64 = 0.25;

/// Part of the load's Coulomb friction that a need has to have which turned around while the motor was on its way.
/// Tuned: with a quarter 714025-28 throws its load by a gap on each lap, with three quarters it loses more than with a half.
const BACK_SHARE_OF_FRICTION: f64 = 0.5;
/// How long that holds, in traverses. A choice: what hovers for longer has become a need; twice as long is the same.
const HOVERING_CROSSINGS: u32 = 2;

impl Crossing {
    /// Flank that has to carry the load at the middle of a traverse that would start now, given the half gap
    /// (rad) and half of the traverse (servo ticks).
    #[inline(always)]
    pub(super) fn side_ahead(
        &self,
        state: &mut CrossingState,
        now: &Shown,
        signals: &Signals,
        load: &LoadModel,
        [half_gap, lead_ticks]: [f64; 2],
    ) -> i8 {
        // the twin's shaft torque, extrapolated by its last change
        let torque =
            now.torque + (state.twin.torque - now.torque) * (lead_ticks + EARLY_START_TICKS);
        let [speed, acceleration] = state.lagged;
        // behind a lag the jerk of the reference says nothing about the axis' own
        let step = if self.lag_per_tick < 1.0 {
            0.0
        } else {
            signals.next_reference.acceleration - signals.reference.acceleration
        };
        // the load model at the reference, at the same moment ahead
        let [ahead_speed, ahead_acceleration] =
            state
                .passage
                .ahead(speed, acceleration, step, lead_ticks, self.period);
        let there = self.weighed(
            load,
            now.load_position + ahead_speed * lead_ticks * self.period,
        );
        let need = there.need(ahead_speed, ahead_acceleration, STANDING_RAD_S);
        // at rest: the friction of a standing load has no sign, so the load model has no say
        let stands = speed.abs() <= STANDING_RAD_S && acceleration == 0.0 && step == 0.0;
        // a load learned roughly predicts the slip worse than the motor's own torque shows it; one that
        // readings agree on predicts it better
        if stands && self.takes_up && !state.trusts_twin && load.coulomb > self.unloaded {
            // once a rest: a traverse that pushes the load, since the gap is known too large,
            // would be answered by the next one
            state.at_rest = true;
            return if !state.crossed_at_rest && self.has_settled(state, load, half_gap) {
                self.held(state, lead_ticks)
            } else {
                state.side
            };
        }
        (state.at_rest, state.crossed_at_rest) = (false, false);
        // a load that friction holds while its axis sets out does not swing
        let pull = PULL_SHARE_OF_FRICTION * load.coulomb;
        let notable = pull.larger(self.unloaded);
        state.swings = (signals.reference.velocity != 0.0
            && now.load_velocity.abs() > SLIDING_RAD_S)
            .then_some(torque.abs() > notable && need * torque < 0.0);
        // moving: both signs have to agree; standing: the twin pulls with a notable part of the
        // friction
        let side = if torque > 0.0 { 1 } else { -1 };
        let agree = torque.abs() > self.unloaded && need * torque > 0.0;
        let sure = if stands {
            torque.abs() > pull && load.coulomb > self.unloaded
        } else {
            let back = agree && side != state.side;
            let least = BACK_SHARE_OF_FRICTION * load.coulomb;
            agree && !(state.hovers(back) && need.abs().min(torque.abs()) < least)
        };
        if sure { side } else { state.side }
    }

    /// The flank that will have to carry a load that sticks, by the motor's own torque: the motor starts
    /// across the gap once that torque exceeds the motor's Coulomb friction.
    fn held(&self, state: &CrossingState, lead_ticks: f64) -> i8 {
        let ([short, long], [few, many]) = (state.holding, HOLDING_MEAN_TICKS);
        // slope of the torque from the two lags; the mean makes up for its own
        let torque = short + (short - long) / (many - few) * (few + lead_ticks + EARLY_START_TICKS);
        if torque * f64::from(state.side) < -self.twin.motor_coulomb() {
            -state.side
        } else {
            state.side
        }
    }
}

impl CrossingState {
    /// Whether the need hovers around zero, so that it has to be notable to bring the motor back: `back`, it asks for
    /// the other flank.
    #[inline(always)]
    fn hovers(&mut self, back: bool) -> bool {
        // asked by the first decision behind a crossing: the need turned around while the motor was on its way
        if self.since == 1 {
            self.hovers = back;
        }
        self.hovers &= self.since < HOVERING_CROSSINGS * self.ticks_across;
        self.hovers
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::AxisConfig;

    #[test]
    fn a_need_that_turned_around_during_a_crossing_hovers_for_two_traverses() {
        let config = AxisConfig::paper();
        let crossing = Crossing::new(&config, 0.8, 0.0);
        let mut state = crossing.initial(0.0, &LoadModel::told(&config));
        state.ticks_across = 10;
        let mut at = |since: u32, back: bool| {
            state.since = since;
            state.hovers(back)
        };
        assert!(!at(u32::MAX, true));
        assert!(at(1, true) && at(5, false) && at(19, true) && !at(20, true) && !at(21, true));
        // one that turns around later is a change of flank as any other
        assert!(!at(1, false) && !at(2, true));
    }
}
