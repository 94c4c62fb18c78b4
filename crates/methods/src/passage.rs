//! Does an acceleration that runs towards zero go through, or does it end there?
//!
//! On an arc it goes through, and the flank of a load without friction changes there. At the end of
//! a ramp it ends: in steady travel, or at rest; whoever extrapolates it sees a change of flank
//! that never comes, and a load that is let go there floats. The reference does not tell
//! beforehand. What it did the last time is expected again, for the ends of speeding up and of
//! slowing down each; at first, that it ends.

use serde::{Deserialize, Serialize};

/// Part of the acceleration that was extrapolated from which on it has gone through.
const THROUGH: f64 = 0.25;
/// Part of a speed below which what is left of it is none.
const REST: f64 = 0.05;

/// What was seen of it so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Passage {
    /// At the end of speeding up, of slowing down.
    goes_through: [bool; 2],
    awaited: Option<Awaited>,
}

/// An acceleration that was extrapolated beyond zero, and in how many ticks it has to be there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Awaited {
    slowing: bool,
    acceleration: f64,
    ticks: u32,
}

impl Passage {
    /// Speed and acceleration some ticks of `period` (s) ahead (rad/s, rad/s2) from those now and
    /// the change of acceleration in a tick. To be asked every tick.
    pub(super) fn ahead(
        &mut self,
        speed: f64,
        acceleration: f64,
        step: f64,
        lead_ticks: f64,
        period: f64,
    ) -> [f64; 2] {
        self.look(acceleration);
        let free = acceleration + step * lead_ticks;
        let speed_there = speed + (acceleration + 0.5 * step * lead_ticks) * lead_ticks * period;
        if free * acceleration >= 0.0 {
            return [speed_there, free];
        }
        let slowing = acceleration * speed < 0.0;
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
        let end = speed - 0.5 * acceleration * acceleration / step * period;
        [
            if end.abs() < REST * speed.abs() {
                0.0
            } else {
                end
            },
            0.0,
        ]
    }

    fn look(&mut self, acceleration: f64) {
        let Some(awaited) = &mut self.awaited else {
            return;
        };
        awaited.ticks = awaited.ticks.saturating_sub(1);
        if awaited.ticks == 0 {
            let (wanted, slowing) = (awaited.acceleration, usize::from(awaited.slowing));
            self.goes_through[slowing] = acceleration * wanted > THROUGH * wanted * wanted;
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
