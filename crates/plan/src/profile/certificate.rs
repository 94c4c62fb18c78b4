//! Proof that a motion keeps the limits at every time, not only where it is evaluated.
//!
//! On a stretch of constant jerk over one piece of path a joint's place is a smooth function of
//! time whose derivatives up to the fifth are bounded by those of the curve. A function stays
//! within h2/8 times its largest second derivative of the chord of its ends, which bounds velocity,
//! acceleration and jerk from their values at both ends of a time h; where that is not enough, h is
//! halved. Where a kinematics bends the path, the joints' fourth and fifth derivatives are not
//! known: the middle's distance from the chord stands for the bound.

use super::Section;
use super::course::{JointCourse, JointPlace, KEPT_SHARE};
use crate::demand::JointDerivs;
use crate::motion::{Knot, PathState};
use lostmotion_base::AXES;
use lostmotion_kinematics::JointMap;

/// Halvings of a stretch in search of a proof, at most: each takes three quarters of the distance
/// from the chord.
const PROOF_HALVINGS: u32 = 10;
/// A time that is no longer than this, s, is rounding of where pieces and knots meet: no jerk
/// changes an acceleration in it.
const ROUNDING_S: f64 = 1e-10;

/// Used parts of the limits of velocity (feed included), acceleration and jerk.
pub(super) type Used = [f64; 3];

/// A joint's velocity, acceleration and jerk.
type JointStates = [[f64; 3]; AXES];

/// Goes along a section and bounds what a motion over it uses.
#[derive(Debug)]
pub(crate) struct Certificate<'a> {
    section: &'a Section<'a>,
    course: JointCourse<'a>,
    /// The place evaluated last, with its time: the end of one stretch is mostly the start of the
    /// next.
    last: Option<(f64, JointPlace)>,
}

/// One end of a stretch.
#[derive(Clone, Copy)]
struct StretchEnd {
    t: f64,
    motion: PathState,
    place: JointPlace,
    state: JointStates,
    /// Speed of the tip.
    tip: f64,
}

fn worse(a: Used, b: Used) -> Used {
    [a[0].max(b[0]), a[1].max(b[1]), a[2].max(b[2])]
}

