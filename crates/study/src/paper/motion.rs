//! The move: there, a rest, back, a rest, with limited velocity, acceleration and jerk.

use lostmotion_base::Clock;
use lostmotion_drive::Setpoint;

/// Rest before, between and after the moves, s: the last two long enough to settle. A choice, as
/// the paper does not say.
const REST_S: [f64; 3] = [0.2, 0.8, 0.8];

/// A rest-to-rest move in rad at the motor's shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// How far.
    pub distance_rad: f64,
    /// Highest speed, rad/s.
    pub velocity_rad_s: f64,
    /// Highest acceleration, rad/s2.
    pub acceleration_rad_s2: f64,
    /// Jerk, rad/s3.
    pub jerk_rad_s3: f64,
}

impl Move {
    /// The move that we assume for the paper: 20 rad at 40 rad/s, 400 rad/s2, 8000 rad/s3.
    pub const CHOSEN: Move = Move {
        distance_rad: 20.0,
        velocity_rad_s: 40.0,
        acceleration_rad_s2: 400.0,
        jerk_rad_s3: 8000.0,
    };

    /// The same with another distance and speed; acceleration and jerk keep their ratio to the
    /// speed.
    #[must_use]
    pub fn with(self, distance_rad: f64, velocity_rad_s: f64) -> Move {
        let factor = velocity_rad_s / self.velocity_rad_s;
        Move {
            distance_rad,
            velocity_rad_s,
            acceleration_rad_s2: self.acceleration_rad_s2 * factor,
            jerk_rad_s3: self.jerk_rad_s3 * factor,
        }
    }

    /// Durations and jerks of the seven pieces. Where the distance does not allow the highest
    /// speed, the speed is lower.
    fn pieces(&self) -> [(f64, f64); 7] {
        // Time of a speed ramp: jerk up to the acceleration limit, or to the peak that the speed
        // allows, and the hold between.
        let ramp = |v: f64| {
            let a = self.acceleration_rad_s2.min((v * self.jerk_rad_s3).sqrt());
            let rise = a / self.jerk_rad_s3;
            (rise, (v / a - rise).max(0.0))
        };
        // Way of both ramps together: mean speed v/2 over twice the ramp.
        let needed = |v: f64| v * (2.0 * ramp(v).0 + ramp(v).1);
        let (mut low, mut v) = (0.0, self.velocity_rad_s);
        if needed(v) > self.distance_rad {
            // Bisection of the peak speed: the way grows with it; 100 halvings reach rounding.
            for _ in 0..100 {
                let middle = 0.5 * (low + v);
                if needed(middle) > self.distance_rad {
                    v = middle;
                } else {
                    low = middle;
                }
            }
        }
        let (rise, hold) = ramp(v);
        let cruise = ((self.distance_rad - needed(v)) / v).max(0.0);
        let j = self.jerk_rad_s3;
        [
            (rise, j),
            (hold, 0.0),
            (rise, -j),
            (cruise, 0.0),
            (rise, -j),
            (hold, 0.0),
            (rise, j),
        ]
    }

    /// Time of the move, s.
    pub fn duration_s(&self) -> f64 {
        self.pieces().iter().map(|piece| piece.0).sum()
    }

    /// Position, velocity and acceleration at a time since its start.
    fn at(&self, time_s: f64) -> [f64; 3] {
        if time_s >= self.duration_s() {
            return [self.distance_rad, 0.0, 0.0];
        }
        let (mut p, mut v, mut a, mut left) = (0.0, 0.0, 0.0, time_s.max(0.0));
        for (index, (span, j)) in self.pieces().into_iter().enumerate() {
            // Exact integrals of a constant jerk.
            let dt = left.min(span);
            // Exactly zero while cruising, as a planner gives it: the published method compares
            // with zero.
            let from = if index == 3 { 0.0 } else { a };
            p += v * dt + from * dt * dt / 2.0 + j * dt * dt * dt / 6.0;
            v += from * dt + j * dt * dt / 2.0;
            a = from + j * dt;
            left -= dt;
            if left <= 0.0 {
                break;
            }
        }
        [p, v, a]
    }

    /// Setpoints of the whole experiment, one a millisecond.
    pub fn setpoints(&self) -> Vec<Setpoint> {
        let [first, middle, last] = REST_S;
        let duration = self.duration_s();
        let back = first + duration + middle;
        let ticks = ((back + duration + last) / Clock::CNC.period_s()).ceil() as u64;
        (0..ticks)
            .map(|tick| {
                let time = Clock::CNC.seconds(tick);
                let [p, v, a] = self.at(time - first);
                // The way back is the same move, subtracted.
                let [q, w, b] = self.at(time - back);
                if time < back {
                    Setpoint::moving(p, v, a)
                } else {
                    Setpoint::moving(p - q, -w, -b)
                }
            })
            .collect()
    }

    /// When the axis has come to rest and stayed so for a while, after each of the two moves: the
    /// ends of the two rests, s.
    pub fn settled_s(&self) -> [f64; 2] {
        let [first, middle, last] = REST_S;
        // 10 ms before each of the two rests ends.
        let there = first + self.duration_s();
        [
            there + middle - 0.01,
            there + middle + self.duration_s() + last - 0.01,
        ]
    }

    /// When the first move ends, s.
    pub fn first_stop_s(&self) -> f64 {
        REST_S[0] + self.duration_s()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_arrives_within_its_limits() {
        for motion in [
            Move::CHOSEN,
            Move::CHOSEN.with(1.0, 80.0),
            Move::CHOSEN.with(50.0, 10.0),
            Move::CHOSEN.with(0.01, 40.0),
        ] {
            let points = motion.setpoints();
            let most = |value: fn(&Setpoint) -> f64| {
                points
                    .iter()
                    .map(value)
                    .fold(0.0_f64, |most, value| most.max(value.abs()))
            };
            assert!(
                (most(|p| p.position) - motion.distance_rad).abs() < 1e-9,
                "{motion:?}"
            );
            assert!(most(|p| p.velocity.unwrap()) <= motion.velocity_rad_s + 1e-9);
            assert!(most(|p| p.acceleration.unwrap()) <= motion.acceleration_rad_s2 + 1e-9);
            assert!(points.last().unwrap().position.abs() < 1e-9);
            for pair in points.windows(2) {
                let step = pair[1].position - pair[0].position;
                let mean = 0.5 * (pair[0].velocity.unwrap() + pair[1].velocity.unwrap()) * 1e-3;
                assert!(
                    (step - mean).abs() < 1e-9 + motion.jerk_rad_s3 * 1e-9,
                    "{motion:?} {step} {mean}"
                );
            }
        }
    }
}
