//! Fewer points with the same look.

/// Indices of the points that keep a polyline within `tolerance` of all its points (Ramer, Douglas
/// and Peucker), in order, first and last included.
pub(super) fn keep(points: &[[f64; 2]], tolerance: f64) -> Vec<usize> {
    let last = match points.len() {
        0 => return Vec::new(),
        n => n - 1,
    };
    let mut kept = vec![false; points.len()];
    kept[0] = true;
    kept[last] = true;
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