impl<'a> Certificate<'a> {
    pub(crate) fn new(section: &'a Section<'a>) -> Certificate<'a> {
        Certificate {
            section,
            course: JointCourse::new(section),
            last: None,
        }
    }

    /// Bounds of the used parts over consecutive knots, of which the last one is only an end;
    /// `None` for a pose that the machine cannot take.
    pub(super) fn most(&mut self, knots: &[Knot]) -> Option<Used> {
        let mut most = [0.0; 3];
        for pair in knots.windows(2) {
            let mut from = pair[0].t;
            if self.course.find(pair[0].s) {
                self.last = None;
            }
            // Each piece by itself: third derivatives of the path step where pieces meet.
            while from < pair[1].t {
                // Up to where the next piece begins.
                let to = self
                    .course
                    .next()
                    .map_or(pair[1].t, |next| pair[0].time_at(next, from, pair[1].t));
                if to - from > ROUNDING_S {
                    let left = self.end(&pair[0], from)?;
                    let right = self.end(&pair[0], to)?;
                    self.last = Some((to, right.place));
                    most = worse(most, self.stretch(&pair[0], &left, &right, PROOF_HALVINGS)?);
                }
                if to >= pair[1].t {
                    break;
                }
                self.course.step();
                self.last = None;
                from = to;
            }
        }
        Some(most)
    }

    /// Whether a motion over the whole section keeps every limit. The bounds of whole intervals are
    /// tried first, since on most of a long path they suffice.
    pub(crate) fn holds(&mut self, knots: &[Knot]) -> bool {
        let mut first = 0;
        let intervals = self.section.intervals;
        for pair in knots.windows(2) {
            while intervals
                .get(first)
                .is_some_and(|interval| interval.end <= pair[0].s)
            {
                first += 1;
            }
            let under = intervals[first.min(intervals.len())..]
                .iter()
                .take_while(|interval| interval.start < pair[1].s);
            // The bounds of whole intervals cost little and suffice nearly everywhere.
            let coarse = under.clone().all(|interval| {
                self.section
                    .machine
                    .keeps(&interval.demand, pair, KEPT_SHARE)
            });
            if !coarse
                && self
                    .most(pair)
                    .is_none_or(|used| used.iter().any(|part| *part > KEPT_SHARE))
            {
                return false;
            }
        }
        true
    }

    fn end(&self, knot: &Knot, t: f64) -> Option<StretchEnd> {
        let motion = knot.at(t);
        let place = match self.last {
            Some((last, place)) if last == t => place,
            _ => self.course.on_piece(motion.s)?,
        };
        let PathState { v, a, .. } = motion;
        let mut state = JointStates::default();
        // Chain rule of q(s(t)) at constant path jerk.
        for (joint, _) in self.section.machine.joints() {
            let JointDerivs { d1, d2, d3 } = place.joint(joint);
            state[joint] = [
                d1 * v,
                d1 * a + d2 * v * v,
                d1 * knot.j + (3.0 * d2 * a + d3 * v * v) * v,
            ];
        }
        Some(StretchEnd {
            t,
            motion,
            place,
            state,
            tip: v / place.feed,
        })
    }

    /// Over a stretch of one jerk and one piece.
    fn stretch(
        &self,
        knot: &Knot,
        left: &StretchEnd,
        right: &StretchEnd,
        halvings: u32,
    ) -> Option<Used> {
        let middle = || self.end(knot, 0.5 * (left.t + right.t));
        let (seen, bound) = match self.section.kinematics.joint_map() {
            JointMap::Shifted => self.bounds(knot, left, right),
            JointMap::Curved => self.estimate([left, &middle()?, right]),
        };
        let fits = |used: &Used| used.iter().all(|part| *part <= KEPT_SHARE);
        // Done where the limits are proven, where a place already passes one, or where halving has
        // to end.
        if fits(&bound) || !fits(&seen) || halvings == 0 {
            return Some(if fits(&seen) { bound } else { seen });
        }
        let middle = middle()?;
        let first = self.stretch(knot, left, &middle, halvings - 1)?;
        Some(worse(
            first,
            self.stretch(knot, &middle, right, halvings - 1)?,
        ))
    }

    /// Used parts of the limits: the largest at three places, and an estimate of the largest in
    /// between.
    fn estimate(&self, [left, middle, right]: [&StretchEnd; 3]) -> (Used, Used) {
        let tip = left.tip.max(middle.tip).max(right.tip);
        let mut seen = [tip, 0.0, 0.0];
        let mut bound = [
            tip + (middle.tip - 0.5 * (left.tip + right.tip)).abs(),
            0.0,
            0.0,
        ];
        for (joint, limits) in self.section.machine.joints() {
            for kind in 0..3 {
                let [a, m, b] = [left, middle, right].map(|end| end.state[joint][kind]);
                let most = a.abs().max(m.abs()).max(b.abs());
                seen[kind] = f64::max(seen[kind], most / limits[kind]);
                bound[kind] = f64::max(
                    bound[kind],
                    (most + (m - 0.5 * (a + b)).abs()) / limits[kind],
                );
            }
        }
        (seen, bound)
    }

    /// Used parts of the limits: the largest at both ends, and a bound of the largest in between.
    fn bounds(&self, knot: &Knot, left: &StretchEnd, right: &StretchEnd) -> (Used, Used) {
        let h = right.t - left.t;
        let eighth = h * h / 8.0;
        let bends = self
            .course
            .bends(left.motion.s, right.motion.s, [&left.place, &right.place]);
        // At constant jerk the acceleration is largest at an end, and the speed passes its chord by
        // at most j h^2 / 8.
        let a = left.motion.a.abs().max(right.motion.a.abs());
        let v = left.motion.v.max(right.motion.v) + eighth * knot.j.abs();
        let j = knot.j.abs();
        let (mut seen, mut bound) = ([left.tip.max(right.tip), 0.0, 0.0], [0.0; 3]);
        let mut tip = 0.0;
        for (joint, limits) in self.section.machine.joints() {
            let [d2, d3, d4, d5] = [0, 1, 2, 3].map(|order| bends[order][joint]);
            let at = |kind: usize| {
                left.state[joint][kind]
                    .abs()
                    .max(right.state[joint][kind].abs())
            };
            let (v2, a2) = (v * v, a * a);
            // Fifth and fourth derivative by time (Faa di Bruno; the path's jerk is constant).
            let fifth = ((d5 * v2 + 10.0 * d4 * a) * v2 + (15.0 * a2 + 10.0 * v * j) * d3) * v
                + 10.0 * d2 * a * j;
            let fourth = (d4 * v2 + 6.0 * d3 * a) * v2 + d2 * (3.0 * a2 + 4.0 * v * j);
            let jerk = at(2) + eighth * fifth;
            let used = [at(0) + eighth * jerk, at(1) + eighth * fourth, jerk];
            // The second derivative of the tip's speed is at most the size of the jerk of X, Y and
            // Z.
            if joint < 3 {
                tip += jerk * jerk;
            }
            for kind in 0..3 {
                seen[kind] = seen[kind].max(at(kind) / limits[kind]);
                bound[kind] = f64::max(bound[kind], used[kind] / limits[kind]);
            }
        }
        // The tip or the parameter, whichever leaves its chord farther.
        let feed = left.place.feed.min(right.place.feed);
        bound[0] = bound[0].max(left.tip.max(right.tip) + eighth * tip.sqrt().max(j) / feed);
        (seen, bound)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;
    use crate::piece::{Piece, Programmed};
    use crate::{FeedLimit, Move, PathControl};
    use lostmotion_base::{AxisLimits, BlockRef, Coords};
    use lostmotion_kinematics::{CartesianSpec, build};
    use lostmotion_path::{self as path, ArcSpec, Curve, Plane, Quintic};
    use std::collections::VecDeque;
    use std::sync::Arc;

    fn piece(curve: Curve) -> Piece {
        let Move {
            control,
            tool_mm,
            block,
            ..
        } = Move {
            curve,
            feed: FeedLimit::Rapid,
            control: PathControl::ExactPath,
            tool_mm: [0.0; 3],
            block: BlockRef::default(),
        };
        let length = curve.length();
        Programmed {
            curve,
            length,
            feed: 200.0,
            heeds: crate::Heeds::Feed,
            control,
            tool_mm,
            segment: 0,
            block,
        }
        .part(0.0, length)
    }

    fn curves() -> Vec<Curve> {
        let height = [0.0, 0.3, -0.2, 0.9, 0.1, 0.5];
        let points =
            std::array::from_fn(|k| Coords::xyz(0.4 * k as f64, height[k], -height[5 - k]));
        let start = Coords::xyz(2.0, 0.5, 0.0);
        let arc = |end, center| {
            path::Arc::new(ArcSpec {
                start,
                end,
                plane: Plane::Xy,
                center,
                rotation: 1,
            })
            .map(Curve::Arc)
        };
        let mut curves: Vec<Curve> = Quintic::from_control_points(points, 2.0)
            .map(Curve::Quintic)
            .into_iter()
            .collect();
        curves.extend(arc(Coords::xyz(0.0, 0.5, 0.3), [1.0, 0.5]));
        curves.extend(arc(Coords::xyz(-0.3, 0.5, 0.3), [1.0, 0.5]));
        curves.push(Curve::line(start, Coords::xyz(3.0, 1.5, 2.0)));
        curves
    }

    /// Differences of densely sampled places never pass the bounds, which are not far above them.
    #[test]
    fn bounds_hold_between_and_are_tight() {
        let limits = AxisLimits {
            min: -1e3,
            max: 1e3,
            velocity: 20.0,
            acceleration: 900.0,
            jerk: 60_000.0,
        };
        let mut all = [None; AXES];
        all[..3].fill(Some(limits));
        let machine = Machine::new(&all);
        let kinematics = build(&CartesianSpec {}.into());
        let Ok(kinematics) = kinematics else {
            return assert!(kinematics.is_ok());
        };
        assert_eq!(curves().len(), 4);
        let h = 5e-5;
        for curve in curves() {
            let pieces: VecDeque<(f64, Arc<Piece>)> = [(0.0, Arc::new(piece(curve)))].into();
            let section = Section {
                machine: &machine,
                kinematics: kinematics.as_ref(),
                pieces: &pieces,
                intervals: &[],
                nodes: &[],
                base: &[],
            };
            for (v, a, j) in [
                (8.0, 0.0, 0.0),
                (4.0, 60.0, -900.0),
                (9.0, -80.0, 2000.0),
                (0.5, 0.0, 4000.0),
            ] {
                let knot = Knot {
                    t: 0.0,
                    s: 0.2,
                    v,
                    a,
                    j,
                };
                let end = Knot {
                    t: 0.06,
                    ..Knot::default()
                };
                let PathState { s, v, a } = knot.at(end.t);
                let used = Certificate::new(&section).most(&[knot, Knot { s, v, a, ..end }]);
                let bound = used.unwrap_or([0.0; 3]);
                let mut q: Vec<Coords> = (0..=1200)
                    .map(|k| curve.point(knot.at(h * f64::from(k)).s))
                    .collect();
                for (kind, limit) in [limits.velocity, limits.acceleration, limits.jerk]
                    .into_iter()
                    .enumerate()
                {
                    q = q
                        .windows(2)
                        .map(|pair| (pair[1] - pair[0]) * (1.0 / h))
                        .collect();
                    let most = q
                        .iter()
                        .flat_map(|q| q.0)
                        .fold(0.0_f64, |most, q| most.max(q.abs()))
                        / limit;
                    let (low, high) = (most * (1.0 - 1e-5) - 1e-5, most.max(1.0) * 1.01);
                    assert!(
                        low <= bound[kind],
                        "{curve:?} {knot:?}: {} of {most} in order {kind}",
                        bound[kind]
                    );
                    // A bound is only made as tight as it has to be to stay within the limit.
                    assert!(
                        bound[kind] <= high,
                        "{curve:?} {knot:?}: {} of {most} in order {kind}",
                        bound[kind]
                    );
                }
            }
        }
    }
}
