//! The motion beside rest.
//!
//! b(s), the square of the speed, goes with s^(4/3) there and has no bounded derivatives, so that no
//! spline of b follows it. Some steps at rest therefore keep the shape of the base, but in less
//! time: where all of a motion takes 1/f of the time on the same path, every joint has f times the
//! velocity, f^2 times the acceleration and f^3 times the jerk.

use super::Section;
use super::certificate::Certificate;
use super::course::KEPT_SHARE;
use crate::motion::{Knot, PathState, state_at};
use lostmotion_base::math;

/// How often the factor on the speed is made to fit what the last one used. A choice: bounds get
/// tight near the limits alone, and the second try is within a percent of the largest.
const TRIES: usize = 4;
/// What of a limit a try aims at. A choice: bounds between places take some of the rest.
const AIM: f64 = 0.999;
/// Largest factor. A choice: some windows of the slowest joint.
const MOST: f64 = 30.0;

/// A part of the motion between rest and where it may change freely.
#[derive(Clone, Debug)]
pub(super) struct Stub {
    /// Its knots, the last one an end alone; their times begin at 0.
    pub(super) knots: Vec<Knot>,
}

impl Stub {
    /// The base between two times.
    pub(super) fn of(base: &[Knot], from: f64, to: f64) -> Stub {
        let knot = |t: f64, j: f64| {
            let PathState { s, v, a } = state_at(base, t);
            Knot {
                t: t - from,
                s,
                v,
                a,
                j,
            }
        };
        let first = base.partition_point(|knot| knot.t <= from);
        let last = base.partition_point(|knot| knot.t < to);
        let jerk = first
            .checked_sub(1)
            .and_then(|before| base.get(before))
            .map_or(0.0, |before| before.j);
        let mut knots = vec![knot(from, jerk)];
        let within = base.get(first..last).unwrap_or_default();
        knots.extend(within.iter().map(|knot| Knot {
            t: knot.t - from,
            ..*knot
        }));
        knots.push(knot(to, 0.0));
        Stub { knots }
    }

    /// How long it lasts, s.
    pub(super) fn lasts_s(&self) -> f64 {
        self.knots.last().map_or(0.0, |last| last.t)
    }

    /// The same on the same path with a factor on the speed.
    fn hurried(&self, f: f64) -> Stub {
        let knots = self.knots.iter().map(|knot| Knot {
            t: knot.t / f,
            s: knot.s,
            v: f * knot.v,
            a: f * f * knot.a,
            j: f * f * f * knot.j,
        });
        Stub {
            knots: knots.collect(),
        }
    }

    /// As fast as the limits allow; as it is where that is not faster.
    pub(super) fn fastest(&self, section: &Section<'_>) -> Stub {
        let mut best = self.clone();
        let mut factor = 1.0;
        for _ in 0..TRIES {
            let tried = self.hurried(factor);
            let Some([v, a, j]) = Certificate::new(section).most(&tried.knots) else {
                break;
            };
            if v.max(a).max(j) <= KEPT_SHARE && tried.lasts_s() < best.lasts_s() {
                best = tried;
            }
            // By what the limits leave of velocity, acceleration and jerk.
            let room = (AIM / v).min((AIM / a).sqrt()).min(math::cbrt(AIM / j));
            factor = (factor * room).clamp(1.0, MOST);
        }
        best
    }
}
