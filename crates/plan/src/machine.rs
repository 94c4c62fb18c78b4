//! Bounds of speed and acceleration along the path from the limits of the joints.
//!
//! A joint q(s) on a path travelled with speed v, acceleration a and jerk j has the velocity q' v,
//! the acceleration q'' v2 + q' a and the jerk q''' v3 + 3 q'' v a + q' j. The planner makes j by a
//! moving average over a window T, which turns a path acceleration that steps by at most `a` into a
//! jerk of at most a / T.

use crate::chord::Chord;
use crate::demand::{Demand, Direction, Interval, JointDerivs};
use crate::motion::Knot;
use lostmotion_base::{AXES, AxisLimits, math};

/// A joint with its limits: velocity, acceleration, jerk.
#[derive(Clone, Copy, Debug)]
struct JointLimits {
    index: usize,
    v: f64,
    a: f64,
    j: f64,
}

impl JointLimits {
    /// By how much a window that begins at a speed and an acceleration may pass the jerk.
    fn excess(
        &self,
        JointDerivs { d1, d2, d3 }: JointDerivs,
        v: f64,
        window_s: f64,
        a: f64,
    ) -> f64 {
        let mean = v + 0.5 * a * window_s;
        (d3 * mean * mean + 3.0 * d2 * a) * mean + d1 * a / window_s - self.j
    }

    /// The largest acceleration that keeps the jerk at the mean speed `cap`.
    fn at_cap(&self, JointDerivs { d1, d2, d3 }: JointDerivs, cap: f64, window_s: f64) -> f64 {
        (self.j - d3 * cap * cap * cap).max(0.0) / (3.0 * d2 * cap + d1 / window_s)
    }

    /// The largest acceleration up to `a` that keeps the jerk.
    ///
    /// A window that begins at the speed v and the acceleration a has a mean speed of at most v + a
    /// T/2, so that the jerk is at most q''' (v + a T/2)^3 + 3 q'' (v + a T/2) a + q' a / T: convex
    /// in a, solved from above by Newton's method and then bounded from below by a chord. Its mean
    /// speed is at most `cap`, too, which may leave more room.
    fn jerk_room(&self, derivs: JointDerivs, cap: f64, v: f64, window_s: f64, a: f64) -> f64 {
        let JointDerivs { d1, d2, d3 } = derivs;
        let half = 0.5 * window_s;
        let excess = |a: f64| self.excess(derivs, v, window_s, a);
        let slope = |a: f64| {
            let mean = v + a * half;
            3.0 * (d3 * mean * mean * half + d2 * (mean + a * half)) + d1 / window_s
        };
        // The acceleration asked for keeps the jerk.
        if excess(a) <= 0.0 {
            return a;
        }
        let at_cap = self.at_cap(derivs, cap, window_s);
        // The curve alone, at a steady speed. Where that takes all of the jerk, only the bound at
        // the cap leaves room.
        let rest = excess(0.0);
        if rest >= 0.0 {
            return at_cap.min(a);
        }
        // On a convex function Newton's method comes down to the root without passing it.
        let mut high = a;
        for _ in 0..NEWTON_STEPS {
            let over = excess(high);
            high -= over / slope(high);
            if over < JERK_TOLERANCE * self.j {
                break;
            }
        }
        // The chord of a convex function from 0 lies above it: its zero is a safe bound from below.
        let chord = high * rest / (rest - excess(high).max(0.0));
        chord.max(at_cap).min(a)
    }
}

/// Part of every limit that is planned for, so that rounding cannot pass the limit.
const PLANNED_PART: f64 = 1.0 - 1e-6;

/// A window is short if a ramp with it takes at most this many times the time of the best one. A
/// choice: nearer to 1 shorter windows are tried on more stretches, which costs time.
const SHORT_RAMP: f64 = 1.05;
/// Part of the steady speed that acceleration and jerk would allow, so that some of both is left to
/// get there. A choice: less is slower on curves, more leaves no room.
const STEADY_PART: f64 = 0.99;
/// Most steps of Newton's method on a cubic. From far above, each takes off about a third.
const NEWTON_STEPS: usize = 8;
/// Excess of jerk, as a part of its limit, at which one more step of Newton's method is the last:
/// the chord below it is safe anyway.
const JERK_TOLERANCE: f64 = 0.1;

/// Largest path acceleration ever considered, 1/s2: stands for "no joint binds".
pub(crate) const NO_LIMIT: f64 = 1e12;

/// The limits of all joints.
#[derive(Clone, Debug)]
pub(crate) struct Machine {
    joints: Vec<JointLimits>,
    /// How far the tool may be off its way between two commands.
    pub(crate) chord: Option<Chord>,
}

