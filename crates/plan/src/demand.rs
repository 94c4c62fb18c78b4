//! What a stretch of path demands of the joints.

use lostmotion_base::AXES;

/// Bounds of |q'|, |q''| and |q'''| of every joint over some stretch of path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Demand {
    pub(crate) d: [[f64; AXES]; 3],
    /// Bounds of q'' and q''' upward and downward, by order, then side: terms of opposite sign do
    /// not add up.
    pub(crate) sides: [[[f64; AXES]; 2]; 2],
    /// Largest speed of the path parameter that the feed allows, 1/s.
    pub(crate) feed: f64,
}

impl Demand {
    /// No demand at all.
    pub(crate) const NONE: Demand = Demand {
        d: [[0.0; AXES]; 3],
        sides: [[[0.0; AXES]; 2]; 2],
        feed: f64::INFINITY,
    };

    /// From bounds of the magnitudes alone.
    pub(crate) fn new(d: [[f64; AXES]; 3], feed: f64) -> Demand {
        Demand {
            d,
            sides: [[d[1]; 2], [d[2]; 2]],
            feed,
        }
    }

    /// Takes in the demands of another stretch.
    pub(crate) fn join(&mut self, other: &Demand) {
        for order in 0..3 {
            for joint in 0..AXES {
                self.d[order][joint] = self.d[order][joint].max(other.d[order][joint]);
            }
        }
        for (mine, others) in self
            .sides
            .iter_mut()
            .flatten()
            .zip(other.sides.iter().flatten())
        {
            for (mine, other) in mine.iter_mut().zip(others) {
                *mine = mine.max(*other);
            }
        }
        self.feed = self.feed.min(other.feed);
    }

    /// The bounds of one joint.
    pub(crate) fn joint(&self, joint: usize) -> JointDerivs {
        let [d1, d2, d3] = [0, 1, 2].map(|order| self.d[order][joint]);
        JointDerivs { d1, d2, d3 }
    }

    /// Without all that bends.
    pub(crate) fn straightened(&self) -> Demand {
        Demand::new([self.d[0], [0.0; AXES], [0.0; AXES]], self.feed)
    }

    /// Whether every joint is linear in the path parameter.
    pub(crate) fn is_straight(&self) -> bool {
        self.d[1] == [0.0; AXES] && self.d[2] == [0.0; AXES]
    }
}

/// A stretch of path with one set of bounds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Interval {
    /// Where it begins on the path.
    pub(crate) start: f64,
    /// Where it ends.
    pub(crate) end: f64,
    pub(crate) demand: Demand,
    /// Largest steady speed.
    pub(crate) cap: f64,
}

/// Which way the speed changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    Faster,
    Slower,
}

/// Derivatives of one joint by the path, or bounds of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct JointDerivs {
    pub(crate) d1: f64,
    pub(crate) d2: f64,
    pub(crate) d3: f64,
}

/// Bounds of |q'| and of what of q'' and q''' pulls a joint's jerk to one side, then to the other:
/// to either side q''' v3 adds to 3 q'' v a of its own sign while speeding up, and to that of the
/// other sign while slowing down. The window's mean of the acceleration may be anything from none
/// to all of it, so that what pulls the other way is no help.
pub(crate) fn sides(demand: &Demand, direction: Direction, joint: usize) -> [JointDerivs; 2] {
    let d1 = demand.d[0][joint];
    let at = |order: usize, side: usize| demand.sides[order][side][joint];
    let (up2, down2, up3, down3) = (at(0, 0), at(0, 1), at(1, 0), at(1, 1));
    let pairs = match direction {
        Direction::Faster => [(up2, up3), (down2, down3)],
        Direction::Slower => [(down2, up3), (up2, down3)],
    };
    pairs.map(|(d2, d3)| JointDerivs { d1, d2, d3 })
}
