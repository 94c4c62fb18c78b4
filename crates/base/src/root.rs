//! Roots of functions of one variable, kept in a bracket.
//!
//! ```
//! use lostmotion_base::root::Bracket;
//!
//! // Where does x^3 - 2 change its sign?
//! let found = Bracket::new(1.0, 2.0).newton(1.5, 60, 1e-14, |x| (x * x * x - 2.0, 3.0 * x * x));
//! assert!((found - 1.259_921_049_894_873).abs() < 1e-14);
//! // The largest x of eight halvings that keeps x^2 <= 2.
//! let kept = Bracket::new(0.0, 2.0).bisect(8, |x| x * x <= 2.0).low;
//! assert!(kept * kept <= 2.0 && (kept - 1.414).abs() < 0.01);
//! ```

/// An interval at whose ends a condition differs: it holds at `low` and fails at `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bracket {
    /// The end at which the condition holds, or at which a rising function is not positive.
    pub low: f64,
    /// The other end.
    pub high: f64,
}

impl Bracket {
    /// A bracket by its ends. `low` may be the greater number: then it holds above.
    pub const fn new(low: f64, high: f64) -> Bracket {
        Bracket { low, high }
    }

    /// The place half way.
    #[inline]
    pub fn middle(&self) -> f64 {
        0.5 * (self.low + self.high)
    }

    /// Halves the bracket a number of times by whether the condition holds at its middle.
    #[inline]
    #[must_use]
    pub fn bisect(mut self, halvings: usize, mut holds: impl FnMut(f64) -> bool) -> Bracket {
        for _ in 0..halvings {
            let middle = self.middle();
            if holds(middle) {
                self.low = middle;
            } else {
                self.high = middle;
            }
        }
        self
    }

    /// Narrows the bracket of a rising function by its value at a place within.
    #[inline]
    pub fn narrow(&mut self, at: f64, value: f64) {
        // A value that is not a number counts as not positive: the bracket still shrinks.
        if value > 0.0 {
            self.high = at;
        } else {
            self.low = at;
        }
    }

    /// The place that Newton's method proposes, or the middle where it is not inside.
    #[inline]
    pub fn inside_or_middle(&self, proposed: f64) -> f64 {
        if proposed > self.low && proposed < self.high {
            proposed
        } else {
            self.middle()
        }
    }

    /// The root of a rising function that gives its value and slope, by Newton's method with
    /// halving where a step leaves the bracket. Ends after `steps`, or when the place or the
    /// bracket moves by at most `tolerance`.
    #[inline]
    pub fn newton(
        mut self,
        start: f64,
        steps: usize,
        tolerance: f64,
        mut value_and_slope: impl FnMut(f64) -> (f64, f64),
    ) -> f64 {
        let mut at = start;
        for _ in 0..steps {
            let (value, slope) = value_and_slope(at);
            // The bracket first: it catches a step that the slope sends astray.
            self.narrow(at, value);
            let next = self.inside_or_middle(at - value / slope);
            // Newton's steps settle at a simple root, the bracket where the slope is of no use.
            if (next - at).abs() <= tolerance || self.high - self.low <= tolerance {
                return next;
            }
            at = next;
        }
        at
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;

    #[test]
    fn newton_stays_in_the_bracket_where_its_steps_leave_it() {
        // atan is so flat far out that Newton's steps from beyond 1.39 diverge
        let root = Bracket::new(-50.0, 60.0)
            .newton(55.0, 100, 1e-15, |x| (math::atan(x), 1.0 / (1.0 + x * x)));
        assert!(root.abs() < 1e-14, "{root}");
        // no slope at all: halving alone
        let step = Bracket::new(0.0, 1.0).newton(0.5, 100, 1e-12, |x| (x - 0.3, 0.0));
        assert!((step - 0.3).abs() < 1e-11, "{step}");
    }

    #[test]
    fn halving_keeps_what_holds_on_its_low_side() {
        let found = Bracket::new(0.0, 8.0).bisect(3, |x| x <= 2.5);
        assert_eq!(found, Bracket::new(2.0, 3.0));
        let falling = Bracket::new(8.0, 0.0).bisect(3, |x| x >= 2.5);
        assert_eq!(falling, Bracket::new(3.0, 2.0));
    }
}
