//! From setpoints to references at every servo tick: a polynomial from setpoint to setpoint
//! ([`Interpolator`]).
//!
//! All are local: a setpoint changes only the few pieces next to it. By default it is the quintic
//! that meets position, velocity and acceleration at both its ends; so velocity and acceleration
//! are continuous across pieces, and a motion of constant jerk is met exactly.
//!
//! Delay: the piece that ends at setpoint n runs from its arrival to that of setpoint n + 1, so the
//! reference at a servo tick belongs to the setpoint time one command cycle earlier. What needs the
//! setpoint after the piece lies two cycles back. The five-point differences of
//! `quintic-differences` put the node two cycles further back (three in all):
//! ```text
//! v = (p[-2] - 8 p[-1] + 8 p[1] - p[2]) / (12 h)
//! a = (-p[-2] + 16 p[-1] - 30 p[0] + 16 p[1] - p[2]) / (12 h^2)
//! ```
//! exact for polynomials of degree four in v and five in a. Differences amplify rounding of the
//! positions by up to 5/h^2: positions written with six decimals of a millimetre make accelerations
//! uncertain by some mm/s2.
//!
//! At a setpoint a derivative that steps there has the value of the piece that ends: what the drive
//! sees up to then.

mod piece;

use crate::config::{AxisConfig, Interpolator};
use crate::error::AxisError;
use crate::signal::{Reference, Setpoint};
use piece::{Node, Piece};
use serde::{Deserialize, Serialize};

/// The spline of an axis.
#[derive(Clone, Copy, Debug)]
pub struct Spline {
    motor_rad_per_unit: f64,
    interpolator: Interpolator,
    period_s: f64,
}

/// State of the spline: the present piece with its ends, the node it ends at, and as many setpoints
/// as the next ones need.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SplineState {
    piece: Piece,
    start: Reference,
    end: Reference,
    to: Node,
    /// The last five positions, the newest last.
    history: [f64; 5],
    tick: u64,
}

impl SplineState {
    /// Setpoints taken so far.
    pub fn ticks(&self) -> u64 {
        self.tick
    }

    /// The reference at the end of the present piece.
    pub(crate) fn end(&self) -> Reference {
        self.end
    }
}

impl Spline {
    /// The spline of an axis.
    pub fn new<C>(config: &AxisConfig<C>) -> Spline {
        Spline {
            motor_rad_per_unit: config.transmission.motor_rad_per_unit(),
            interpolator: config.interpolator,
            period_s: config.cycles.command().period_s(),
        }
    }

    /// Command cycles from a setpoint's arrival to the reference reaching it.
    pub fn delay_ticks(&self) -> u32 {
        self.interpolator.delay_cycles()
    }

    /// Standing at a position, in the axis' unit.
    pub fn initial(&self, start: f64) -> SplineState {
        let rest = Reference {
            position: start * self.motor_rad_per_unit,
            velocity: 0.0,
            acceleration: 0.0,
        };
        // the B-spline's history holds control points at the motor
        let held = if self.interpolator == Interpolator::CompensatedBSpline {
            rest.position
        } else {
            start
        };
        SplineState {
            piece: Piece::standing(rest.position),
            start: rest,
            end: rest,
            to: Node {
                position: start,
                velocity: 0.0,
                acceleration: 0.0,
            },
            history: [held; 5],
            tick: 0,
        }
    }

    /// Takes the next setpoint and moves on to the next piece.
    ///
    /// # Errors
    /// A number that is not finite; a missing velocity or acceleration where they have to come
    /// along. The state is then as before.
    pub fn push(&self, state: &mut SplineState, setpoint: &Setpoint) -> Result<(), AxisError> {
        let node = self.node(state.tick, setpoint)?;
        state.tick += 1;
        let h = self.period_s;
        let held = if self.interpolator == Interpolator::CompensatedBSpline {
            node.position * self.motor_rad_per_unit - node.acceleration * h * h / 6.0
        } else {
            node.position
        };
        state.history.rotate_left(1);
        state.history[4] = held;
        let (piece, to) = self.piece(state, &node);
        (state.piece, state.start) = (piece, state.end);
        state.end = self.end(&piece, to.as_ref());
        state.to = to.unwrap_or(node);
        Ok(())
    }

