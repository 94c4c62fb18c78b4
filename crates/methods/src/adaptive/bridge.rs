//! The balance of momentum from one steady stretch to the next, over anything that lies between.
//!
//! Where short ramps at a large gap keep load and motor apart as long as they accelerate, no steady
//! stretch shows the load's inertia. But the motor's impulse over a reversal has turned motor and
//! load around, whatever bounced meanwhile:
//! ```text
//! sum (K_t i - b_v w - F_M sign(w)) h = (J_M + J_L)(w_2 - w_1) + sum (b_L w + T_f sign(w_L) + T_const) h       N m s
//! ```
//! Both speeds are means over 4 ms at the end of one stretch and the start of the next, where a
//! flank carries the load; the current's sum is weighted to match. How long the load slid in which
//! direction is known except for the time without contact.

use super::watch::Motor;
use lostmotion_base::Clock;
use lostmotion_drive::Signals;
use serde::{Deserialize, Serialize};

/// Bound of the servo ticks of a bridge: 0.5 s. A choice: over a longer reversal the time in which
/// the load was loose says more than the inertia.
const LONGEST_BRIDGE_TICKS: u32 = 2000;
/// Servo ticks for which the sign of the load's speed is unknown in any case. A choice: half a
/// block, so that no bridge counts as certain.
const LEAST_LOOSE_TICKS: u32 = 8;

/// Sums since the last steady stretch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Bridge {
    first: Block,
    /// Where the first stretch ended, rad.
    position: f64,
    ticks: u32,
    /// Sum of the current, ticks times A.
    current: f64,
    /// Sums of the signs of the motor's and of the load's speed; ticks in which the load was loose.
    signs: [f64; 2],
    loose: u32,
}

/// Result of a bridge, means over its time: the change of speed over time (rad/s2), speed (rad/s),
/// sign of the load's speed, torque behind the motor (N m), part of the time in which the load was
/// loose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Crossed {
    pub(super) acceleration: f64,
    pub(super) speed: f64,
    pub(super) sign: f64,
    pub(super) torque: f64,
    pub(super) loose: f64,
}

impl Bridge {
    /// Begins behind the last steady block, with the begun one after it.
    pub(super) fn start(first: Block, rest: &Block) -> Bridge {
        let mut bridge = Bridge {
            first,
            position: rest.position,
            ticks: 0,
            current: 0.0,
            signs: [0.0; 2],
            loose: 0,
        };
        bridge.skip(rest);
        bridge
    }

    /// Adds a block that was not completed; neither motor nor load reversed in it.
    pub(super) fn skip(&mut self, rest: &Block) {
        // its weights add up to one a tick: rising and falling together are the whole current
        self.ticks += rest.ticks;
        self.current += rest.rising + rest.falling;
        let sign = rest.way.signum() * f64::from(rest.ticks);
        self.signs = self.signs.map(|sum| sum + sign);
    }

    /// Adds a tick: the load's speed by the twin (rad/s), and whether the load may be without contact.
    /// Returns whether there is room for more.
    pub(super) fn push(&mut self, signals: &Signals, load_speed: f64, loose: bool) -> bool {
        self.ticks += 1;
        self.current += signals.mean_current;
        // friction depends on the time for which each side slid in which direction
        for (sum, speed) in self
            .signs
            .iter_mut()
            .zip([signals.motor_velocity, load_speed])
        {
            *sum += if speed.abs() > 0.0 {
                speed.signum()
            } else {
                0.0
            };
        }
        self.loose += u32::from(loose);
        self.ticks < LONGEST_BRIDGE_TICKS
    }

