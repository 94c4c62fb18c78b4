//! Quantities computed from curves: points with their derivatives, foot points, boxes.

use lostmotion_base::{AXES, Coords, Jet};

/// A point with its first three derivatives by the curve's parameter `s` (mm, or degrees where only
/// rotary axes move).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CurveDerivs {
    /// Position, mm and rad.
    pub p: Coords,
    /// First derivative by s.
    pub d1: Coords,
    /// Second derivative by s.
    pub d2: Coords,
    /// Third derivative by s.
    pub d3: Coords,
}

impl CurveDerivs {
    /// The same as one jet per axis, as kinematics take it.
    pub fn jets(&self) -> [Jet; AXES] {
        let mut jets = [Jet::default(); AXES];
        for (i, jet) in jets.iter_mut().enumerate() {
            *jet = Jet::new(self.p.0[i], self.d1.0[i], self.d2.0[i], self.d3.0[i]);
        }
        jets
    }
}

/// The point of a curve nearest to some point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// Parameter of the foot point on the curve, mm (degrees on a line on which only rotary axes
    /// move).
    pub s: f64,
    /// Distance in the X Y Z space, mm, never negative.
    pub distance: f64,
}

/// The smallest and largest value of each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest, mm and rad.
    pub min: Coords,
    /// Largest, mm and rad.
    pub max: Coords,
}

impl Bounds {
    /// The box of two points.
    pub fn of(a: Coords, b: Coords) -> Bounds {
        let mut bounds = Bounds { min: a, max: a };
        bounds.include(b);
        bounds
    }

    /// Grows to hold a point.
    pub fn include(&mut self, point: Coords) {
        for (axis, value) in point.0.into_iter().enumerate() {
            self.include_axis(axis, value);
        }
    }

    /// Grows one axis, by index, to hold a value; an index that no axis has is ignored.
    pub fn include_axis(&mut self, axis: usize, value: f64) {
        if let (Some(low), Some(high)) = (self.min.0.get_mut(axis), self.max.0.get_mut(axis)) {
            *low = low.min(value);
            *high = high.max(value);
        }
    }

    /// The box around this one and another.
    #[must_use]
    pub fn union(mut self, other: &Bounds) -> Bounds {
        self.include(other.min);
        self.include(other.max);
        self
    }
}

/// `value` within `[low, high]`; unlike `clamp` it never panics.
pub(crate) fn within(value: f64, low: f64, high: f64) -> f64 {
    value.max(low).min(high)
}
