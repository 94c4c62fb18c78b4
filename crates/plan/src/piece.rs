//! Pieces and stops of the conditioned path, and how deviations from it are measured.

use crate::Heeds;
use lostmotion_base::units::deg;
use lostmotion_base::vec::norm;
use lostmotion_base::{BlockRef, Coords};
use lostmotion_path::{Curve, CurveDerivs, HermiteEnd};
use std::sync::Arc;

/// Which programmed move lies under a stretch of a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mark {
    /// Where the stretch begins on the piece.
    pub(crate) from: f64,
    /// Running number of the move.
    pub(crate) segment: u64,
    /// Parameter on the programmed curve there.
    pub(crate) s: f64,
    /// How fast it grows with the parameter of the piece.
    pub(crate) rate: f64,
    pub(crate) block: BlockRef,
}

/// A piece of the path that is really travelled: part of a programmed curve, a blend, or a piece of
/// a smoothed run. Consecutive pieces between two stops agree in position and the first two
/// derivatives by their parameter.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub(crate) curve: Curve,
    /// The moves under it: one, or two for a blend; the first and the last one where there are more.
    pub(crate) marks: [Mark; 2],
    /// All of the moves under it where there are more than two, in their order.
    pub(crate) more: Box<[Mark]>,
    /// Largest speed of the parameter that the feed allows where the tip moves at unit speed, 1/s.
    pub(crate) feed: f64,
    pub(crate) heeds: Heeds,
    pub(crate) tool_mm: [f64; 3],
}

impl Piece {
    /// Whether the feed counts for the tip alone, given the velocity: on a curve that moves nothing
    /// else the parameter goes as it likes.
    pub(crate) fn goes_by_tip(&self, velocity: &Coords) -> bool {
        matches!(self.curve, Curve::Quintic(_)) && velocity.0[3..].iter().all(|v| *v == 0.0)
    }

    /// The speed that the feed counts for, given the velocity and the speed of the parameter: that of
    /// the tip or the parameter, whichever is larger.
    pub(crate) fn fed_speed(&self, velocity: &Coords, parameter: f64) -> f64 {
        let tip = velocity.linear_norm();
        if self.goes_by_tip(velocity) {
            tip
        } else {
            tip.max(parameter)
        }
    }

    /// The move under a place on the piece, and the parameter on its curve.
    pub(crate) fn programmed(&self, local: f64) -> (Mark, f64) {
        let [first, second] = self.marks;
        let mark = if local >= second.from {
            second
        } else if self.more.is_empty() {
            first
        } else {
            let next = self.more.partition_point(|mark| mark.from <= local);
            self.more[next.max(1) - 1]
        };
        (mark, mark.s + mark.rate * (local - mark.from))
    }
}

/// The end of a motion at rest at which less jerk is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Soft {
    /// Part of the jerk that is used.
    pub(crate) part: f64,
    /// For how long, s.
    pub(crate) time_s: f64,
}

/// Coming to rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Stop {
    /// How long to stand still, s.
    pub(crate) dwell_s: f64,
    /// How far the tool may leave the path here, mm, to set out again before it has come to rest;
    /// `None` if it has to come to rest.
    pub(crate) tolerance: Option<f64>,
    /// How soft the motions before and after it should be for that.
    pub(crate) soft: Option<Soft>,
}

/// One output of the conditioner.
#[derive(Clone, Debug)]
pub(crate) enum PathStep {
    Piece(Arc<Piece>),
    Stop(Stop),
}

/// A move with what the conditioner has to know about it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Programmed {
    pub(crate) curve: Curve,
    pub(crate) length: f64,
    /// Largest speed of the parameter, 1/s.
    pub(crate) feed: f64,
    pub(crate) heeds: Heeds,
    pub(crate) control: crate::PathControl,
    pub(crate) tool_mm: [f64; 3],
    pub(crate) segment: u64,
    pub(crate) block: BlockRef,
}

impl Programmed {
    pub(crate) fn mark(&self, from: f64, s: f64) -> Mark {
        Mark {
            from,
            segment: self.segment,
            s,
            rate: 1.0,
            block: self.block,
        }
    }

    /// The programmed curve itself at a place, as the end of another.
    pub(crate) fn state(&self, s: f64) -> HermiteEnd {
        let CurveDerivs { p, d1, d2, .. } = self.curve.eval(s);
        HermiteEnd { p, d1, d2 }
    }

    /// The part from `s0` to `s1` as a piece.
    pub(crate) fn part(&self, s0: f64, s1: f64) -> Piece {
        let curve = if s0 <= 0.0 && s1 >= self.length {
            self.curve
        } else {
            self.curve.sub(s0, s1)
        };
        Piece {
            curve,
            marks: [self.mark(0.0, s0); 2],
            more: Box::default(),
            feed: self.feed,
            heeds: self.heeds,
            tool_mm: self.tool_mm,
        }
    }
}

/// Size of a difference between two points: mm of X Y Z, of U V W, or degrees of A B C, whichever
/// is largest. A tolerance of x mm allows the rotary axes x degrees, as the feed rule
/// treats them alike.
pub(crate) fn size(delta: &Coords) -> f64 {
    let [.., u, v, w] = delta.0;
    delta
        .linear_norm()
        .max(norm([u, v, w]))
        .max(deg(norm(delta.rotary())))
}

/// How far from the line along `other` a step along `d` leads at most, per unit of the step.
pub(crate) fn sideways(d: &Coords, other: &Coords) -> f64 {
    let along = (d.dot(other) / other.dot(other)).clamp(0.0, 1.0);
    size(&(*d - *other * along)).min(size(d))
}

/// Part of the tolerance within which the corner is passed: the chord between two samples lies
/// beside the path. A choice: at 1000 mm/s2 and 1 ms that is 0.2 um, two parts of a thousand of
/// 0.1 mm.
const CORNER_PART: f64 = 0.998;

/// How far from a corner two motions that add up may be at the same time, as parameters of their
/// lines, given its directions d and e: neither line is left by more than the tolerance, and
/// the tool passes the corner itself within it.
pub(crate) fn corner_reach(d: &Coords, e: &Coords, tolerance: f64) -> f64 {
    // At equal distances x the tool is x |e - d| from the corner.
    let off = sideways(e, d)
        .max(sideways(d, e))
        .max(size(&(*e - *d)) / CORNER_PART);
    tolerance / off.max(f64::MIN_POSITIVE)
}
