//! Cubic splines with continuous second derivative on uneven breaks, by their coefficients.
//!
//! Interval k lies between breaks k and k + 1 and is a sum over the coefficients k to k + 3. The
//! first and the last break count four times, so that the spline begins and ends at its outermost
//! coefficients. The third derivative is constant on each interval.

use super::linear;
use lostmotion_base::vec::{Vec3, along, sub};
use lostmotion_path::HermiteEnd;

/// Coefficients that an interval takes.
pub(super) const ORDER: usize = 4;

/// The breaks of a spline.
#[derive(Clone, Debug, Default)]
pub(super) struct Breaks(pub(super) Vec<f64>);

impl Breaks {
    /// From 0 to an end, all intervals as long as each other.
    pub(super) fn even(end: f64, intervals: usize) -> Breaks {
        let part = |k: usize| k as f64 / intervals as f64;
        Breaks((0..=intervals).map(|k| end * part(k)).collect())
    }

    /// How many intervals there are.
    pub(super) fn intervals(&self) -> usize {
        self.0.len().saturating_sub(1)
    }

    /// Number of coefficients.
    pub(super) fn coefficients(&self) -> usize {
        self.intervals() + ORDER - 1
    }

    /// A break, the first and the last one repeated beyond the ends.
    fn at(&self, k: isize) -> f64 {
        let last = self.0.len() as isize - 1;
        self.0[k.clamp(0, last.max(0)) as usize]
    }

    /// The interval that holds a place.
    pub(super) fn interval(&self, w: f64) -> usize {
        self.0
            .partition_point(|t| *t <= w)
            .clamp(1, self.intervals().max(1))
            - 1
    }

    /// Where coefficient j has its weight: Greville's abscissa.
    pub(super) fn greville(&self, j: usize) -> f64 {
        let j = j as isize;
        (self.at(j - 2) + self.at(j - 1) + self.at(j)) / 3.0
    }

    /// The breaks from which coefficient j takes its weight.
    pub(super) fn knots(&self, j: usize) -> [f64; 3] {
        [-2, -1, 0].map(|d| self.at(j as isize + d))
    }

    /// Weights of the coefficients of interval k at a place (Cox and de Boor).
    pub(super) fn basis(&self, k: usize, w: f64) -> [f64; ORDER] {
        let k = k as isize;
        let mut basis = [1.0, 0.0, 0.0, 0.0];
        for degree in 1..ORDER {
            let mut carried = 0.0;
            for (r, value) in basis.iter_mut().enumerate().take(degree) {
                let right = self.at(k + 1 + r as isize);
                let left = self.at(k + 1 + r as isize - degree as isize);
                let part = *value / (right - left);
                *value = carried + (right - w) * part;
                carried = (w - left) * part;
            }
            basis[degree] = carried;
        }
        basis
    }

    /// The third derivative on interval k as weights of its coefficients.
    pub(super) fn third(&self, k: usize) -> [f64; ORDER] {
        self.differences(k, 3)
    }

    /// The second derivative where interval k begins as weights of its coefficients.
    pub(super) fn second(&self, k: usize) -> [f64; ORDER] {
        self.differences(k, 2)
    }

    /// The first coefficient that a derivative has on interval k, as weights of the spline's.
    fn differences(&self, k: usize, order: usize) -> [f64; ORDER] {
        let at = |d: isize| self.at(k as isize + d);
        let mut rows: [[f64; ORDER]; ORDER] = [[0.0; ORDER]; ORDER];
        for (i, row) in rows.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        // Divided differences, as often as the order: degree over the span of breaks.
        for degree in (ORDER - order..ORDER).rev() {
            for i in 0..degree {
                let d = i as isize + 1;
                let factor = degree as f64 / (at(d) - at(d - degree as isize));
                let (row, next) = (rows[i], rows[i + 1]);
                rows[i] = std::array::from_fn(|c| (next[c] - row[c]) * factor);
            }
        }
        rows[0]
    }

    /// Widths of the first two intervals.
    pub(super) fn first_widths(&self) -> Option<[f64; 2]> {
        match self.0.as_slice() {
            [a, b, c, ..] => Some([b - a, c - b]),
            _ => None,
        }
    }

    /// Widths of the last two intervals, the last one first.
    pub(super) fn last_widths(&self) -> Option<[f64; 2]> {
        match self.0.as_slice() {
            [.., a, b, c] => Some([c - b, b - a]),
            _ => None,
        }
    }

