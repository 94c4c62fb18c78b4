//! Proof that a motion keeps the limits at every time, not only where it is looked at.
//!
//! On a stretch of constant jerk over one piece of path a joint's place is a smooth function of time whose derivatives up to the
//! fifth are bounded by those of the curve. A function stays within h2/8 times its largest second derivative of the chord of its
//! ends, which bounds velocity, acceleration and jerk from their values at both ends of a time h; where that is not enough, h is
//! halved. Where a kinematics bends the path, the joints' fourth and fifth derivatives are not known: the middle's distance from
//! the chord stands for the bound.

use super::course::{Course, Place};
use super::{Knot, Motion, Section};
use lostmotion_base::AXES;

/// Limits are kept within rounding.
pub(super) const KEPT: f64 = 1.0 + 1e-6;
/// How often a stretch is halved.
const HALVINGS: u32 = 10;
/// Steps towards the time at which a piece begins.
const STEPS: usize = 60;

/// Parts that are used of the limits of velocity (feed included), acceleration and jerk.
pub(super) type Used = [f64; 3];

/// A joint's velocity, acceleration and jerk.
type State = [[f64; 3]; AXES];

/// Goes along a section.
#[derive(Debug)]
pub(super) struct Certificate<'a> {
    section: &'a Section<'a>,
    course: Course<'a>,
}

/// One end of a stretch.
#[derive(Clone, Copy)]
struct End {
    t: f64,
    motion: Motion,
    place: Place,
    state: State,
    /// Speed of the tip.
    tip: f64,
}

fn worse(a: Used, b: Used) -> Used {
    [a[0].max(b[0]), a[1].max(b[1]), a[2].max(b[2])]
}

impl<'a> Certificate<'a> {
    pub(super) fn new(section: &'a Section<'a>) -> Certificate<'a> {
        Certificate { section, course: Course::new(section) }
    }

    /// Bounds of what consecutive knots use, of which the last one is only an end; none where the machine cannot be.
    pub(super) fn most(&mut self, knots: &[Knot]) -> Option<Used> {
        let mut most = [0.0; 3];
        for pair in knots.windows(2) {
            let mut from = pair[0].t;
            self.course.find(pair[0].s);
            while from < pair[1].t {
                // Up to where the next piece begins.
                let to = self.course.next().map_or(pair[1].t, |next| time_at(&pair[0], next, from, pair[1].t));
                let (left, right) = (self.end(&pair[0], from)?, self.end(&pair[0], to)?);
                most = worse(most, self.stretch(&pair[0], &left, &right, HALVINGS)?);
                if to >= pair[1].t {
                    break;
                }
                self.course.step();
                from = to;
            }
        }
        Some(most)
    }

    fn end(&self, knot: &Knot, t: f64) -> Option<End> {
        let motion = knot.at(t);
        let place = self.course.on_piece(motion.s)?;
        let Motion { v, a, .. } = motion;
        let state = std::array::from_fn(|joint| {
            let [d1, d2, d3] = place.d.map(|d| d[joint]);
            [d1 * v, d1 * a + d2 * v * v, d1 * knot.j + (3.0 * d2 * a + d3 * v * v) * v]
        });
        Some(End { t, motion, place, state, tip: v / place.feed })
    }

    /// Over a stretch of one jerk and one piece.
    fn stretch(&self, knot: &Knot, left: &End, right: &End, halvings: u32) -> Option<Used> {
        let middle = || self.end(knot, 0.5 * (left.t + right.t));
        let (seen, bound) =
            if self.section.kinematics.is_affine() { self.bounds(knot, left, right) } else { self.estimate([left, &middle()?, right]) };
        let fits = |used: &Used| used.iter().all(|part| *part <= KEPT);
        if fits(&bound) || !fits(&seen) || halvings == 0 {
            return Some(if fits(&seen) { bound } else { seen });
        }
        let middle = middle()?;
        let first = self.stretch(knot, left, &middle, halvings - 1)?;
        Some(worse(first, self.stretch(knot, &middle, right, halvings - 1)?))
    }

    /// What is used at three places, and about at most in between.
    fn estimate(&self, [left, middle, right]: [&End; 3]) -> (Used, Used) {
        let tip = left.tip.max(middle.tip).max(right.tip);
        let mut seen = [tip, 0.0, 0.0];
        let mut bound = [tip + (middle.tip - 0.5 * (left.tip + right.tip)).abs(), 0.0, 0.0];
        for (joint, limits) in self.section.machine.joints() {
            for kind in 0..3 {
                let [a, m, b] = [left, middle, right].map(|end| end.state[joint][kind]);
                let most = a.abs().max(m.abs()).max(b.abs());
                seen[kind] = f64::max(seen[kind], most / limits[kind]);
                bound[kind] = f64::max(bound[kind], (most + (m - 0.5 * (a + b)).abs()) / limits[kind]);
            }
        }
        (seen, bound)
    }

    /// What is used at the ends, and at most in between.
    fn bounds(&self, knot: &Knot, left: &End, right: &End) -> (Used, Used) {
        let h = right.t - left.t;
        let eighth = h * h / 8.0;
        let bends = self.course.bends(left.motion.s, right.motion.s, [&left.place, &right.place]);
        let a = left.motion.a.abs().max(right.motion.a.abs());
        let v = left.motion.v.max(right.motion.v) + eighth * knot.j.abs();
        let j = knot.j.abs();
        let (mut seen, mut bound) = ([left.tip.max(right.tip), 0.0, 0.0], [0.0; 3]);
        let mut tip = 0.0;
        for (joint, limits) in self.section.machine.joints() {
            let [d2, d3, d4, d5] = bends.map(|d| d[joint]);
            let at = |kind: usize| left.state[joint][kind].abs().max(right.state[joint][kind].abs());
            let (v2, a2) = (v * v, a * a);
            // Fifth and fourth derivative by time (Faa di Bruno; the path's jerk is constant).
            let fifth = ((d5 * v2 + 10.0 * d4 * a) * v2 + (15.0 * a2 + 10.0 * v * j) * d3) * v + 10.0 * d2 * a * j;
            let fourth = (d4 * v2 + 6.0 * d3 * a) * v2 + d2 * (3.0 * a2 + 4.0 * v * j);
            let jerk = at(2) + eighth * fifth;
            let used = [at(0) + eighth * jerk, at(1) + eighth * fourth, jerk];
            if joint < 3 {
                tip += jerk * jerk;
            }
            for kind in 0..3 {
                seen[kind] = seen[kind].max(at(kind) / limits[kind]);
                bound[kind] = f64::max(bound[kind], used[kind] / limits[kind]);
            }
        }
        let feed = left.place.feed.min(right.place.feed);
        bound[0] = bound[0].max(left.tip.max(right.tip) + eighth * tip.sqrt().max(j) / feed);
        (seen, bound)
    }
}

/// When a motion that goes forward is at a place, between two times.
fn time_at(knot: &Knot, s: f64, from: f64, to: f64) -> f64 {
    if knot.at(to).s <= s {
        return to;
    }
    let (mut low, mut high) = (from, to);
    let mut t = 0.5 * (from + to);
    for _ in 0..STEPS {
        let motion = knot.at(t);
        if motion.s <= s {
            low = t
        } else {
            high = t
        }
        let newton = t - (motion.s - s) / motion.v;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - t).abs() <= f64::EPSILON * to {
            return next.max(low);
        }
        t = next;
    }
    high
}
