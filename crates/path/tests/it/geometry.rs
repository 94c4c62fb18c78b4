//! Length, derivatives and bounds of every kind of curve against quadrature, differences and
//! samples.

use crate::common::{arc, coords, curve, quintic};
use lostmotion_base::{AXES, Coords};
use lostmotion_path::{Curve, HermiteEnd, Quintic};
use proptest::prelude::*;

fn close(a: Coords, b: Coords, tolerance: f64) -> bool {
    (a - b).0.iter().all(|d| d.abs() <= tolerance)
}

/// Central differences of fourth order of a function of s.
fn slope(f: impl Fn(f64) -> Coords, s: f64, h: f64) -> Coords {
    (f(s - 2.0 * h) + f(s - h) * -8.0 + f(s + h) * 8.0 + -f(s + 2.0 * h)) * (1.0 / (12.0 * h))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn ends_are_exact(curve in curve()) {
        prop_assert_eq!(curve.point(0.0), curve.start());
        prop_assert!(close(curve.point(curve.length()), curve.end(), 1e-13));
        prop_assert!(close(curve.eval(curve.length() * (1.0 - 1e-15)).p, curve.end(), 1e-9));
    }

    #[test]
    fn derivatives_agree_with_differences(curve in curve(), at in 0.05..0.95_f64) {
        let s = at * curve.length();
        // Smaller than the smallest radius in `common`, so that the differences' own error stays
        // small.
        let h = 1e-3 * curve.length().min(1.0);
        let derivs = curve.eval(s);
        prop_assert!(close(derivs.p, curve.point(s), 1e-13));
        let largest = |d: Coords| d.0.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        // A difference divides the rounding of its values by h: 9 um of arc that end at 30 degrees
        // of a rotary axis are known to 3e-15 / 9e-6.
        let scale = |d: Coords, of: Coords| {
            1e-8 * (1.0 + largest(d)) + 32.0 * f64::EPSILON * (1.0 + largest(of)) / h
        };
        let d1 = slope(|t| curve.point(t), s, h);
        let d2 = slope(|t| curve.eval(t).d1, s, h);
        let d3 = slope(|t| curve.eval(t).d2, s, h);
        prop_assert!(close(derivs.d1, d1, scale(derivs.d1, derivs.p)), "{:?} {d1:?}", derivs.d1);
        prop_assert!(close(derivs.d2, d2, scale(derivs.d2, derivs.d1)), "{:?} {d2:?}", derivs.d2);
        prop_assert!(close(derivs.d3, d3, 10.0 * scale(derivs.d3, derivs.d2)), "{:?} {d3:?}", derivs.d3);
    }

    #[test]
    fn arcs_run_at_unit_speed(curve in arc(), at in 0.0..1.0_f64) {
        let speed = curve.eval(at * curve.length()).d1.linear_norm();
        prop_assert!((speed - 1.0).abs() < 1e-12, "{speed}");
    }

    #[test]
    fn an_arc_is_as_long_as_its_chords(curve in arc()) {
        // Richardson's extrapolation of inscribed polygons.
        let polygon = |n: u32| {
            let mut sum = 0.0;
            for i in 0..n {
                let at = |k: u32| curve.point(curve.length() * f64::from(k) / f64::from(n));
                sum += (at(i + 1) - at(i)).linear_norm();
            }
            sum
        };
        let (coarse, fine) = (polygon(1000), polygon(2000));
        let length = fine + (fine - coarse) / 3.0;
        prop_assert!((length - curve.length()).abs() < 1e-8 * length, "{length} {}", curve.length());
    }

    #[test]
    fn bounds_hold_every_point_and_are_tight(curve in curve()) {
        let bounds = curve.bounds();
        let (mut low, mut high) = (curve.start(), curve.start());
        let n = 5000;
        for i in 0..=n {
            let p = curve.point(curve.length() * f64::from(i) / f64::from(n));
            for axis in 0..AXES {
                low.0[axis] = low.0[axis].min(p.0[axis]);
                high.0[axis] = high.0[axis].max(p.0[axis]);
            }
        }
        let step = curve.length() / f64::from(n);
        let second = curve.max_derivatives(0.0, curve.length()).1;
        for axis in 0..AXES {
            let missed = second.0[axis] * step * step / 8.0 + 3e-6;
            prop_assert!(bounds.min.0[axis] <= low.0[axis] + 1e-12 && bounds.min.0[axis] >= low.0[axis] - missed);
            prop_assert!(bounds.max.0[axis] >= high.0[axis] - 1e-12 && bounds.max.0[axis] <= high.0[axis] + missed);
        }
    }

    #[test]
    fn derivative_bounds_hold(curve in curve(), from in 0.0..1.0_f64, stretch in 0.0..1.0_f64) {
        let (s0, s1) = (from * curve.length(), (from + (1.0 - from) * stretch) * curve.length());
        let (b1, b2, b3) = curve.max_derivatives(s0, s1);
        for i in 0..=200 {
            let derivs = curve.eval(s0 + (s1 - s0) * f64::from(i) / 200.0);
            for (d, b) in [(derivs.d1, b1), (derivs.d2, b2), (derivs.d3, b3)] {
                for axis in 0..AXES {
                    prop_assert!(d.0[axis].abs() <= b.0[axis] * (1.0 + 1e-9) + 1e-10, "{d:?} {b:?}");
                }
            }
        }
    }

    #[test]
    fn derivative_bounds_are_tight_on_short_stretches(curve in curve(), from in 0.0..0.999_f64) {
        let s0 = from * curve.length();
        let (b1, b2, b3) = curve.max_derivatives(s0, s0 + 1e-7 * curve.length());
        let derivs = curve.eval(s0);
        let spiral = matches!(&curve, Curve::Arc(arc) if !arc.is_circular());
        // Over a spiral the second and third carry terms that are bounded one by one.
        if !spiral {
            for (d, b) in [(derivs.d1, b1), (derivs.d2, b2), (derivs.d3, b3)] {
                let size = b.0.iter().fold(1e-3_f64, |m, c| m.max(*c));
                prop_assert!(close(d.map(f64::abs), b, 1e-4 * size), "{d:?} {b:?}");
            }
        }
    }

    #[test]
    fn parts_are_the_whole(curve in curve(), from in 0.0..1.0_f64, to in 0.0..1.0_f64, at in 0.0..1.0_f64) {
        let (s0, s1) = (from.min(to) * curve.length(), from.max(to) * curve.length());
        let part = curve.sub(s0, s1);
        prop_assert!((part.length() - (s1 - s0)).abs() < 1e-12);
        let s = at * part.length();
        prop_assert!(close(part.point(s), curve.point(s0 + s), 1e-10));
        prop_assert!(close(part.eval(s).d1, curve.eval(s0 + s).d1, 1e-6));
        let (head, tail) = curve.split_at(s0);
        prop_assert!((head.length() + tail.length() - curve.length()).abs() < 1e-12);
        prop_assert!(close(head.end(), tail.start(), 1e-10));
    }

    #[test]
    fn a_quintic_meets_its_hermite_data(p in coords(500.0), q in coords(500.0), d in prop::array::uniform4(coords(1.0)), length in 0.1..100.0_f64) {
        let [d1, d2, e1, e2] = d;
        let (start, end) = (HermiteEnd { p, d1, d2 }, HermiteEnd { p: q, d1: e1, d2: e2 });
        let piece = Quintic::hermite(start, end, length).unwrap();
        let (a, b) = (piece.eval(0.0), piece.eval(length));
        for (got, meant) in [(a.p, p), (a.d1, d1), (b.p, q), (b.d1, e1)] {
            prop_assert!(close(got, meant, 1e-9));
        }
        let rounding = 1e-10 * (1.0 + 1.0 / (length * length));
        prop_assert!(close(a.d2, d2, rounding) && close(b.d2, e2, rounding));
        let again = Quintic::from_control_points(piece.control_points(), length).unwrap();
        prop_assert!(close(again.point(0.3 * length), piece.point(0.3 * length), 1e-11));
    }

    #[test]
    fn tangent_and_curvature_of_a_quintic(curve in quintic(), at in 0.1..0.9_f64) {
        let (s, h) = (at * curve.length(), 1e-4 * curve.length());
        let speed = curve.eval(s).d1.linear_norm();
        prop_assume!(speed > 0.3);
        // Curvature is the change of the unit tangent by arc length.
        let (a, b) = (curve.tangent(s - h), curve.tangent(s + h));
        let turn = ((b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]) + (b[2] - a[2]) * (b[2] - a[2])).sqrt();
        let rate = turn / (2.0 * h * speed);
        prop_assert!((rate - curve.curvature(s)).abs() < 1e-3 * (1.0 + rate * rate), "{rate} {}", curve.curvature(s));
    }
}
