//! What RS274 means by an arc.

use lostmotion_base::{AxisId, Coords};
use lostmotion_path::{Arc, ArcSpec, Curve, PathError, Plane};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn spec(start: [f64; 2], end: [f64; 2], center: [f64; 2], rotation: i32) -> ArcSpec {
    ArcSpec {
        start: Coords::xyz(start[0], start[1], 0.0),
        end: Coords::xyz(end[0], end[1], 0.0),
        plane: Plane::Xy,
        center,
        rotation,
    }
}

#[test]
fn sweep_by_rotation() {
    let cases = [
        ([0.0, 10.0], 1, FRAC_PI_2),
        ([0.0, 10.0], -1, -3.0 * FRAC_PI_2),
        ([0.0, 10.0], 2, FRAC_PI_2 + TAU),
        ([0.0, 10.0], -3, -3.0 * FRAC_PI_2 - 2.0 * TAU),
        ([-10.0, 0.0], 1, PI),
        ([-10.0, 0.0], -1, -PI),
        ([10.0, 0.0], 1, TAU),
        ([10.0, 0.0], -1, -TAU),
        ([10.0, 0.0], 2, 2.0 * TAU),
        ([0.0, -5.0], 1, 3.0 * FRAC_PI_2),
    ];
    for (end, rotation, sweep) in cases {
        let arc = Arc::new(spec([10.0, 0.0], end, [0.0, 0.0], rotation)).unwrap();
        assert!(
            (arc.sweep() - sweep).abs() < 1e-14,
            "{end:?} {rotation}: {} {sweep}",
            arc.sweep()
        );
    }
}

#[test]
fn a_hair_off_is_still_a_full_turn() {
    for hair in [0.0, 1e-16, 1e-12, 1e-9, -1e-16, -1e-12, -1e-9] {
        for rotation in [1, -1] {
            let arc = Arc::new(spec([10.0, 0.0], [10.0, hair], [0.0, 0.0], rotation)).unwrap();
            assert!(
                (arc.length() - 10.0 * TAU).abs() < 1e-8,
                "{hair} {rotation}: {}",
                arc.length()
            );
            let middle = arc.eval(arc.length() / 2.0);
            assert!((middle.p.0[0] + 10.0).abs() < 1e-8 && middle.d3.is_finite());
        }
    }
    // A micrometre is a real arc, one way the short and the other way the long one.
    let short = Arc::new(spec([10.0, 0.0], [10.0, 1e-3], [0.0, 0.0], 1)).unwrap();
    assert!((short.length() - 1e-3).abs() < 1e-7);
}

#[test]
fn counter_clockwise_is_about_the_normal_of_each_plane() {
    // From the plane's first axis to its second: a quarter turn to the left.
    for (plane, first, second) in [
        (Plane::Xy, AxisId::X, AxisId::Y),
        (Plane::Zx, AxisId::Z, AxisId::X),
        (Plane::Yz, AxisId::Y, AxisId::Z),
    ] {
        let (mut start, mut end) = (Coords::ZERO, Coords::ZERO);
        start[first] = 5.0;
        end[second] = 5.0;
        let arc = Arc::new(ArcSpec {
            start,
            end,
            plane,
            center: [0.0, 0.0],
            rotation: 1,
        })
        .unwrap();
        assert!((arc.length() - 5.0 * FRAC_PI_2).abs() < 1e-13);
        let d1 = arc.eval(0.0).d1;
        assert!((d1[second] - 1.0).abs() < 1e-15 && d1[first].abs() < 1e-15);
    }
}

#[test]
fn helix_and_followers() {
    let mut end = Coords::xyz(3.0, 0.0, 8.0);
    end[AxisId::A] = 2.0;
    let arc = Arc::new(ArcSpec {
        start: Coords::xyz(3.0, 0.0, 0.0),
        end,
        plane: Plane::Xy,
        center: [0.0, 0.0],
        rotation: 2,
    })
    .unwrap();
    let turns = 3.0 * 2.0 * TAU;
    assert!((arc.length() - (turns * turns + 64.0).sqrt()).abs() < 1e-12);
    let middle = arc.eval(arc.length() / 2.0);
    assert!((middle.p[AxisId::Z] - 4.0).abs() < 1e-13 && (middle.p[AxisId::A] - 1.0).abs() < 1e-13);
    // Curvature of a helix: r / (r^2 + p^2), p the rise per radian.
    let rise = 8.0 / (2.0 * TAU);
    assert!((Curve::Arc(arc).curvature(1.0) - 3.0 / (9.0 + rise * rise)).abs() < 1e-14);
}

#[test]
fn what_cannot_exist_is_refused() {
    assert_eq!(
        Arc::new(spec([1.0, 0.0], [0.0, 1.0], [0.0, 0.0], 0)),
        Err(PathError::NoRotation)
    );
    assert!(matches!(
        Arc::new(spec([1.0, 0.0], [0.0, 0.0], [0.0, 0.0], 1)),
        Err(PathError::OnCenter { end: "end", .. })
    ));
    assert!(matches!(
        Arc::new(spec([f64::NAN, 0.0], [0.0, 1.0], [0.0, 0.0], 1)),
        Err(PathError::NotFinite { .. })
    ));
    assert!(matches!(
        Arc::new(spec([1e300, 0.0], [0.0, 1e300], [0.0, 0.0], 1)),
        Err(PathError::NotFinite { .. })
    ));
}

#[test]
fn line_length_follows_the_feed_rule() {
    let to = |xyz: [f64; 3], abc: [f64; 3], uvw: [f64; 3]| {
        Curve::line(
            Coords::ZERO,
            Coords([
                xyz[0], xyz[1], xyz[2], abc[0], abc[1], abc[2], uvw[0], uvw[1], uvw[2],
            ]),
        )
        .length()
    };
    assert!((to([3.0, 0.0, 4.0], [1.0, 0.0, 0.0], [9.0, 0.0, 0.0]) - 5.0).abs() < 1e-15);
    assert!((to([0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 2.0]) - 2.0).abs() < 1e-15);
    assert!((to([0.0; 3], [0.0, 0.0, FRAC_PI_2], [0.0; 3]) - 90.0).abs() < 1e-12);
    assert_eq!(
        to([0.0; 3], [0.0; 3], [0.0; 3]).to_bits(),
        0.0_f64.to_bits()
    );
}
