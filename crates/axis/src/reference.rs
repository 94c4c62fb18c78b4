//! From 1 ms setpoints to 250 us references: a quintic spline that needs one piece at a time.
//!
//! Between two setpoints the position is the polynomial of degree five that meets position, velocity and acceleration at both; so
//! velocity and acceleration are continuous across pieces, and a motion of constant jerk is met exactly. It is local: a
//! setpoint changes only the two pieces it ends.
//!
//! Delay: the piece that ends at setpoint n runs from its arrival to that of setpoint n + 1, so the reference at a servo tick belongs to
//! the setpoint time one CNC period earlier. If velocity and acceleration have to be taken from neighbours, the node lies two
//! periods further back (3 ms in all):
//! ```text
//! v = (p[-2] - 8 p[-1] + 8 p[1] - p[2]) / (12 h)
//! a = (-p[-2] + 16 p[-1] - 30 p[0] + 16 p[1] - p[2]) / (12 h^2)
//! ```
//! exact for polynomials of degree four in v and five in a. Differences amplify rounding of the positions by up to 5/h^2: positions written
//! with six decimals of a millimetre make accelerations uncertain by some mm/s2.

use crate::config::{AxisConfig, ReferenceSource};
use crate::error::AxisError;
use crate::signal::{Reference, Setpoint};
use lostmotion_base::Clock;
use serde::{Deserialize, Serialize};

/// The spline of an axis.
#[derive(Clone, Copy, Debug)]
pub struct Spline {
    motor_rad_per_unit: f64,
    source: ReferenceSource,
    period_s: f64,
}

/// A setpoint with its derivatives: position in the axis' unit, derivatives at the motor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Node {
    position: f64,
    velocity: f64,
    acceleration: f64,
}

/// State of the spline: the present piece, and as many positions as the differences need.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SplineState {
    from: Node,
    to: Node,
    cubic_and_up: [f64; 3],
    history: [f64; 5],
    tick: u64,
}

impl SplineState {
    /// Setpoints taken so far.
    pub fn ticks(&self) -> u64 {
        self.tick
    }
}

impl Spline {
    /// The spline of an axis.
    pub fn new(config: &AxisConfig) -> Spline {
        Spline { motor_rad_per_unit: config.transmission.motor_rad_per_unit(), source: config.reference, period_s: Clock::CNC.period_s() }
    }

    /// CNC periods from a setpoint's arrival to the reference reaching it.
    pub fn delay_ticks(&self) -> u32 {
        match self.source {
            ReferenceSource::SentAlong => 1,
            ReferenceSource::Differences => 3,
        }
    }

    /// Standing at a position, in the axis' unit.
    pub fn initial(&self, start: f64) -> SplineState {
        let node = Node { position: start, velocity: 0.0, acceleration: 0.0 };
        SplineState { from: node, to: node, cubic_and_up: [0.0; 3], history: [start; 5], tick: 0 }
    }

    /// Takes the next setpoint and moves on to the next piece.
    ///
    /// # Errors
    /// A number that is not finite; a missing velocity or acceleration where they have to come along. The state is then as before.
    pub fn push(&self, state: &mut SplineState, setpoint: &Setpoint) -> Result<(), AxisError> {
        let tick = state.tick;
        let position = finite(tick, "position", setpoint.position)?;
        let to = match self.source {
            ReferenceSource::SentAlong => {
                let velocity = setpoint.velocity.ok_or(AxisError::SetpointIncomplete { tick, what: "velocity" })?;
                let acceleration = setpoint.acceleration.ok_or(AxisError::SetpointIncomplete { tick, what: "acceleration" })?;
                Node {
                    position,
                    velocity: finite(tick, "velocity", velocity)? * self.motor_rad_per_unit,
                    acceleration: finite(tick, "acceleration", acceleration)? * self.motor_rad_per_unit,
                }
            }
            ReferenceSource::Differences => {
                state.history.rotate_left(1);
                state.history[4] = position;
                self.node_between_neighbours(&state.history)
            }
        };
        state.tick += 1;
        state.from = state.to;
        state.to = to;
        state.cubic_and_up = self.upper_coefficients(&state.from, &state.to);
        Ok(())
    }

    fn node_between_neighbours(&self, p: &[f64; 5]) -> Node {
        let h = self.period_s;
        // differences to the middle first, so that a far origin costs no digits
        let d = p.map(|position| (position - p[2]) * self.motor_rad_per_unit);
        Node {
            position: p[2],
            velocity: ((d[0] - d[4]) + 8.0 * (d[3] - d[1])) / (12.0 * h),
            acceleration: (16.0 * (d[1] + d[3]) - (d[0] + d[4])) / (12.0 * h * h),
        }
    }

    /// Coefficients of u^3, u^4, u^5, u the part of the period.
    fn upper_coefficients(&self, from: &Node, to: &Node) -> [f64; 3] {
        let h = self.period_s;
        let (v0, a0) = (from.velocity * h, from.acceleration * h * h);
        let position = (to.position - from.position) * self.motor_rad_per_unit - v0 - 0.5 * a0;
        let velocity = to.velocity * h - v0 - a0;
        let acceleration = to.acceleration * h * h - a0;
        [
            10.0 * position - 4.0 * velocity + 0.5 * acceleration,
            -15.0 * position + 7.0 * velocity - acceleration,
            6.0 * position - 3.0 * velocity + 0.5 * acceleration,
        ]
    }

    /// Reference at servo tick `index` of `count` in the present piece; `index == count` is its end.
    #[inline]
    pub fn at(&self, state: &SplineState, index: u32, count: u32) -> Reference {
        let node = if index == 0 { &state.from } else { &state.to };
        if index == 0 || index >= count {
            return Reference {
                position: node.position * self.motor_rad_per_unit,
                velocity: node.velocity,
                acceleration: node.acceleration,
            };
        }
        let (from, h) = (&state.from, self.period_s);
        let u = f64::from(index) / f64::from(count);
        let [c3, c4, c5] = state.cubic_and_up;
        let (c1, c2) = (from.velocity * h, 0.5 * from.acceleration * h * h);
        let way = u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))));
        Reference {
            position: from.position * self.motor_rad_per_unit + way,
            velocity: (c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * (5.0 * c5))))) / h,
            acceleration: (2.0 * c2 + u * (6.0 * c3 + u * (12.0 * c4 + u * (20.0 * c5)))) / (h * h),
        }
    }
}

fn finite(tick: u64, what: &'static str, value: f64) -> Result<f64, AxisError> {
    if value.is_finite() { Ok(value) } else { Err(AxisError::SetpointNotFinite { tick, what, value }) }
}
