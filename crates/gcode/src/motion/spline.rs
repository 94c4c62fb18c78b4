//! Rational B-splines on a clamped uniform knot vector: points, directions and curvatures (de
//! Boor's algorithm).

use lostmotion_base::vec::Vec2;
use lostmotion_base::{Jet, Real, math};

/// Where a curve is, and which way and how sharply it goes there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct End {
    pub(super) place: Vec2,
    pub(super) tangent: Vec2,
    /// Second derivative by length.
    pub(super) curvature: Vec2,
}

/// Shortest derivative that has a direction, mm.
const LEAST_DERIVATIVE_MM: f64 = 1e-9;

/// A curve in the plane of its control points, mm.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spline {
    degree: usize,
    /// Weighted coordinates and weight.
    points: Vec<[f64; 3]>,
}

impl Spline {
    /// From points, weights and the order, which is at least 2 and at most the number of points.
    pub(super) fn new(points: impl Iterator<Item = (Vec2, f64)>, order: usize) -> Option<Spline> {
        let points: Vec<[f64; 3]> = points
            .map(|(at, weight)| [at[0] * weight, at[1] * weight, weight])
            .collect();
        if order < 2 || points.len() < order {
            None
        } else {
            Some(Spline {
                degree: order - 1,
                points,
            })
        }
    }

    /// Number of spans between knots; the parameter runs from 0 to this.
    pub(super) fn spans(&self) -> usize {
        self.points.len() - self.degree
    }

    fn knot(&self, index: usize) -> f64 {
        // Clamped: the first and last knots are repeated, those between are whole numbers.
        index.saturating_sub(self.degree).min(self.spans()) as f64
    }

    /// The point of a parameter in a span or at its ends, and its first two derivatives by the
    /// parameter there.
    pub(super) fn derivatives(&self, span: usize, parameter: f64) -> [Vec2; 3] {
        let mut points: Vec<[Jet; 3]> = self
            .points
            .iter()
            .skip(span)
            .take(self.degree + 1)
            .map(|point| point.map(Jet::constant))
            .collect();
        // The derivative of the parameter by itself is 1.
        let parameter = Jet::new(parameter, 1.0, 0.0, 0.0);
        // De Boor's algorithm on homogeneous coordinates; jets carry two derivatives along.
        for level in 1..=self.degree {
            for index in (level..=self.degree).rev() {
                let low = self.knot(span + index);
                let high = self.knot(span + index + self.degree + 1 - level);
                // 0 / 0 counts as 0 where knots coincide.
                let per = if high > low { 1.0 / (high - low) } else { 0.0 };
                let share = (parameter - Jet::constant(low)) * Jet::constant(per);
                if let Some([before, here]) = points.get_mut(index - 1..=index) {
                    *here = std::array::from_fn(|i| before[i] + share * (here[i] - before[i]));
                }
            }
        }
        let [x, y, w] =
            points
                .last()
                .copied()
                .unwrap_or([Jet::default(), Jet::default(), Jet::constant(1.0)]);
        // From homogeneous to plane coordinates: the quotient rule is in the jets.
        let [x, y] = [x / w, y / w];
        [0, 1, 2].map(|order| [x.0[order], y.0[order]])
    }

