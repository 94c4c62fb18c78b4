//! Operations that make several moves: splines as polynomials by length, and rigid tapping there
//! and back.

use super::bend::{Stretch, stretches, whole_length};
use super::spline::Spline;
use super::{Bend, MotionFold, MotionItem, PathMode};
use crate::ops::{ArcFeed, CanonicalOp, NurbsFeed, Position, SourcedOp};
use crate::problem::Problem;
use lostmotion_base::math;
use lostmotion_base::span::BlockRef;
use lostmotion_base::vec::Vec2;
use std::f64::consts::TAU;

/// How far the polynomials may lie from the spline that they stand for, unless told otherwise.
pub const SPLINE_TOLERANCE_MM: f64 = 0.001;

/// Largest distance between the ends of an arc that counts as a full circle, program units. Derived:
/// far above the rounding of machine coordinates and back.
const CLOSED_ARC_GAP: f64 = 1e-9;

/// Most lines that stand for one arc of a tilted plane.
const MOST_ARC_LINES: f64 = 1e6;

/// Length of a curve in the unit of its points; `None` if it has too few.
pub(crate) fn curve_length(curve: &NurbsFeed) -> Option<f64> {
    // Lengths scale with the unit: program units in, program units out.
    let points = curve.points.iter().map(|point| (point.at, point.weight));
    Spline::new(points, curve.order as usize).map(|spline| whole_length(&spline))
}

impl MotionFold {
    /// Takes one operation and adds what it makes the machine do.
    ///
    /// A spline becomes moves with a [`Bend`] that keep its ends, its directions and curvatures
    /// there, and stay within the tolerance of [`MotionFold::with_spline_tolerance_mm`]. Rigid
    /// tapping goes down and comes back at the programmed spindle speed, with a stop at either end,
    /// where the spindle is taken to reverse.
    ///
    /// # Errors
    /// As [`MotionFold::push`], but for splines and rigid tapping.
    pub fn push_all(
        &mut self,
        sourced: &SourcedOp,
        out: &mut impl Extend<MotionItem>,
    ) -> Result<(), Problem> {
        match &sourced.op {
            CanonicalOp::NurbsFeed(curve) => self.curve(curve, sourced.block, out),
            CanonicalOp::ArcFeed(arc) if self.tilts(arc.plane) => {
                self.tilted_arc(arc, sourced.block, out)
            }
            CanonicalOp::RigidTap(end) => self.tap(*end, sourced.block, out),
            _ => {
                out.extend(self.push(sourced)?);
                Ok(())
            }
        }
    }

    fn curve(
        &mut self,
        curve: &NurbsFeed,
        block: BlockRef,
        out: &mut impl Extend<MotionItem>,
    ) -> Result<(), Problem> {
        // In the program's plane, mm: coordinates may be turned and tilted.
        let mm = self.units.mm();
        let points = curve
            .points
            .iter()
            .map(|point| (point.at.map(|place| place * mm), point.weight));
        let spline = Spline::new(points, curve.order as usize).ok_or(Problem::CurvePoints {
            points: curve.points.len(),
            order: curve.order,
        })?;
        // Approximate every span, then bring the parts into machine coordinates.
        let feed = self.arc_feed()?;
        let mut parts: Vec<Stretch> = Vec::new();
        for span in 0..spline.spans() {
            stretches(
                &spline,
                span,
                [span as f64, (span + 1) as f64],
                self.spline_tolerance_mm,
                0,
                &mut parts,
            );
        }
        // Each part takes its share of an inverse-time duration by its length.
        let whole: f64 = parts.iter().map(Stretch::length).sum();
        let place = |fold: &MotionFold, [x, y]: Vec2| {
            let mut place = curve.end;
            (place[0], place[1]) = (x / mm, y / mm);
            fold.machine(&place)
        };
        // Directions are differences of places: the shifts cancel.
        let origin = place(self, [0.0; 2]);
        let count = parts.len();
        for (index, part) in parts.into_iter().enumerate() {
            // The last one ends exactly where the curve does.
            let to = if index + 1 < count {
                place(self, part.end)
            } else {
                self.machine(&curve.end)
            };
            let turned = |vector: Vec2| (place(self, vector) - origin).linear();
            let bend = part.bend.map(|bent| Bend {
                tangents: bent.tangents.map(turned),
                curvatures_per_mm: bent.curvatures.map(turned),
                length_mm: bent.length,
            });
            let mut item = self.advance(to, None, feed, block);
            if let MotionItem::Move(motion) = &mut item {
                motion.bend = bend;
                motion.duration_s = motion
                    .duration_s
                    .map(|seconds| seconds * part.length() / whole);
            }
            out.extend([item]);
        }
        Ok(())
    }

