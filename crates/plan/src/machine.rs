//! What the joints demand of speed and acceleration along the path.
//!
//! A joint q(s) on a path travelled with speed v, acceleration a and jerk j has the velocity q' v, the acceleration
//! q'' v2 + q' a and the jerk q''' v3 + 3 q'' v a + q' j. The planner makes j by a moving average over a window T, which
//! turns a path acceleration that steps by at most `a` into a jerk of at most a / T.

use lostmotion_base::{AXES, AxisLimits, math};

/// Bounds of |q'|, |q''| and |q'''| of every joint over some stretch of path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Demand {
    pub(crate) d: [[f64; AXES]; 3],
    /// Largest speed of the path parameter that the feed allows, 1/s.
    pub(crate) feed: f64,
}

impl Demand {
    /// No demand at all.
    pub(crate) const NONE: Demand = Demand { d: [[0.0; AXES]; 3], feed: f64::INFINITY };

    /// Takes in the demands of another stretch.
    pub(crate) fn join(&mut self, other: &Demand) {
        for order in 0..3 {
            for joint in 0..AXES {
                self.d[order][joint] = self.d[order][joint].max(other.d[order][joint]);
            }
        }
        self.feed = self.feed.min(other.feed);
    }

    /// Whether every joint is linear in the path parameter.
    pub(crate) fn is_straight(&self) -> bool {
        self.d[1] == [0.0; AXES] && self.d[2] == [0.0; AXES]
    }
}

/// A joint with its limits.
#[derive(Clone, Copy, Debug)]
struct Joint {
    index: usize,
    v: f64,
    a: f64,
    j: f64,
}

/// Keeps what is planned a hair inside the limits, so that rounding cannot pass them.
const MARGIN: f64 = 1.0 - 1e-6;

/// Largest path acceleration ever considered, 1/s2: stands for "no joint minds".
const NO_LIMIT: f64 = 1e12;

/// The limits of all joints.
#[derive(Clone, Debug)]
pub(crate) struct Machine {
    joints: Vec<Joint>,
}

impl Machine {
    pub(crate) fn new(limits: &[Option<AxisLimits>; AXES]) -> Machine {
        let joint = |(index, limits): (usize, &Option<AxisLimits>)| {
            limits.map(|l| Joint { index, v: l.velocity * MARGIN, a: l.acceleration * MARGIN, j: l.jerk * MARGIN })
        };
        Machine { joints: limits.iter().enumerate().filter_map(joint).collect() }
    }

    /// The window T over which the slowest moving joint builds up its acceleration: the largest A / J, s.
    pub(crate) fn window_s(&self, demand: &Demand) -> f64 {
        let moving = self.joints.iter().filter(|joint| demand.d[0][joint.index] > 0.0 || demand.d[1][joint.index] > 0.0);
        moving.map(|joint| joint.a / joint.j).fold(0.0, f64::max)
    }

    /// The same over all joints.
    pub(crate) fn longest_window_s(&self) -> f64 {
        self.joints.iter().map(|joint| joint.a / joint.j).fold(0.0, f64::max)
    }

    /// Largest steady speed.
    pub(crate) fn speed_cap(&self, demand: &Demand) -> f64 {
        let mut cap = demand.feed;
        for joint in &self.joints {
            let [c1, c2, c3] = [0, 1, 2].map(|order| demand.d[order][joint.index]);
            if c1 > 0.0 {
                cap = cap.min(joint.v / c1);
            }
            if c2 * cap * cap > joint.a {
                cap = (joint.a / c2).sqrt();
            }
            if c3 * cap * cap * cap > joint.j {
                cap = math::cbrt(joint.j / c3);
            }
        }
        cap
    }

    /// Largest acceleration at a speed, with the window over which it is averaged. Never rises with the speed.
    pub(crate) fn acceleration(&self, demand: &Demand, v: f64, window_s: f64) -> f64 {
        let mut a = NO_LIMIT;
        for joint in &self.joints {
            let [c1, c2, c3] = [0, 1, 2].map(|order| demand.d[order][joint.index]);
            let room = joint.a - c2 * v * v;
            if c1 * a > room {
                a = room.max(0.0) / c1;
            }
            // The mean speed of a window in which the speed has risen by a T is a T / 2 higher than at its beginning.
            let room = (joint.j - c3 * v * v * v).max(0.0);
            let quadratic = 1.5 * c2 * window_s;
            let linear = 3.0 * c2 * v + c1 / window_s;
            if (quadratic * a + linear) * a > room {
                a = 2.0 * room / (linear + (linear * linear + 4.0 * quadratic * room).sqrt());
            }
        }
        a
    }

    /// The best window for a straight stretch from rest to rest: the time-optimal profile with limited jerk.
    pub(crate) fn straight_window_s(&self, demand: &Demand, length: f64) -> f64 {
        let jerk = self.joints.iter().filter(|joint| demand.d[0][joint.index] > 0.0).map(|joint| joint.j / demand.d[0][joint.index]);
        let jerk = jerk.fold(f64::INFINITY, f64::min);
        let speed = self.speed_cap(demand);
        (speed / jerk).sqrt().min(math::cbrt(0.5 * length / jerk))
    }
}