    /// The curve at a parameter in a span or at its ends; `None` where it has no direction.
    pub(super) fn end(&self, span: usize, parameter: f64) -> Option<End> {
        let [place, d1, d2] = self.derivatives(span, parameter);
        let speed = math::hypot(d1[0], d1[1]);
        if speed > LEAST_DERIVATIVE_MM {
            // By arc length: the unit tangent, and the part of the second derivative across it.
            let tangent = d1.map(|d| d / speed);
            let along = d2[0] * tangent[0] + d2[1] * tangent[1];
            let curvature = std::array::from_fn(|i| (d2[i] - along * tangent[i]) / (speed * speed));
            return Some(End {
                place,
                tangent,
                curvature,
            });
        }
        // Where two control points coincide the first derivative vanishes: the curve starts in the
        // direction of the second one.
        let pull = math::hypot(d2[0], d2[1]);
        // At the far end the second derivative points backwards.
        let way = if parameter > span as f64 { -1.0 } else { 1.0 };
        (pull > LEAST_DERIVATIVE_MM).then(|| End {
            place,
            tangent: d2.map(|d| way * d / pull),
            curvature: [0.0; 2],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::bend::{Stretch, stretches};
    use proptest::prelude::*;

    fn curve(points: &[Vec2], weights: &[f64], order: usize) -> Spline {
        Spline::new(points.iter().copied().zip(weights.iter().copied()), order).unwrap()
    }

    fn whole(spline: &Spline, tolerance: f64) -> Vec<Stretch> {
        let mut out = Vec::new();
        for span in 0..spline.spans() {
            stretches(
                spline,
                span,
                [span as f64, span as f64 + 1.0],
                tolerance,
                0,
                &mut out,
            );
        }
        out
    }

    #[test]
    fn a_quarter_circle_is_one() {
        let half = 0.5f64.sqrt();
        let quarter = curve(&[[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], &[1.0, half, 1.0], 3);
        for step in 0..=20 {
            let End {
                place: [x, y],
                tangent: [u, v],
                curvature: [p, q],
            } = quarter.end(0, f64::from(step) / 20.0).unwrap();
            assert!((math::hypot(x, y) - 1.0).abs() < 1e-14);
            assert!((u * x + v * y).abs() < 1e-12 && v * x - u * y > 0.0);
            assert!((p + x).abs() < 1e-12 && (q + y).abs() < 1e-12);
        }
        let stretches = whole(&quarter, 1e-3);
        assert!(stretches.len() <= 4);
        assert!(
            (stretches.iter().map(Stretch::length).sum::<f64>() - std::f64::consts::FRAC_PI_2)
                .abs()
                < 1e-6
        );
        for stretch in &stretches {
            for step in 0..=10 {
                let [[x, y], [u, v]] = stretch.at(f64::from(step) / 10.0);
                assert!(
                    (math::hypot(x, y) - 1.0).abs() < 5e-4
                        && (math::hypot(u, v) - 1.0).abs() < 0.011
                );
            }
        }
    }

    #[test]
    fn a_cubic_of_four_points_is_bernstein_s() {
        let points = [[0.0, 0.0], [1.0, 3.0], [4.0, -1.0], [5.0, 2.0]];
        let cubic = curve(&points, &[1.0; 4], 4);
        for step in 0..=10 {
            let t = f64::from(step) / 10.0;
            let s = 1.0 - t;
            let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
            let [place, slope, bend] = cubic.derivatives(0, t);
            let (first, second) = ([3.0 * s * s, 6.0 * s * t, 3.0 * t * t], [6.0 * s, 6.0 * t]);
            for axis in 0..2 {
                let p = points.map(|point| point[axis]);
                let [d0, d1, d2] = [p[1] - p[0], p[2] - p[1], p[3] - p[2]];
                assert!(
                    (slope[axis] - (first[0] * d0 + first[1] * d1 + first[2] * d2)).abs() < 1e-11
                );
                assert!(
                    (bend[axis] - (second[0] * (d1 - d0) + second[1] * (d2 - d1))).abs() < 1e-11
                );
                let expected: f64 = points
                    .iter()
                    .zip(weights)
                    .map(|(point, weight)| point[axis] * weight)
                    .sum();
                assert!((place[axis] - expected).abs() < 1e-12);
            }
        }
    }

    /// Distance of a point by walking along in small steps, less what a step can hide.
    fn nearest(stretch: &Stretch, point: Vec2) -> f64 {
        let steps = 400;
        let distance = |step: u32| {
            let [[x, y], _] = stretch.at(f64::from(step) / f64::from(steps));
            math::hypot(x - point[0], y - point[1])
        };
        ((0..=steps).map(distance).fold(f64::INFINITY, f64::min)
            - stretch.length() / f64::from(steps))
        .max(0.0)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn stretches_stay_near_the_curve_and_keep_its_ends_tangents_and_curvatures(
            points in prop::collection::vec([-50.0..50.0_f64, -50.0..50.0_f64], 4..9), weights in prop::collection::vec(0.3..3.0_f64, 9)
        ) {
            let spline = curve(&points, &weights, 4);
            let stretches = whole(&spline, 0.01);
            let spans = spline.spans();
            prop_assert!(stretches.len() < 2_000, "{}", stretches.len());
            prop_assert_eq!(stretches[0].start, spline.derivatives(0, 0.0)[0]);
            prop_assert_eq!(stretches[stretches.len() - 1].end, spline.derivatives(spans - 1, spans as f64)[0]);
            for pair in stretches.windows(2) {
                let away = math::hypot(pair[1].start[0] - pair[0].end[0], pair[1].start[1] - pair[0].end[1]);
                prop_assert!(away < 1e-12, "{away}");
                if let (Some(a), Some(b)) = (pair[0].bend, pair[1].bend) {
                    for i in 0..2 {
                        prop_assert!((a.tangents[1][i] - b.tangents[0][i]).abs() < 1e-9);
                        let scale = 1.0 + a.curvatures[1][i].abs();
                        prop_assert!((a.curvatures[1][i] - b.curvatures[0][i]).abs() < 1e-6 * scale);
                    }
                }
            }
            // Brute force: every point of the curve has a stretch that it lies on, within the
            // tolerance.
            for step in 0..=50 {
                let parameter = spans as f64 * f64::from(step) / 50.0;
                let [place, ..] = spline.derivatives((parameter as usize).min(spans - 1), parameter);
                let nearest = stretches.iter().map(|stretch| nearest(stretch, place)).fold(f64::INFINITY, f64::min);
                prop_assert!(nearest <= 0.01 + 1e-9, "{nearest}");
            }
        }
    }
}
