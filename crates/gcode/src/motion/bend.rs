//! Curves as quintic Hermite polynomials over their arc length: place, direction and curvature at the
//! ends are those of the curve, and the polynomials are so short that they stay within a tolerance.

use super::spline::{End, Spline};
use lostmotion_base::math;
use lostmotion_base::vec::{Vec2, distance2, dot};

/// Most halvings of a part of the curve. After 20, what is left of a
/// span of 1 m is 1 um long.
const MOST_HALVINGS: u32 = 20;
/// Intervals between the places at which a polynomial is compared with the curve. A choice: half of
/// the tolerance is kept for the places between, and more checks cost time; property tests hold the
/// tolerance between them.
const CHECKS_PER_PIECE: u32 = 8;
/// Largest relative deviation of a polynomial's speed from 1, at which its parameter still counts
/// as arc length. A choice, record 19 of the decisions: larger lets the feed vary by as much,
/// smaller makes more pieces.
const LARGEST_SPEED_ERROR: f64 = 0.01;
/// Newton steps towards the curve's nearest point. A choice: each step doubles the digits from the
/// start that the polynomial's own parameter gives.
const NEWTON_STEPS: usize = 4;
/// Gauss-Legendre quadrature with five points: places on [-1, 1] and weights (Abramowitz and
/// Stegun, table 25.4).
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// Parts of a span over which its length is integrated. A choice: more cost time, fewer lose digits
/// where the speed changes fast within a span.
const LENGTH_PARTS: u32 = 16;

/// A straight stretch, or one that bends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    pub(super) start: Vec2,
    pub(super) end: Vec2,
    pub(super) bend: Option<Bent>,
}

/// Derivatives by length at both ends, and the length, in the curve's plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bent {
    pub(super) tangents: [Vec2; 2],
    pub(super) curvatures: [Vec2; 2],
    pub(super) length: f64,
}

impl Stretch {
    fn between(from: &End, to: &End, length: f64) -> Stretch {
        let bend = Bent {
            tangents: [from.tangent, to.tangent],
            curvatures: [from.curvature, to.curvature],
            length,
        };
        Stretch {
            start: from.place,
            end: to.place,
            bend: Some(bend),
        }
    }

    pub(super) fn length(&self) -> f64 {
        self.bend
            .map_or_else(|| distance2(self.start, self.end), |bend| bend.length)
    }

    /// Place and derivative by length, a share of the way along.
    pub(super) fn at(&self, share: f64) -> [Vec2; 2] {
        // De Casteljau: interpolate between control points until two are left, which give the place
        // and the derivative.
        let mut points = self.control();
        for level in (2..6).rev() {
            for index in 0..level {
                points[index] = std::array::from_fn(|i| {
                    (1.0 - share) * points[index][i] + share * points[index + 1][i]
                });
            }
        }
        let [a, b, ..] = points;
        [
            std::array::from_fn(|i| (1.0 - share) * a[i] + share * b[i]),
            std::array::from_fn(|i| 5.0 * (b[i] - a[i]) / self.length()),
        ]
    }

    /// Bernstein control points.
    fn control(&self) -> [Vec2; 6] {
        let length = self.length();
        // A straight stretch has its direction at both ends and no curvature.
        let way = [0, 1].map(|i| (self.end[i] - self.start[i]) / length);
        let ([t0, t1], [k0, k1]) = self.bend.map_or(([way; 2], [[0.0; 2]; 2]), |bend| {
            (bend.tangents, bend.curvatures)
        });
        // The first and last three control points follow from place, velocity and acceleration at
        // that end; by arc length the velocity has length 1.
        let mut points = [self.start; 6];
        for i in 0..2 {
            let (v0, v1, a0, a1) = (
                t0[i] * length / 5.0,
                t1[i] * length / 5.0,
                k0[i] * length * length / 20.0,
                k1[i] * length * length / 20.0,
            );
            let column = [0.0, v0, 2.0 * v0 + a0].map(|p| self.start[i] + p);
            let back = [a1 - 2.0 * v1, -v1, 0.0].map(|p| self.end[i] + p);
            for (point, value) in points.iter_mut().zip(column.into_iter().chain(back)) {
                point[i] = value;
            }
        }
        points
    }
}

