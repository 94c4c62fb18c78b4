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
//! A motion ends, or begins, somewhere within a command cycle, and the polynomial over that cycle swings
//! past its end by hundredths of a nanometre and back. A control that takes the direction
//! of its reference would see a reversal there, so where a cycle begins or ends at rest the reference
//! stays between its two ends and stands where the polynomial would go back.
//!
//! At a setpoint a derivative that steps there has the value of the piece that ends: what the drive
//! sees up to then.

use crate::config::{AxisConfig, Interpolator};
use crate::error::AxisError;
use crate::signal::{Reference, Setpoint};
use serde::{Deserialize, Serialize};

/// Speed up to which an end of a piece is at rest, rad/s at the motor; the same in a command cycle for an
/// acceleration. A choice: far below any feed, far above the rounding of a setpoint.
const REST_RAD_S: f64 = 1e-6;

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
    /// Whether the reference goes one way between both ends of the piece, since one of them is at rest.
    is_bounded: bool,
    /// The last five positions, the newest last.
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
            is_bounded: false,
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
        // control points that make the B-spline meet the setpoints: p - h^2 a / 6
        let held = if self.interpolator == Interpolator::CompensatedBSpline {
            node.position * self.motor_rad_per_unit - node.acceleration * h * h / 6.0
        } else {
            node.position
        };
        // the newest position last
        state.history.rotate_left(1);
        state.history[4] = held;
        let (piece, to) = self.piece(state, &node);
        // at the setpoint itself the reference is the end of the last piece: a derivative that steps
        // there is seen to step afterwards
        (state.piece, state.start) = (piece, state.end);
        state.end = self.end(&piece, to.as_ref());
        state.to = to.unwrap_or(node);
        state.is_bounded = self.rests(&state.start) || self.rests(&state.end);
        Ok(())
    }

    /// Whether a piece that has this end begins or ends at rest.
    fn rests(&self, end: &Reference) -> bool {
        let stands = end.velocity.abs() <= REST_RAD_S;
        match self.interpolator {
            Interpolator::QuinticHermite | Interpolator::QuinticDifferences => {
                stands && (end.acceleration * self.period_s).abs() <= REST_RAD_S
            }
            // accelerations at its ends are its own, not the motion's
            Interpolator::CubicHermite => stands,
            // go through their own middles, not through their ends
            Interpolator::Linear
            | Interpolator::CubicDifferences
            | Interpolator::CatmullRom
            | Interpolator::BSpline
            | Interpolator::CompensatedBSpline => false,
        }
    }

    fn node(&self, tick: u64, setpoint: &Setpoint) -> Result<Node, AxisError> {
        let position = finite(tick, "position", setpoint.position)?;
        // a derivative counts only for interpolators that use it, and is then required
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
            // needs the setpoint after its piece, which therefore lies one setpoint back
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
    pub fn at(&self, state: &SplineState, index: u32, count: u32) -> Reference {
        if index == 0 {
            return state.start;
        }
        if index >= count {
            return state.end;
        }
        let mut reference = state
            .piece
            .at(f64::from(index) / f64::from(count), self.period_s);
        if state.is_bounded {
            state.bound(&mut reference);
        }
        reference
    }

    /// The same at all servo ticks of the present piece, one more than it has: the last is its end.
    #[inline(always)]
    pub fn fill(&self, state: &SplineState, references: &mut [Reference]) {
        // ends come from the nodes, not from the polynomial's rounding
        let [first, within @ .., last] = references else {
            return;
        };
        (*first, *last) = (state.start, state.end);
        let count = (within.len() + 1) as f64;
        let mut index = 0.0;
        for reference in within.iter_mut() {
            index += 1.0;
            *reference = state.piece.at(index / count, self.period_s);
        }
        if state.is_bounded {
            within
                .iter_mut()
                .for_each(|reference| state.bound(reference));
        }
    }
}

impl SplineState {
    /// Keeps a reference between the ends of its piece, and where it would go back at rest.
    fn bound(&self, reference: &mut Reference) {
        let ends = [self.start.position, self.end.position];
        let [least, most] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let way = ends[1] - ends[0];
        let is_within = (least..=most).contains(&reference.position);
        if !is_within || reference.velocity * way < 0.0 {
            *reference = Reference {
                position: reference.position.clamp(least, most),
                velocity: 0.0,
                acceleration: 0.0,
            };
        }
    }
}

fn finite(tick: u64, what: &'static str, value: f64) -> Result<f64, AxisError> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(AxisError::SetpointNotFinite { tick, what, value })
    }
}

// The polynomial between two setpoints.

/// A setpoint with its derivatives: position in the axis' unit, derivatives at the motor; none is
/// 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Node {
    pub(super) position: f64,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
}

/// Position at the motor by the part u of the period: `base + c1 u + c2 u^2 + ... + c5 u^5`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Piece {
    base: f64,
    c: [f64; 5],
}

impl Piece {
    pub(super) fn standing(base: f64) -> Piece {
        Piece { base, c: [0.0; 5] }
    }

    /// Quintic that meets both nodes with both derivatives.
    pub(super) fn quintic(from: &Node, to: &Node, factor: f64, h: f64) -> Piece {
        let (v0, a0) = (from.velocity * h, from.acceleration * h * h);
        // what is left of the end values after the quadratic of the start is taken off
        let position = (to.position - from.position) * factor - v0 - 0.5 * a0;
        let velocity = to.velocity * h - v0 - a0;
        let acceleration = to.acceleration * h * h - a0;
        Piece {
            base: from.position * factor,
            c: [
                v0,
                0.5 * a0,
                10.0 * position - 4.0 * velocity + 0.5 * acceleration,
                -15.0 * position + 7.0 * velocity - acceleration,
                6.0 * position - 3.0 * velocity + 0.5 * acceleration,
            ],
        }
    }

    /// Cubic over a way with a speed at both ends, both for the whole period.
    pub(super) fn hermite(base: f64, way: f64, [v0, v1]: [f64; 2]) -> Piece {
        Piece {
            base,
            c: [v0, 3.0 * way - 2.0 * v0 - v1, v0 + v1 - 2.0 * way, 0.0, 0.0],
        }
    }

    /// Straight.
    pub(super) fn line(base: f64, way: f64) -> Piece {
        Piece {
            base,
            c: [way, 0.0, 0.0, 0.0, 0.0],
        }
    }

    /// Uniform cubic B-spline between the second and the third of four control points, which are
    /// given from `base` on.
    pub(super) fn b_spline(base: f64, [q0, q1, q2, q3]: [f64; 4]) -> Piece {
        // the basis functions as powers of u
        let start = (q0 + 4.0 * q1 + q2) / 6.0;
        let c = [
            0.5 * (q2 - q0),
            0.5 * (q0 + q2) - q1,
            (q3 - q0 + 3.0 * (q1 - q2)) / 6.0,
            0.0,
            0.0,
        ];
        Piece {
            base: base + start,
            c,
        }
    }

    /// Where it is at a part of the period of length `h`.
    #[inline]
    pub(super) fn at(&self, u: f64, h: f64) -> Reference {
        let [c1, c2, c3, c4, c5] = self.c;
        // Horner; derivatives by u, so divided by the period
        let way = u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))));
        Reference {
            position: self.base + way,
            velocity: (c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * (5.0 * c5))))) / h,
            acceleration: (2.0 * c2 + u * (6.0 * c3 + u * (12.0 * c4 + u * (20.0 * c5)))) / (h * h),
        }
    }
}
