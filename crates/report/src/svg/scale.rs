//! Ranges, ticks and round numbers; fewer points with the same look.

use lostmotion_base::math;

/// The largest of 1, 2, 5 times a power of ten that is not above `value`; 0 unless it is positive
/// and finite.
pub(crate) fn round_down(value: f64) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return 0.0;
    }
    let decade = math::pow(10.0, math::log10(value).floor());
    // The logarithm of a power of ten can come out just below the integer.
    let decade = if decade * 10.0 <= value * (1.0 + 1e-12) {
        decade * 10.0
    } else {
        decade
    };
    [5.0, 2.0]
        .into_iter()
        .map(|digit| digit * decade)
        .find(|v| *v <= value * (1.0 + 1e-12))
        .unwrap_or(decade)
}

/// A range of values on an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    pub(super) min: f64,
    pub(super) max: f64,
}

impl Range {
    /// The smallest range that holds all finite values; `None` without any.
    pub(super) fn of(values: impl Iterator<Item = f64>) -> Option<Range> {
        values
            .filter(|v| v.is_finite())
            .fold(None, |range: Option<Range>, v| {
                Some(range.map_or(Range { min: v, max: v }, |r| Range {
                    min: r.min.min(v),
                    max: r.max.max(v),
                }))
            })
    }

    pub(super) fn span(&self) -> f64 {
        self.max - self.min
    }

    /// Wider by a part of its span at both ends, and never empty.
    pub(super) fn padded(&self, part: f64) -> Range {
        // A range of one value has no span to take a part of: half the value, or half a unit about
        // zero.
        let pad = if self.span() > 0.0 {
            self.span() * part
        } else {
            self.max.abs().max(1.0) * 0.5
        };
        Range {
            min: self.min - pad,
            max: self.max + pad,
        }
    }

    /// Round values inside, about `count` of them, with the decimals they need.
    pub(super) fn ticks(&self, count: usize) -> (Vec<f64>, usize) {
        let step = round_down(self.span() / count.max(1) as f64);
        if step <= 0.0 {
            return (Vec::new(), 0);
        }
        // Ticks by their number, not by adding steps: no rounding piles up.
        let first = (self.min / step).ceil() as i64;
        let last = (self.max / step).floor() as i64;
        // As many decimals as the step has: 0.05 needs two, 20 none.
        let decimals = (-math::log10(step).floor()).clamp(0.0, 9.0) as usize;
        ((first..=last).map(|k| k as f64 * step).collect(), decimals)
    }
}

/// Indices of the points that keep a polyline within `tolerance` of all its points (Ramer, Douglas
/// and Peucker), in order, first and last included.
pub(crate) fn keep(points: &[[f64; 2]], tolerance: f64) -> Vec<usize> {
    let last = match points.len() {
        0 => return Vec::new(),
        n => n - 1,
    };
    let mut kept = vec![false; points.len()];
    kept[0] = true;
    kept[last] = true;
    // Of each stretch the farthest point is kept and splits it, until all lie within the tolerance.
    // The list of stretches stands in for recursion, which long traces would drive too deep.
    let mut stretches = vec![(0, last)];
    while let Some((from, to)) = stretches.pop() {
        let farthest = (from + 1..to)
            .map(|i| (i, distance(points[i], points[from], points[to])))
            .fold(
                (0, 0.0),
                |best, next| if next.1 > best.1 { next } else { best },
            );
        if farthest.1 > tolerance {
            kept[farthest.0] = true;
            stretches.push((from, farthest.0));
            stretches.push((farthest.0, to));
        }
    }
    (0..points.len()).filter(|i| kept[*i]).collect()
}

/// Distance of a point from a stretch.
fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length2 = dx * dx + dy * dy;
    // Foot point on the stretch, clamped to its ends; a closed curve has a stretch of no length.
    let along = if length2 > 0.0 {
        (((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let (ex, ey) = (p[0] - a[0] - along * dx, p[1] - a[1] - along * dy);
    (ex * ex + ey * ey).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_numbers() {
        for (value, round) in [
            (1.0, 1.0),
            (0.999, 0.5),
            (1000.0, 1000.0),
            (4.9, 2.0),
            (5.0, 5.0),
            (0.001, 0.001),
            (73.0, 50.0),
        ] {
            assert!(
                (round_down(value) - round).abs() < 1e-12 * round,
                "{value} {}",
                round_down(value)
            );
        }
        assert_eq!(round_down(0.0).to_bits(), 0.0_f64.to_bits());
        assert_eq!(round_down(f64::NAN).to_bits(), 0.0_f64.to_bits());
    }

    #[test]
    fn ticks_lie_inside() {
        let (ticks, decimals) = Range {
            min: -0.31,
            max: 0.42,
        }
        .ticks(5);
        assert_eq!(decimals, 1);
        assert_eq!(ticks.len(), 8);
        assert!(ticks.iter().all(|t| (-0.31..=0.42).contains(t)));
        assert_eq!(Range { min: 1.0, max: 1.0 }.ticks(4).0, [0.0; 0]);
    }

    use proptest::prelude::*;

    #[test]
    fn a_straight_line_needs_two_points() {
        let line: Vec<[f64; 2]> = (0..100)
            .map(|i| [f64::from(i), 2.0 * f64::from(i)])
            .collect();
        assert_eq!(keep(&line, 0.01), [0, 99]);
        assert_eq!(keep(&[[1.0, 1.0]], 0.01), [0]);
        assert_eq!(keep(&[], 0.01), [0; 0]);
    }

    proptest! {
        /// Every point dropped lies within the tolerance of what is kept.
        #[test]
        fn dropped_points_are_near(ys in prop::collection::vec(-10.0..10.0_f64, 2..60)) {
            let points: Vec<[f64; 2]> = ys.iter().enumerate().map(|(i, y)| [i as f64, *y]).collect();
            let kept = keep(&points, 1.0);
            for (i, point) in points.iter().enumerate() {
                let near = kept.windows(2).any(|pair| distance(*point, points[pair[0]], points[pair[1]]) <= 1.0 + 1e-12);
                prop_assert!(near, "{i}");
            }
        }
    }
}