    /// Places and derivatives at the breaks.
    pub(super) fn states(&self, coefficients: &[Vec3]) -> Vec<HermiteEnd> {
        (0..self.0.len())
            .map(|k| {
                let interval = k.min(self.intervals() - 1);
                let basis = self.basis(interval, self.0[k]);
                let [d1, d2] = self.derivatives(coefficients, k);
                // From the first one on, so that an axis that stands does so to the last digit.
                let these = &coefficients[interval..interval + ORDER];
                let beside: [Vec3; ORDER] = std::array::from_fn(|j| sub(these[j], these[0]));
                HermiteEnd {
                    p: linear(along(these[0], combined(&beside, &basis), 1.0)),
                    d1: linear(d1),
                    d2: linear(d2),
                }
            })
            .collect()
    }

    /// First and second derivative at break k.
    fn derivatives(&self, coefficients: &[Vec3], k: usize) -> [Vec3; 2] {
        let at = |d: isize| self.at(k as isize + d);
        let slope = |i: usize, span: f64| {
            sub(coefficients[i + 1], coefficients[i]).map(|c| c * (3.0 / span))
        };
        // Coefficients of the first derivative on both sides of the break; at the end the last one
        // is the derivative.
        let is_end = k == self.intervals();
        let after = if is_end { 0 } else { 1 };
        let (first, second) = (
            slope(k, at(after) - at(-2)),
            slope(k + 1, at(after + after) - at(-1)),
        );
        let span = at(after) - at(-1);
        let bend = sub(second, first).map(|c| c * (2.0 / span));
        let part = (at(0) - at(-1)) / span;
        [
            std::array::from_fn(|axis| first[axis] + (second[axis] - first[axis]) * part),
            bend,
        ]
    }
}

/// A place on a spline from the coefficients of its interval.
#[inline(always)]
pub(super) fn combined(coefficients: &[Vec3], basis: &[f64; ORDER]) -> Vec3 {
    let mut place = [0.0; 3];
    for (coefficient, weight) in coefficients.iter().zip(basis) {
        for (place, coordinate) in place.iter_mut().zip(coefficient) {
            *place += weight * coordinate;
        }
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;

    fn breaks() -> Breaks {
        Breaks(vec![0.0, 0.3, 0.5, 1.1, 1.2, 2.0])
    }

    /// A cubic is its own spline: coefficients are its blossom at three breaks.
    fn cubic(breaks: &Breaks) -> Vec<Vec3> {
        (0..breaks.coefficients())
            .map(|j| {
                let [a, b, c] = [-2, -1, 0].map(|d| breaks.at(j as isize + d));
                // of w^3 - 2 w^2 + w
                let value = a * b * c - 2.0 * (a * b + b * c + c * a) / 3.0 + (a + b + c) / 3.0;
                [value, breaks.greville(j), 1.0]
            })
            .collect()
    }

    #[test]
    fn a_cubic_is_reproduced_with_its_derivatives() {
        let breaks = breaks();
        let coefficients = cubic(&breaks);
        for step in 0..=200 {
            let w = 0.01 * f64::from(step);
            let k = breaks.interval(w);
            let [x, y, z] = combined(&coefficients[k..k + ORDER], &breaks.basis(k, w));
            assert!(
                (x - (w * w * w - 2.0 * w * w + w)).abs() < 1e-14,
                "{w}: {x}"
            );
            assert!((y - w).abs() < 1e-14 && (z - 1.0).abs() < 1e-14);
        }
        for (k, w) in breaks.0.iter().enumerate() {
            let [first, second] = breaks.derivatives(&coefficients, k);
            assert!(
                (first[0] - (3.0 * w * w - 4.0 * w + 1.0)).abs() < 1e-12,
                "{w} {first:?}"
            );
            assert!(
                (second[0] - (6.0 * w - 4.0)).abs() < 1e-12,
                "{w} {second:?}"
            );
            assert!((first[1] - 1.0).abs() < 1e-13 && second[1].abs() < 1e-12);
        }
        for k in 0..breaks.intervals() {
            let third: f64 = breaks
                .third(k)
                .iter()
                .zip(&coefficients[k..])
                .map(|(d, c)| d * c[0])
                .sum();
            assert!((third - 6.0).abs() < 1e-10, "{third}");
        }
    }
}