impl Machine {
    pub(crate) fn new(limits: &[Option<AxisLimits>; AXES]) -> Machine {
        let joint = |(index, limits): (usize, &Option<AxisLimits>)| {
            limits.map(|l| JointLimits {
                index,
                v: l.velocity * PLANNED_PART,
                a: l.acceleration * PLANNED_PART,
                j: l.jerk * PLANNED_PART,
            })
        };
        Machine {
            joints: limits.iter().enumerate().filter_map(joint).collect(),
            chord: None,
        }
    }

    /// The same with part of the acceleration and the jerk.
    pub(crate) fn part(&self, part: f64) -> Machine {
        let joints = self.joints.iter().map(|joint| JointLimits {
            a: joint.a * part,
            j: joint.j * part,
            ..*joint
        });
        Machine {
            joints: joints.collect(),
            chord: self.chord.clone(),
        }
    }

    /// Takes in the demands of another stretch on the joints that there are.
    pub(crate) fn join(&self, all: &mut Demand, other: &Demand) {
        for JointLimits { index, .. } in &self.joints {
            all.joints[*index].join(&other.joints[*index]);
        }
    }

    /// Joints by axis index with the largest velocity, acceleration and jerk planned.
    pub(crate) fn joints(&self) -> impl Iterator<Item = (usize, [f64; 3])> + Clone + '_ {
        self.joints
            .iter()
            .map(|joint| (joint.index, [joint.v, joint.a, joint.j]))
    }

    /// The window T over which the slowest moving joint builds up its acceleration: the largest A /
    /// J, s.
    pub(crate) fn window_s(&self, demand: &Demand) -> f64 {
        let moving = self.joints.iter().filter(|joint| {
            let JointDerivs { d1, d2, .. } = demand.joints[joint.index].most();
            d1 > 0.0 || d2 > 0.0
        });
        moving.map(|joint| joint.a / joint.j).fold(0.0, f64::max)
    }

    /// The same over all intervals.
    pub(crate) fn window_over_s(&self, intervals: &[Interval]) -> f64 {
        let mut all = Demand::NONE;
        for interval in intervals {
            all.join(&interval.demand);
        }
        self.window_s(&all)
    }

    /// The same of all joints, whether they move or not.
    pub(crate) fn longest_window_s(&self) -> f64 {
        self.joints
            .iter()
            .map(|joint| joint.a / joint.j)
            .fold(0.0, f64::max)
    }

    /// Largest steady speed.
    pub(crate) fn speed_cap(&self, demand: &Demand) -> f64 {
        let mut cap = demand.feed;
        for joint in &self.joints {
            let JointDerivs { d1, d2, d3 } = demand.joints[joint.index].most();
            // Velocity d1 v. The tests below compare products, since roots are only needed where a
            // joint binds.
            if d1 > 0.0 {
                cap = cap.min(joint.v / d1);
            }
            // Acceleration d2 v^2 of the curve.
            if d2 * cap * cap > joint.a * (STEADY_PART * STEADY_PART) {
                cap = cap.min((joint.a / d2).sqrt() * STEADY_PART);
            }
            // Jerk d3 v^3 of the curve.
            if d3 * cap * cap * cap > joint.j * (STEADY_PART * STEADY_PART * STEADY_PART) {
                cap = cap.min(math::cbrt(joint.j / d3) * STEADY_PART);
            }
        }
        cap
    }

    /// Largest acceleration up to `most` at a speed, with the window over which it is averaged,
    /// where the speed never passes `cap`. Never rises with the speed.
    pub(crate) fn acceleration(
        &self,
        demand: &Demand,
        direction: Direction,
        cap: f64,
        v: f64,
        window_s: f64,
        most: f64,
    ) -> f64 {
        // First what is cheap: the acceleration that the curve leaves, and no more of it than the
        // jerk builds up within the window.
        let mut a = most;
        for joint in &self.joints {
            let JointDerivs { d1, d2, .. } = demand.joints[joint.index].most();
            let room = joint.a - d2 * v * v;
            if d1 * a > room {
                a = room.max(0.0) / d1;
            }
            if d1 * a > joint.j * window_s {
                a = joint.j * window_s / d1;
            }
        }
        for joint in &self.joints {
            let JointDerivs { d2, d3, .. } = demand.joints[joint.index].most();
            // On curves the jerk of the curve adds to that of the window, for each side by itself.
            if d2 == 0.0 && d3 == 0.0 {
                continue;
            }
            for side in demand.joints[joint.index].sides(direction) {
                a = joint.jerk_room(side, cap, v, window_s, a);
            }
        }
        a
    }

    /// The same at rest where nothing bends, whatever the cap.
    pub(crate) fn straight_acceleration(&self, demand: &Demand, window_s: f64) -> f64 {
        let mut a = NO_LIMIT;
        for joint in &self.joints {
            let d1 = demand.joints[joint.index].first;
            if d1 * a > joint.a {
                a = joint.a.max(0.0) / d1;
            }
            if d1 * a > joint.j * window_s {
                a = joint.j * window_s / d1;
            }
        }
        a
    }

    /// Largest acceleration at a speed squared, whatever its jerk.
    pub(crate) fn pull(&self, demand: &Demand, b: f64) -> f64 {
        let mut a = NO_LIMIT;
        for joint in &self.joints {
            let JointDerivs { d1, d2, .. } = demand.joints[joint.index].most();
            let room = joint.a - d2 * b;
            if d1 * a > room {
                a = room.max(0.0) / d1;
            }
        }
        a
    }

    /// Whether an acceleration is within the bound of [`Machine::acceleration`].
    pub(crate) fn allows(
        &self,
        demand: &Demand,
        direction: Direction,
        cap: f64,
        v: f64,
        window_s: f64,
        a: f64,
    ) -> bool {
        self.joints.iter().all(|joint| {
            // The conditions of `acceleration`, without solving for the bound.
            let JointDerivs { d1, d2, d3 } = demand.joints[joint.index].most();
            let side = |side| {
                joint.excess(side, v, window_s, a) <= 0.0 || a <= joint.at_cap(side, cap, window_s)
            };
            (d1 == 0.0 || d2 * v * v + d1 * a <= joint.a && d1 * a <= joint.j * window_s)
                && (d2 == 0.0 && d3 == 0.0
                    || demand.joints[joint.index]
                        .sides(direction)
                        .into_iter()
                        .all(side))
        })
    }

    /// Whether a motion of constant jerk between two states stays within this multiple of the
    /// limits wherever the demands hold.
    pub(crate) fn keeps(&self, demand: &Demand, ends: &[Knot], part: f64) -> bool {
        let [left, right] = ends else { return true };
        let (h, j) = (right.t - left.t, left.j.abs());
        // At constant jerk the acceleration is largest at an end, and the speed passes the chord of
        // its ends by at most j h^2 / 8.
        let (v, a) = (
            left.v.max(right.v) + j * h * h / 8.0,
            left.a.abs().max(right.a.abs()),
        );
        v <= demand.feed * part
            && self.joints.iter().all(|joint| {
                let JointDerivs { d1, d2, d3 } = demand.joints[joint.index].most();
                d1 * v <= joint.v * part
                    && d1 * a + d2 * v * v <= joint.a * part
                    && d1 * j + (3.0 * d2 * a + d3 * v * v) * v <= joint.j * part
            })
    }

    /// Whether a window is not much longer than the best one for a ramp from rest to the largest
    /// speed.
    pub(crate) fn is_short(&self, intervals: &[Interval], window_s: f64) -> bool {
        let mut all = Demand::NONE;
        let mut speed = 0.0_f64;
        for interval in intervals {
            all.join(&interval.demand);
            speed = speed.max(interval.cap);
        }
        let least = |limit: fn(&JointLimits) -> f64| {
            let of = |joint: &JointLimits| {
                limit(joint) / all.joints[joint.index].first.max(f64::MIN_POSITIVE)
            };
            self.joints.iter().map(of).fold(f64::INFINITY, f64::min)
        };
        // Path acceleration and jerk that every moving joint can follow.
        let (a, j) = (least(|joint| joint.a), least(|joint| joint.j));
        // Constant acceleration and a window against the shortest ramp, of jerk alone: 2 sqrt(v/j).
        speed / a + window_s <= SHORT_RAMP * 2.0 * (speed / j).sqrt()
    }

    /// The best window for a straight stretch from rest to rest: the time-optimal profile with
    /// limited jerk.
    pub(crate) fn straight_window_s(&self, demand: &Demand, length: f64) -> f64 {
        let jerk = self
            .joints
            .iter()
            .filter(|joint| demand.joints[joint.index].first > 0.0)
            .map(|joint| joint.j / demand.joints[joint.index].first);
        let jerk = jerk.fold(f64::INFINITY, f64::min);
        let speed = self.speed_cap(demand);
        // Jerk alone reaches the speed v in two windows of sqrt(v/j), and covers a way s from rest
        // to rest in four of cbrt(s/2j).
        (speed / jerk).sqrt().min(math::cbrt(0.5 * length / jerk))
    }
}
