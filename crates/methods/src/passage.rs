//! Predicts whether an acceleration that runs towards zero passes through zero or ends there.
//!
//! On an arc it passes through, and the flank of a load without friction changes there. At the end
//! of a ramp it ends, in steady travel or at rest: extrapolating it predicts a change of flank that
//! never comes, and a load that is released there floats. The reference does not tell beforehand,
//! since the motor has to start half a traverse before the flank changes. So what the acceleration
//! did the last time is expected again, separately for the ends of speeding up and of slowing down;
//! at first, that it ends.
//!
//! ```text
//! a(t + lead) = a + lead da,   v(t + lead) = v + (a + lead da/2) lead T_s       linear extrapolation over the lead
//! where it ends:               a = 0,   v = v - a^2/(2 da) T_s                  da: change of acceleration in a tick
//! ```

use serde::{Deserialize, Serialize};

/// Part of the extrapolated acceleration from which on it counts as having passed through zero. A
/// choice: what passes through zero is there nearly in full, what ends leaves only a rest of lag.
const PASSED_SHARE: f64 = 0.25;
/// Part of a speed below which the speed that is left where the acceleration ends counts as rest. A
/// choice: larger takes slow travel after a ramp for rest, smaller a ramp's rounded end for travel.
const REST_SHARE: f64 = 0.05;

/// What the accelerations did so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Passage {
    /// Whether the last one passed through zero: at the end of speeding up, of slowing down.
    goes_through: [bool; 2],
    awaited: Option<Awaited>,
}

/// A prediction to be checked: the acceleration that was extrapolated beyond zero (rad/s2), and the
/// ticks until it is due.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Awaited {
    slowing: bool,
    acceleration: f64,
    ticks: u32,
}

impl Passage {
    /// Speed and acceleration some ticks of `period` (s) ahead (rad/s, rad/s2) from those now and
    /// the change of acceleration in a tick. To be called every tick.
    #[inline(always)]
    pub(super) fn ahead(
        &mut self,
        speed: f64,
        acceleration: f64,
        step: f64,
        lead_ticks: f64,
        period: f64,
    ) -> [f64; 2] {
        // first learn from the last prediction, which may be due now
        self.check_prediction(acceleration);
        let free = acceleration + step * lead_ticks;
        let speed_there = speed + (acceleration + 0.5 * step * lead_ticks) * lead_ticks * period;
        // no zero within the lead: plain extrapolation
        if free * acceleration >= 0.0 {
            return [speed_there, free];
        }
        let slowing = acceleration * speed < 0.0;
        // due as long after the zero as the lead; one at a time, so that the first is checked
        if self.awaited.is_none() {
            let ticks = lead_ticks - acceleration / step;
            self.awaited = Some(Awaited {
                slowing,
                acceleration: step * lead_ticks,
                ticks: ticks.ceil() as u32,
            });
        }
        if self.goes_through[usize::from(slowing)] {
            return [speed_there, free];
        }
        // expected to end: the speed at the zero of the acceleration, where braking to rest leaves
        // rounding
        let end = speed - 0.5 * acceleration * acceleration / step * period;
        [
            if end.abs() < REST_SHARE * speed.abs() {
                0.0
            } else {
                end
            },
            0.0,
        ]
    }

    #[inline(always)]
    fn check_prediction(&mut self, acceleration: f64) {
        let Some(awaited) = &mut self.awaited else {
            return;
        };
        awaited.ticks = awaited.ticks.saturating_sub(1);
        if awaited.ticks == 0 {
            let (wanted, slowing) = (awaited.acceleration, usize::from(awaited.slowing));
            // same sign as predicted, and a notable part of it
            self.goes_through[slowing] = acceleration * wanted > PASSED_SHARE * wanted * wanted;
            self.awaited = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_base::{Clock, math};

    const LEAD: f64 = 8.0;

    #[test]
    fn on_a_sine_it_goes_through_from_the_second_time_on() {
        let (mut passage, w) = (Passage::default(), 20.0);
        let mut wrong = [0; 4];
        for tick in 0..2500_u32 {
            let at = |tick: u32| w * f64::from(tick) * Clock::SERVO.period_s();
            let step = math::cos(at(tick + 1)) - math::cos(at(tick));
            let [_, ahead] = passage.ahead(
                math::sin(at(tick)) / w,
                math::cos(at(tick)),
                step,
                LEAD,
                Clock::SERVO.period_s(),
            );
            // half a turn holds one end of speeding up and one of slowing down
            if ahead * math::cos(at(tick + LEAD as u32)) <= 0.0 {
                wrong[(tick / 628) as usize] += 1;
            }
        }
        assert!(
            wrong[0] > 4 && wrong[2..].iter().sum::<i32>() <= 2,
            "{wrong:?}"
        );
    }

    #[test]
    fn at_the_end_of_a_ramp_it_stays_at_zero() {
        let mut passage = Passage::default();
        for _ in 0..3 {
            // braking to rest with a constant jerk
            for left in (1..40_u32).rev() {
                let (n, period) = (f64::from(left), Clock::SERVO.period_s());
                let ahead = passage.ahead(0.5 * n * n * period, -n, 1.0, LEAD, period);
                assert!(ahead[0] >= -1e-12 && ahead[1] <= 0.0, "{left} {ahead:?}");
            }
            for _ in 0..20 {
                assert_eq!(
                    passage.ahead(0.0, 0.0, 0.0, LEAD, Clock::SERVO.period_s()),
                    [0.0, 0.0]
                );
            }
        }
    }
}