    /// Ends with a steady block and the motor's position at its end, rad.
    pub(super) fn end(
        &self,
        last: &Block,
        position: f64,
        motor: &Motor,
        motor_coulomb: f64,
    ) -> Crossed {
        let (block, span) = (
            f64::from(BLOCK_TICKS),
            f64::from(BLOCK_TICKS) * Clock::SERVO.period_s(),
        );
        let ticks = f64::from(self.ticks) + block;
        let time = ticks * Clock::SERVO.period_s();
        // mean speeds of both steady blocks, and the mean position between their middles
        let [before, after] = [
            (self.position - self.first.position) / span,
            (position - last.position) / span,
        ];
        let way = last.position + last.way / block - self.first.position - self.first.way / block;
        let (speed, acceleration) = (way / time, (after - before) / time);
        // the triangles of both blocks count by half: together one whole block
        let ends = 0.5 * block * (before.signum() + after.signum());
        let [motor_sign, sign] = self.signs.map(|sum| (sum + ends) / ticks);
        let current = (self.first.rising + self.current + last.falling) / ticks;
        // torque behind the motor, mean over the bridge
        let own = motor.inertia * acceleration + motor.viscous * speed + motor_coulomb * motor_sign;
        let loose = f64::from(self.loose + LEAST_LOOSE_TICKS) / ticks;
        Crossed {
            acceleration,
            speed,
            sign,
            torque: motor.torque_constant * current - own,
            loose,
        }
    }
}

/// Servo ticks of a block: 4 ms. Decision 59 of the book.
pub(super) const BLOCK_TICKS: u32 = 16;

/// Half of a triangle: sums over 4 ms. Two in a row make means weighted with a triangle over 8 ms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Block {
    pub(super) ticks: u32,
    /// Sums of the current with rising and with falling weights, ticks times A.
    pub(super) rising: f64,
    pub(super) falling: f64,
    /// Position of the motor at its start, sum of those since less that, rad.
    pub(super) position: f64,
    pub(super) way: f64,
}

impl Block {
    /// Begins at a position, rad.
    pub(super) fn start(position: f64) -> Block {
        Block {
            position,
            ..Block::default()
        }
    }

    /// Adds the tick that ends now.
    pub(super) fn push(&mut self, signals: &Signals) {
        // weight of the tick's middle on the rising side, the rest on the falling one
        let part = (f64::from(self.ticks) + 0.5) / f64::from(BLOCK_TICKS);
        self.rising += part * signals.mean_current;
        self.falling += (1.0 - part) * signals.mean_current;
        self.way += signals.motor_position - self.position;
        self.ticks += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inertia_follows_from_a_reversal_in_which_the_load_bounced() {
        let motor = Motor {
            torque_constant: 1.1,
            inertia: 0.002,
            viscous: 0.01,
            rated_torque: 10.0,
            noise: 1e-7,
        };
        let (dt, inertia, friction) = (Clock::SERVO.period_s(), 0.007, 0.4);
        // speed of both from 10 rad/s to -10 rad/s; the torque comes in blows, and only their sum
        // is right
        let (mut position, mut bridge, mut block, mut way) =
            (0.0, None::<Bridge>, Block::start(0.0), 0.0);
        let blows: f64 = (0..100).map(|n| f64::from(n % 7)).sum();
        let mut crossed = None;
        for tick in 0..164_u32 {
            let (steady, turn) = (
                !(32..132).contains(&tick),
                f64::from(tick.clamp(32, 132) - 32) / 100.0,
            );
            let speed = 10.0 - 20.0 * turn;
            let blow = if steady {
                0.0
            } else {
                -20.0 * (motor.inertia + inertia) / dt * f64::from((tick - 32) % 7) / blows
            };
            let after = if steady { speed } else { speed - 0.2 };
            let torque = blow
                + motor.viscous * 0.5 * (speed + after)
                + (0.1 + friction) * (speed - 0.1).signum();
            way = 0.5 * (speed + after) * dt;
            position += way;
            let signals = Signals {
                motor_position: position,
                motor_velocity: speed - 0.1,
                mean_current: torque / motor.torque_constant,
                ..Signals::default()
            };
            if let (Some(bridge), false) = (&mut bridge, steady) {
                assert!(bridge.push(&signals, speed - 0.1, false));
                block = Block::start(position);
                continue;
            }
            block.push(&signals);
            if block.ticks == BLOCK_TICKS {
                match &bridge {
                    None if tick == 31 => {
                        bridge = Some(Bridge::start(block, &Block::start(position)));
                    }
                    Some(bridge) if crossed.is_none() => {
                        crossed = Some(bridge.end(&block, position, &motor, 0.1));
                    }
                    _ => {}
                }
                block = Block::start(position);
            }
        }
        let crossed = crossed.unwrap();
        let found = (crossed.torque - friction * crossed.sign) / crossed.acceleration;
        assert!(
            (found / inertia - 1.0).abs() < 0.02 && way.abs() > 0.0,
            "{found} {crossed:?}"
        );
    }
}
