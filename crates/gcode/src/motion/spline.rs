//! Rational B-splines on a clamped uniform knot vector: points and tangents (de Boor's algorithm).

use super::biarc::Point;
use lostmotion_base::math;

/// A curve in machine coordinates, mm.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spline {
    degree: usize,
    /// Weighted coordinates and weight.
    points: Vec<[f64; 3]>,
}

impl Spline {
    /// From points, weights and the order, which is at least 2 and at most the number of points.
    pub(super) fn new(points: impl Iterator<Item = (Point, f64)>, order: usize) -> Option<Spline> {
        let points: Vec<[f64; 3]> = points.map(|(at, weight)| [at[0] * weight, at[1] * weight, weight]).collect();
        if order < 2 || points.len() < order { None } else { Some(Spline { degree: order - 1, points }) }
    }

    /// Number of spans between knots; the parameter runs from 0 to this.
    pub(super) fn spans(&self) -> usize {
        self.points.len() - self.degree
    }

    fn knot(&self, index: usize) -> f64 {
        index.saturating_sub(self.degree).min(self.spans()) as f64
    }

    /// The point of a parameter, and the unit tangent if there is one.
    pub(super) fn at(&self, parameter: f64) -> (Point, Option<Point>) {
        let span = (parameter.max(0.0) as usize).min(self.spans() - 1);
        let mut points: Vec<[f64; 3]> = self.points.get(span..=span + self.degree).unwrap_or_default().to_vec();
        let mut slope = [0.0; 3];
        for level in 1..=self.degree {
            if level == self.degree
                && let [.., a, b] = points.as_slice()
            {
                // The last two points span the tangent; the knot interval between them is one.
                slope = std::array::from_fn(|i| (b[i] - a[i]) * self.degree as f64);
            }
            for index in (level..=self.degree).rev() {
                let low = self.knot(span + index);
                let high = self.knot(span + index + self.degree + 1 - level);
                let share = if high > low { (parameter - low) / (high - low) } else { 0.0 };
                if let Some([before, here]) = points.get_mut(index - 1..=index) {
                    *here = std::array::from_fn(|i| (1.0 - share) * before[i] + share * here[i]);
                }
            }
        }
        let [x, y, w] = points.last().copied().unwrap_or_default();
        let place = [x / w, y / w];
        // Quotient rule, up to a positive factor.
        let way = [slope[0] - slope[2] * place[0], slope[1] - slope[2] * place[1]];
        let length = math::hypot(way[0], way[1]);
        (place, (length > 1e-9).then(|| [way[0] / length, way[1] / length]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::biarc::strokes;
    use proptest::prelude::*;

    fn curve(points: &[Point], weights: &[f64], order: usize) -> Spline {
        Spline::new(points.iter().copied().zip(weights.iter().copied()), order).unwrap()
    }

    #[test]
    fn a_quarter_circle_is_one() {
        let half = 0.5f64.sqrt();
        let quarter = curve(&[[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], &[1.0, half, 1.0], 3);
        for step in 0..=20 {
            let ([x, y], tangent) = quarter.at(f64::from(step) / 20.0);
            assert!((math::hypot(x, y) - 1.0).abs() < 1e-14);
            let [u, v] = tangent.unwrap();
            assert!((u * x + v * y).abs() < 1e-12 && v * x - u * y > 0.0);
        }
        let mut arcs = Vec::new();
        strokes(&quarter, 0.0, 1.0, 1e-3, 0, &mut arcs);
        assert!(arcs.len() <= 4 && arcs.iter().all(|arc| arc.round.is_some_and(|(center, _)| math::hypot(center[0], center[1]) < 1e-9)));
    }

    #[test]
    fn a_cubic_of_four_points_is_bernstein_s() {
        let points = [[0.0, 0.0], [1.0, 3.0], [4.0, -1.0], [5.0, 2.0]];
        let cubic = curve(&points, &[1.0; 4], 4);
        for step in 0..=10 {
            let t = f64::from(step) / 10.0;
            let s = 1.0 - t;
            let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
            let (place, _) = cubic.at(t);
            for axis in 0..2 {
                let expected: f64 = points.iter().zip(weights).map(|(point, weight)| point[axis] * weight).sum();
                assert!((place[axis] - expected).abs() < 1e-12);
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn arcs_stay_near_the_curve_and_keep_its_ends_and_tangents(
            points in prop::collection::vec([-50.0..50.0_f64, -50.0..50.0_f64], 4..9), weights in prop::collection::vec(0.3..3.0_f64, 9)
        ) {
            let spline = curve(&points, &weights, 4);
            let mut arcs = Vec::new();
            for span in 0..spline.spans() {
                strokes(&spline, span as f64, span as f64 + 1.0, 0.01, 0, &mut arcs);
            }
            prop_assert!(arcs.len() < 20_000);
            prop_assert_eq!(arcs[0].start, spline.at(0.0).0);
            prop_assert_eq!(arcs[arcs.len() - 1].end, spline.at(spline.spans() as f64).0);
            for pair in arcs.windows(2) {
                prop_assert_eq!(pair[0].end, pair[1].start);
            }
            // Brute force: every point of the curve has an arc that it lies on, within the tolerance.
            for step in 0..=50 {
                let (place, _) = spline.at(spline.spans() as f64 * f64::from(step) / 50.0);
                let nearest = arcs.iter().map(|arc| arc.nearest(place)).fold(f64::INFINITY, f64::min);
                prop_assert!(nearest <= 0.01 + 1e-9, "{nearest}");
            }
        }
    }
}