    fn node(&self, tick: u64, setpoint: &Setpoint) -> Result<Node, AxisError> {
        let position = finite(tick, "position", setpoint.position)?;
        let at_motor = |needed: bool, what: &'static str, value: Option<f64>| match value {
            _ if !needed => Ok(0.0),
            Some(value) => Ok(finite(tick, what, value)? * self.motor_rad_per_unit),
            None => Err(AxisError::SetpointIncomplete { tick, what }),
        };
        Ok(Node {
            position,
            velocity: at_motor(
                self.interpolator.needs_velocity(),
                "velocity",
                setpoint.velocity,
            )?,
            acceleration: at_motor(
                self.interpolator.needs_acceleration(),
                "acceleration",
                setpoint.acceleration,
            )?,
        })
    }

    /// The next piece, and the node that it ends at where that holds exactly.
    fn piece(&self, state: &SplineState, node: &Node) -> (Piece, Option<Node>) {
        let (factor, h, [_, p0, p1, p2, p3]) =
            (self.motor_rad_per_unit, self.period_s, state.history);
        // differences first, so that a far origin costs no digits
        let way = |from: f64, to: f64| (to - from) * factor;
        match self.interpolator {
            Interpolator::Linear => (Piece::line(p2 * factor, way(p2, p3)), None),
            Interpolator::CubicDifferences => (
                Piece::hermite(p2 * factor, way(p2, p3), [way(p1, p2), way(p2, p3)]),
                None,
            ),
            Interpolator::CatmullRom => (
                Piece::hermite(
                    p1 * factor,
                    way(p1, p2),
                    [0.5 * way(p0, p2), 0.5 * way(p1, p3)],
                ),
                None,
            ),
            Interpolator::CubicHermite => (
                Piece::hermite(
                    p2 * factor,
                    way(p2, p3),
                    [state.to.velocity * h, node.velocity * h],
                ),
                None,
            ),
            Interpolator::BSpline => (
                Piece::b_spline(p1 * factor, [way(p1, p0), 0.0, way(p1, p2), way(p1, p3)]),
                None,
            ),
            Interpolator::CompensatedBSpline => {
                (Piece::b_spline(p1, [p0 - p1, 0.0, p2 - p1, p3 - p1]), None)
            }
            Interpolator::QuinticHermite => {
                (Piece::quintic(&state.to, node, factor, h), Some(*node))
            }
            Interpolator::QuinticDifferences => {
                let to = self.node_between_neighbours(&state.history);
                (Piece::quintic(&state.to, &to, factor, h), Some(to))
            }
        }
    }

    /// The reference at a piece's end: that of the node where it is met exactly.
    fn end(&self, piece: &Piece, node: Option<&Node>) -> Reference {
        node.map_or_else(
            || piece.at(1.0, self.period_s),
            |node| Reference {
                position: node.position * self.motor_rad_per_unit,
                velocity: node.velocity,
                acceleration: node.acceleration,
            },
        )
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

    /// Reference at servo tick `index` of `count` in the present piece; `index == count` is its
    /// end.
    #[inline]
    pub fn at(&self, state: &SplineState, index: u32, count: u32) -> Reference {
        if index == 0 {
            return state.start;
        }
        if index >= count {
            return state.end;
        }
        state
            .piece
            .at(f64::from(index) / f64::from(count), self.period_s)
    }
}

fn finite(tick: u64, what: &'static str, value: f64) -> Result<f64, AxisError> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(AxisError::SetpointNotFinite { tick, what, value })
    }
}