/// Length of the curve between two parameters of a span.
fn length(spline: &Spline, span: usize, from: f64, to: f64) -> f64 {
    // Quadrature of the speed over the interval, mapped from [-1, 1].
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let speed = |x: f64| {
        let [_, d1, _] = spline.derivatives(span, middle + half * x);
        math::hypot(d1[0], d1[1])
    };
    half * GAUSS
        .iter()
        .map(|(x, weight)| weight * speed(*x))
        .sum::<f64>()
}

/// Length of a whole curve, in the unit of its points.
pub(super) fn whole_length(spline: &Spline) -> f64 {
    let pieces = |span: usize| {
        (0..LENGTH_PARTS).map(move |piece| {
            [piece, piece + 1].map(|end| span as f64 + f64::from(end) / f64::from(LENGTH_PARTS))
        })
    };
    (0..spline.spans())
        .flat_map(|span| pieces(span).map(move |[from, to]| length(spline, span, from, to)))
        .sum()
}

/// Polynomials along a stretch of a span of a curve within a tolerance, in order.
pub(super) fn stretches(
    spline: &Spline,
    span: usize,
    [from, to]: [f64; 2],
    tolerance: f64,
    halvings: u32,
    out: &mut Vec<Stretch>,
) {
    // Place, tangent and curvature by length at both ends determine the quintic.
    let (start, end) = (spline.end(span, from), spline.end(span, to));
    let middle = 0.5 * (from + to);
    let splits = halvings < MOST_HALVINGS && middle > from && middle < to;
    let length = length(spline, span, from, to);
    // One polynomial if it fits, else two halves, else (no direction, or too short) a straight line.
    if let (Some(first), Some(last)) = (&start, &end)
        && length > 0.0
        && let stretch = Stretch::between(first, last, length)
        && fits(spline, span, [from, to], &stretch, tolerance)
    {
        out.push(stretch);
    } else if splits && length > 0.0 {
        stretches(spline, span, [from, middle], tolerance, halvings + 1, out);
        stretches(spline, span, [middle, to], tolerance, halvings + 1, out);
    } else {
        let [start, end] = [from, to].map(|parameter| spline.derivatives(span, parameter)[0]);
        if start != end {
            out.push(Stretch {
                start,
                end,
                bend: None,
            });
        }
    }
}

/// Whether a polynomial keeps near the curve and its parameter near its length.
fn fits(
    spline: &Spline,
    span: usize,
    [from, to]: [f64; 2],
    stretch: &Stretch,
    tolerance: f64,
) -> bool {
    (0..=CHECKS_PER_PIECE).all(|check| {
        let share = f64::from(check) / f64::from(CHECKS_PER_PIECE);
        let [place, slope] = stretch.at(share);
        let mut parameter = from + (to - from) * share;
        // Project the polynomial's place onto the curve.
        let mut here = spline.derivatives(span, parameter);
        for _ in 0..NEWTON_STEPS {
            let [at, d1, _] = here;
            // Gauss-Newton step towards the foot point, kept within the stretch.
            let square = dot(d1, d1);
            if square == 0.0 {
                break;
            }
            parameter = (parameter + dot([place[0] - at[0], place[1] - at[1]], d1) / square)
                .clamp(from, to);
            here = spline.derivatives(span, parameter);
        }
        // Half of the tolerance is left for the places between the checks.
        (math::hypot(slope[0], slope[1]) - 1.0).abs() <= LARGEST_SPEED_ERROR
            && distance2(here[0], place) <= 0.5 * tolerance
    })
}
