//! Arc length of a circle, helix or Archimedean spiral in closed form, without cancellation.
//!
//! Over the fraction u of the sweep, radius r = r0 + b u, the speed is g(u) = sqrt(c2 + k2 r^2)
//! with k the sweep's magnitude and c2 = b^2 + lift^2. The textbook primitive r g / 2 + c2 / (2 k)
//! asinh(k r / c), over b, is a difference of nearly equal numbers divided by a nearly vanishing
//! one whenever start and end radius almost agree, which is the usual case of a programmed arc.
//! Here both differences are rationalised, so that the same formula serves from the exact circle (b
//! = 0) to the spiral that starts in its centre.

use crate::derivs::within;
use lostmotion_base::math;
use lostmotion_base::root::Bracket;

/// Most steps of Newton's method for the fraction of a length, against a rounding that never
/// settles; a few are the rule.
const MAX_FRACTION_STEPS: u32 = 60;
/// Step in u after which Newton's method ends. Derived: it converges quadratically, so that the
/// error left is about the square, below the last digit.
const LAST_FRACTION_STEP: f64 = 1e-9;

/// Shape of an arc, as far as its length depends on it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spiral {
    /// Radius at u = 0, mm.
    pub(crate) r0: f64,
    /// Change of radius over the whole sweep, mm.
    pub(crate) b: f64,
    /// Magnitude of the sweep, rad.
    pub(crate) k: f64,
    /// Squares of radius change and lift, mm2.
    pub(crate) c2: f64,
}

impl Spiral {
    /// Radius at u.
    pub(crate) fn radius(&self, u: f64) -> f64 {
        self.r0 + self.b * u
    }

    /// ds/du at u.
    pub(crate) fn speed(&self, u: f64) -> f64 {
        let kr = self.k * self.radius(u);
        (self.c2 + kr * kr).sqrt()
    }

    /// Length from 0 to u.
    pub(crate) fn length(&self, u: f64) -> f64 {
        let (r0, r) = (self.r0, self.radius(u));
        let (g0, g) = (self.speed(0.0), self.speed(u));
        // Circle and helix have constant speed.
        if self.b == 0.0 {
            return g * u;
        }
        // The sums that rationalise both differences: of r g by its conjugate, and of asinh by its
        // addition theorem.
        let (own, crossed) = (r * g + r0 * g0, r * g0 + r0 * g);
        if own <= 0.0 || crossed <= 0.0 {
            // No sweep, or radii whose squares vanish: the speed is then constant.
            return g * u;
        }
        let sum = r + r0;
        // asinh(k r / c) - asinh(k r0 / c) = asinh(delta).
        let delta = self.k * self.b * u * sum / crossed;
        0.5 * u
            * (sum * (self.c2 + self.k * self.k * (r * r + r0 * r0)) / own
                + self.c2 * sum / crossed * asinh_ratio(delta))
    }

    /// The u at which the length is `s`, `total` being the whole length. Newton's method on a
    /// monotone function, kept in its bracket.
    pub(crate) fn fraction(&self, s: f64, total: f64) -> f64 {
        if s <= 0.0 || total <= 0.0 {
            return 0.0;
        }
        if s >= total {
            return 1.0;
        }
        // Exact on a circle or helix, a good start on a spiral.
        let mut u = s / total;
        if self.b == 0.0 {
            return u;
        }
        let mut bracket = Bracket::new(0.0, 1.0);
        for _ in 0..MAX_FRACTION_STEPS {
            let excess = self.length(u) - s;
            bracket.narrow(u, excess);
            let step = excess / self.speed(u);
            let next = u - step;
            // The error after a step e is at most k e^2 / 2: such a step was the last one, rounding
            // may point anywhere.
            if step.abs() <= LAST_FRACTION_STEP {
                return within(next, 0.0, 1.0);
            }
            u = bracket.inside_or_middle(next);
        }
        u
    }
}

/// asinh(x) / x, 1 at zero.
fn asinh_ratio(x: f64) -> f64 {
    if x.abs() < 1e-3 {
        // Four terms of the series: the next is below 1e-25.
        let x2 = x * x;
        1.0 - x2 / 6.0 + 3.0 * x2 * x2 / 40.0 - 15.0 * x2 * x2 * x2 / 336.0
    } else {
        math::asinh(x) / x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Composite five-point Gauss-Legendre quadrature of the speed.
    fn quadrature(spiral: &Spiral, to: f64) -> f64 {
        let nodes = [
            (0.0, 0.568_888_888_888_888_9),
            (0.538_469_310_105_683, 0.478_628_670_499_366_47),
            (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        ];
        let panels = 2000;
        let half = 0.5 * to / f64::from(panels);
        let mut sum = 0.0;
        for panel in 0..panels {
            let mid = (2.0 * f64::from(panel) + 1.0) * half;
            sum += nodes[0].1 * spiral.speed(mid);
            for (x, w) in &nodes[1..] {
                sum += w * (spiral.speed(mid - x * half) + spiral.speed(mid + x * half));
            }
        }
        sum * half
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100))]
        #[test]
        fn closed_form_agrees_with_quadrature(
            r0 in 0.0..50.0_f64, exponent in -14.0..1.0_f64, grow in any::<bool>(), k in 0.01..30.0_f64, lift in 0.0..20.0_f64, u in 0.01..1.0_f64
        ) {
            let size = math::pow(10.0, exponent);
            let b = if grow { size } else { -size.min(r0) };
            let spiral = Spiral { r0, b, k, c2: b * b + lift * lift };
            let (exact, sum) = (spiral.length(u), quadrature(&spiral, u));
            prop_assert!((exact - sum).abs() <= 1e-10 * sum + 1e-300, "{exact} {sum}");
            let total = spiral.length(1.0);
            prop_assert!((spiral.fraction(exact, total) - u).abs() < 1e-12 * (1.0 + total / spiral.speed(u)));
        }
    }

    #[test]
    fn archimedean_spiral_from_its_center() {
        // r = phi over one turn: length (phi sqrt(1 + phi^2) + asinh phi) / 2.
        let turn = std::f64::consts::TAU;
        let spiral = Spiral {
            r0: 0.0,
            b: turn,
            k: turn,
            c2: turn * turn,
        };
        let expected = 0.5 * (turn * (1.0 + turn * turn).sqrt() + math::asinh(turn));
        assert!((spiral.length(1.0) - expected).abs() < 1e-13 * expected);
    }
}
