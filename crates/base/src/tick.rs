//! Time as an integer count, so that it never drifts: t = n * period.

use serde::{Deserialize, Serialize};

/// Count of periods of some [`Clock`] since the start.
pub type Tick = u64;

/// A fixed rate, held as a whole number of nanoseconds per period.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Clock {
    period_ns: u64,
}

impl Clock {
    /// The path planner's and the bus' cycle: 1 ms.
    pub const CNC: Clock = Clock {
        period_ns: 1_000_000,
    };
    /// The servo's position and velocity loops: 250 us.
    pub const SERVO: Clock = Clock { period_ns: 250_000 };
    /// The drive's current loop: 50 us.
    pub const CURRENT: Clock = Clock { period_ns: 50_000 };

    /// A clock with a period in nanoseconds; `None` for zero.
    pub const fn from_nanos(period_ns: u64) -> Option<Clock> {
        if period_ns == 0 {
            None
        } else {
            Some(Clock { period_ns })
        }
    }

    /// The period in nanoseconds.
    pub const fn period_ns(self) -> u64 {
        self.period_ns
    }

    /// The period in seconds.
    pub fn period_s(self) -> f64 {
        self.period_ns as f64 * 1e-9
    }

    /// The time in seconds at a tick: one multiplication, nothing accumulated.
    pub fn seconds(self, tick: Tick) -> f64 {
        // The product is exact up to 2^53 ns (104 days): only the change to seconds rounds.
        (tick as f64 * self.period_ns as f64) * 1e-9
    }

    /// How many periods of a faster clock fit into one of this; `None` if they do not fit evenly.
    pub const fn ratio(self, faster: Clock) -> Option<u64> {
        // A period of the slower loop has to hold whole periods of the faster one.
        if self.period_ns.is_multiple_of(faster.period_ns) {
            Some(self.period_ns / faster.period_ns)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_three_clocks_nest() {
        assert_eq!(Clock::CNC.ratio(Clock::SERVO), Some(4));
        assert_eq!(Clock::SERVO.ratio(Clock::CURRENT), Some(5));
        assert_eq!(Clock::CURRENT.ratio(Clock::CNC), None);
        assert_eq!(
            Clock::CNC.seconds(3_600_000).to_bits(),
            3600.0_f64.to_bits()
        );
    }
}
