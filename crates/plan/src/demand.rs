//! What a stretch of path demands of the joints.

use lostmotion_base::AXES;

/// Bounds of the derivatives of one joint over some stretch of path. One joint's lie side by side, since
/// they are asked for together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct JointDemand {
    /// Of |q'|.
    pub(crate) first: f64,
    /// Of q'' and q''' upward and downward: terms of opposite sign do not add up.
    pub(crate) second: [f64; 2],
    pub(crate) third: [f64; 2],
}

impl JointDemand {
    /// From bounds of the magnitudes alone.
    pub(crate) fn new(d1: f64, d2: f64, d3: f64) -> JointDemand {
        JointDemand {
            first: d1,
            second: [d2; 2],
            third: [d3; 2],
        }
    }

    /// Takes in the demands of another stretch.
    pub(crate) fn join(&mut self, other: &JointDemand) {
        self.first = self.first.max(other.first);
        for side in 0..2 {
            self.second[side] = self.second[side].max(other.second[side]);
            self.third[side] = self.third[side].max(other.third[side]);
        }
    }

    /// Bounds of the magnitudes.
    pub(crate) fn most(&self) -> JointDerivs {
        JointDerivs {
            d1: self.first,
            d2: self.second[0].max(self.second[1]),
            d3: self.third[0].max(self.third[1]),
        }
    }

    /// Bounds of |q'| and of what of q'' and q''' pulls the jerk to one side, then to the other:
    /// to either side q''' v3 adds to 3 q'' v a of its own sign while speeding up, and to that of the
    /// other sign while slowing down. The window's mean of the acceleration may be anything from none
    /// to all of it, so that what pulls the other way is no help.
    pub(crate) fn sides(&self, direction: Direction) -> [JointDerivs; 2] {
        let ([up2, down2], [up3, down3]) = (self.second, self.third);
        let pairs = match direction {
            Direction::Faster => [(up2, up3), (down2, down3)],
            Direction::Slower => [(down2, up3), (up2, down3)],
        };
        pairs.map(|(d2, d3)| JointDerivs {
            d1: self.first,
            d2,
            d3,
        })
    }
}

/// The bounds of every joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Demand {
    pub(crate) joints: [JointDemand; AXES],
    /// Largest speed of the path parameter that the feed allows, 1/s.
    pub(crate) feed: f64,
}

impl Demand {
    /// No demand at all.
    pub(crate) const NONE: Demand = Demand {
        joints: [JointDemand {
            first: 0.0,
            second: [0.0; 2],
            third: [0.0; 2],
        }; AXES],
        feed: f64::INFINITY,
    };

    /// Takes in the demands of another stretch.
    pub(crate) fn join(&mut self, other: &Demand) {
        for (mine, other) in self.joints.iter_mut().zip(&other.joints) {
            mine.join(other);
        }
        self.feed = self.feed.min(other.feed);
    }

    /// Without all that bends.
    pub(crate) fn straightened(&self) -> Demand {
        Demand {
            joints: self
                .joints
                .map(|joint| JointDemand::new(joint.first, 0.0, 0.0)),
            ..*self
        }
    }

    /// Whether every joint is linear in the path parameter.
    pub(crate) fn is_straight(&self) -> bool {
        let straight = |joint: &JointDemand| joint.second == [0.0; 2] && joint.third == [0.0; 2];
        self.joints.iter().all(straight)
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

#[cfg(test)]
mod tests {
    use super::*;

    /// What pulls the jerk to one side while the speed rises pulls it to the other while it falls, and joined
    /// demands are the larger of each.
    #[test]
    fn sides_swap_with_the_direction() {
        let mut joint = JointDemand {
            first: 1.0,
            second: [2.0, 3.0],
            third: [5.0, 4.0],
        };
        let pairs = |joint: &JointDemand, direction| joint.sides(direction).map(|d| (d.d2, d.d3));
        assert_eq!(pairs(&joint, Direction::Faster), [(2.0, 5.0), (3.0, 4.0)]);
        assert_eq!(pairs(&joint, Direction::Slower), [(3.0, 5.0), (2.0, 4.0)]);
        joint.join(&JointDemand::new(0.5, 2.5, 4.5));
        let JointDerivs { d1, d2, d3 } = joint.most();
        assert_eq!((d1, d2, d3), (1.0, 3.0, 5.0));
        assert_eq!((joint.second, joint.third), ([2.5, 3.0], [5.0, 4.5]));
    }
}