    /// An arc in a plane that is turned or tilted, as lines within the tolerance of splines.
    fn tilted_arc(
        &mut self,
        arc: &ArcFeed,
        block: BlockRef,
        out: &mut impl Extend<MotionItem>,
    ) -> Result<(), Problem> {
        let mut start = self.program_place();
        let end = arc.position();
        let [first, second, _] = arc.plane.axes();
        // There and back through the machine's coordinates, the start of a full circle is its end
        // but for rounding.
        if (start[first] - end[first]).abs() + (start[second] - end[second]).abs() < CLOSED_ARC_GAP
        {
            (start[first], start[second]) = (end[first], end[second]);
        }
        // Radius vectors at both ends; a spiral has two radii.
        let from = [start[first] - arc.center[0], start[second] - arc.center[1]];
        let to = [end[first] - arc.center[0], end[second] - arc.center[1]];
        let radii = [math::hypot(from[0], from[1]), math::hypot(to[0], to[1])];
        // Sweep of the last turn in the direction of travel, plus the whole turns before it.
        let way = if arc.turns > 0 { 1.0 } else { -1.0 };
        let turn = way
            * math::atan2(
                from[0] * to[1] - from[1] * to[0],
                from[0] * to[0] + from[1] * to[1],
            );
        let turn = if turn <= 0.0 { turn + TAU } else { turn };
        let sweep = turn + TAU * f64::from(arc.turns.unsigned_abs().saturating_sub(1));
        let largest = radii[0].max(radii[1]) * self.units.mm();
        // The sagitta of a chord over an angle a is r (1 - cos(a / 2)).
        let share = (self.spline_tolerance_mm / largest).min(1.0);
        let pieces = (sweep / (2.0 * math::acos(1.0 - share)))
            .ceil()
            .clamp(1.0, MOST_ARC_LINES);
        let feed = self.arc_feed()?;
        let angle = math::atan2(from[1], from[0]);
        for piece in 1..=(pieces as u64) {
            let part = piece as f64 / pieces;
            // All other axes move evenly with the angle.
            let mut place: Position =
                std::array::from_fn(|axis| start[axis] + part * (end[axis] - start[axis]));
            // Radius and height change evenly with the angle: a spiral or helix.
            if part < 1.0 {
                let radius = radii[0] + part * (radii[1] - radii[0]);
                let (sin, cos) = math::sin_cos(angle + way * part * sweep);
                (place[first], place[second]) =
                    (arc.center[0] + radius * cos, arc.center[1] + radius * sin);
            }
            let to = self.machine(&place);
            let mut item = self.advance(to, None, feed, block);
            if let MotionItem::Move(motion) = &mut item {
                motion.duration_s = motion.duration_s.map(|seconds| seconds / pieces);
            }
            out.extend([item]);
        }
        Ok(())
    }

    fn tap(
        &mut self,
        end: [f64; 3],
        block: BlockRef,
        out: &mut impl Extend<MotionItem>,
    ) -> Result<(), Problem> {
        let top = self.at;
        // Rotary and secondary axes stay where they are.
        let mut place = [0.0; 9];
        place[..3].copy_from_slice(&end);
        let machine = self.machine(&place);
        let mut bottom = top;
        bottom.0[..3].copy_from_slice(&machine.0[..3]);
        // Down and back, with a stop at either end where the spindle reverses.
        for to in [bottom, top] {
            let feed = self.feed(&to, "G33.1")?;
            let mut item = self.advance(to, None, feed, block);
            if let MotionItem::Move(motion) = &mut item {
                motion.path = PathMode::ExactStop;
            }
            out.extend([item]);
        }
        Ok(())
    }
}
