//! Places near which a spline has to pass.

use crate::condition::tube::spline::{Breaks, ORDER, combined};
use lostmotion_base::vec::{Vec3, along, dot, scale, sub};

/// A place near which the spline has to pass.
#[derive(Clone, Copy, Debug)]
pub(in crate::condition::tube) struct Site {
    pub(in crate::condition::tube) w: f64,
    pub(in crate::condition::tube) interval: usize,
    pub(super) basis: [f64; ORDER],
    pub(in crate::condition::tube) place: Vec3,
    pub(super) radius: f64,
    /// Along this direction, of unit length or zero, the distance does not count.
    pub(super) direction: Vec3,
    pub(super) multiplier: f64,
    pub(super) slack: f64,
}

impl Site {
    pub(in crate::condition::tube) fn new(
        breaks: &Breaks,
        interval: usize,
        w: f64,
        place: Vec3,
        radius: f64,
    ) -> Site {
        Site {
            w,
            interval,
            basis: breaks.basis(interval, w),
            place,
            radius,
            direction: [0.0; 3],
            multiplier: 0.0,
            slack: 0.0,
        }
    }

    /// Does not count how far the spline is away along a direction of unit length, or none.
    pub(in crate::condition::tube) fn sliding(self, direction: Vec3) -> Site {
        Site { direction, ..self }
    }

    /// Allows less.
    pub(in crate::condition::tube) fn narrow(&mut self, factor: f64) {
        self.radius *= factor;
        self.slack *= factor * factor;
    }

    #[inline(always)]
    pub(super) fn square(&self) -> f64 {
        self.radius * self.radius
    }

    #[inline(always)]
    pub(super) fn off(&self, coefficients: &[Vec3]) -> Vec3 {
        sub(self.at(coefficients), self.place)
    }

    /// Value of the spline with these coefficients.
    #[inline(always)]
    pub(super) fn at(&self, coefficients: &[Vec3]) -> Vec3 {
        combined(
            &coefficients[self.interval..self.interval + ORDER],
            &self.basis,
        )
    }

    /// How the place pulls at a spline with these coefficients.
    pub(in crate::condition::tube) fn pull(&self, coefficients: &[Vec3]) -> Vec3 {
        scale(self.counted(&self.off(coefficients)), self.multiplier)
    }

    /// What counts of an offset: its product with the offset is the square of the distance.
    #[inline(always)]
    pub(super) fn counted(&self, off: &Vec3) -> Vec3 {
        along(*off, self.direction, -dot(*off, self.direction))
    }
}
