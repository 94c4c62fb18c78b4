//! Nearest points against brute force.

use crate::common::{arc, curve};
use lostmotion_base::Coords;
use lostmotion_path::{Arc, ArcSpec, Curve, Plane};
use proptest::prelude::*;

fn distance(curve: &Curve, s: f64, point: [f64; 3]) -> f64 {
    let [x, y, z] = curve.point(s).linear();
    (Coords::xyz(x, y, z) - Coords::xyz(point[0], point[1], point[2])).linear_norm()
}

/// Dense samples; the true minimum lies at most one step's worth of path below.
fn sampled(curve: &Curve, point: [f64; 3], (s0, s1): (f64, f64)) -> f64 {
    let n = 4000;
    (0..=n)
        .map(|i| distance(curve, s0 + (s1 - s0) * f64::from(i) / f64::from(n), point))
        .fold(f64::INFINITY, f64::min)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_sample_is_nearer(curve in curve(), offset in prop::array::uniform3(-30.0..30.0_f64), near in 0.0..1.0_f64, scale in prop_oneof![Just(1.0), Just(1e-3)], from in 0.0..1.0_f64, to in 0.0..1.0_f64) {
        let [x, y, z] = curve.point(near * curve.length()).linear();
        let point = [x + scale * offset[0], y + scale * offset[1], z + scale * offset[2]];
        let range = (from.min(to) * curve.length(), from.max(to) * curve.length());
        let foot = curve.nearest(point, range, 1e-9);
        prop_assert!(foot.s >= range.0 && foot.s <= range.1);
        prop_assert!((distance(&curve, foot.s, point) - foot.distance).abs() < 1e-9);
        let least = sampled(&curve, point, range);
        prop_assert!(foot.distance <= least + 2e-9, "{} {least}", foot.distance);
        // Samples can miss the minimum by no more than the path between two of them.
        let step = (range.1 - range.0) / 4000.0 * curve.max_derivatives(range.0, range.1).0.linear_norm();
        prop_assert!(foot.distance >= least - step - 1e-12);
    }

    #[test]
    fn a_point_set_off_a_gentle_curve_is_found_again(curve in arc(), at in 0.02..0.98_f64, off in -0.01..0.01_f64) {
        // Off along the binormal direction of the plane by less than any radius: the foot is where
        // it was set off.
        let s = at * curve.length();
        let t = curve.tangent(s);
        let normal = curve.eval(s).d2.linear();
        let size = (normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]).sqrt();
        let p = curve.point(s).linear();
        let point: [f64; 3] = std::array::from_fn(|i| p[i] + off * normal[i] / size);
        prop_assert!((t[0] * normal[0] + t[1] * normal[1] + t[2] * normal[2]).abs() < 1e-12);
        let foot = curve.nearest(point, (s - 0.02, s + 0.02), 1e-12);
        prop_assert!((foot.distance - off.abs()).abs() < 1e-12);
        prop_assert!((foot.s - s).abs() < 1e-6, "{} {s}", foot.s);
    }
}

#[test]
fn a_point_on_the_axis_of_almost_a_circle_ends() {
    // Nowhere on this spiral is much nearer than elsewhere: the proof has to stop at the tolerance,
    // not at rounding.
    for gap in [1e-3, 1e-6, 1e-9] {
        let spec = ArcSpec {
            start: Coords::xyz(10.0, 0.0, 0.0),
            end: Coords::xyz(10.0 + gap, 0.0, 0.0),
            plane: Plane::Xy,
            center: [0.0, 0.0],
            rotation: 1,
        };
        let curve = Curve::Arc(Arc::new(spec).unwrap());
        let foot = curve.nearest([0.0, 0.0, 0.0], (0.0, curve.length()), 1e-6);
        assert!((foot.distance - 10.0).abs() < 2e-6);
    }
}

#[test]
fn of_a_rotary_move_the_first_point_is_taken() {
    let mut end = Coords::xyz(1.0, 2.0, 3.0);
    end.0[3] = 1.0;
    let curve = Curve::line(Coords::xyz(1.0, 2.0, 3.0), end);
    let foot = curve.nearest([1.0, 2.0, 8.0], (10.0, 50.0), 1e-6);
    assert!((foot.s - 10.0).abs() < 1e-15 && (foot.distance - 5.0).abs() < 1e-15);
    assert!(!curve.moves_tip());
}
