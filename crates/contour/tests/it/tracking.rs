//! Foot points, and the sign and size of contour errors, against closed forms and brute force.

use lostmotion_base::{BlockRef, Coords, math};
use lostmotion_contour::{
    ContourConfig, ContourError, ContourInput, ContourTracker, FootState, ProgrammedSegment,
};
use lostmotion_path::{Arc, ArcSpec, Curve, Plane};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};

const UP: [f64; 3] = [0.0, 0.0, 1.0];

fn segment(index: u64, curve: Curve) -> ProgrammedSegment {
    ProgrammedSegment {
        index,
        curve,
        plane: Plane::Xy,
        rapid: false,
        origin_mm: [0.0; 3],
        block: BlockRef::default(),
    }
}

fn tracker(curves: &[Curve]) -> ContourTracker {
    let mut tracker = ContourTracker::new(ContourConfig::default());
    for (index, curve) in curves.iter().enumerate() {
        tracker.push(segment(index as u64, *curve)).unwrap();
    }
    tracker
}

fn polyline(points: &[[f64; 2]]) -> Vec<Curve> {
    points
        .windows(2)
        .map(|pair| {
            Curve::line(
                Coords::xyz(pair[0][0], pair[0][1], 0.0),
                Coords::xyz(pair[1][0], pair[1][1], 0.0),
            )
        })
        .collect()
}

fn arc(start: [f64; 2], end: [f64; 2], center: [f64; 2], rotation: i32) -> Curve {
    let [start, end] = [start, end].map(|p| Coords::xyz(p[0], p[1], 0.0));
    Curve::Arc(
        Arc::new(ArcSpec {
            start,
            end,
            plane: Plane::Xy,
            center,
            rotation,
        })
        .unwrap(),
    )
}

fn input(segment: u64, s: f64, actual: [f64; 3], commanded: [f64; 3]) -> ContourInput {
    ContourInput {
        tick: 7,
        segment,
        s,
        actual_tip_mm: actual,
        commanded_tip_mm: commanded,
        actual_axis: UP,
        commanded_axis: UP,
    }
}

/// Error of a fresh machine that stands at `actual` while the command is at (segment, s).
fn error(curves: &[Curve], segment: u64, s: f64, actual: [f64; 3]) -> f64 {
    let commanded = curves[segment as usize].point(s).linear();
    tracker(curves)
        .measure(
            &mut FootState::default(),
            &input(segment, s, actual, commanded),
        )
        .unwrap()
        .error_mm
}

#[test]
fn a_circle_run_left_about_has_its_inside_on_the_left() {
    for (rotation, sign) in [(1, 1.0), (-1, -1.0)] {
        let curve = arc([25.0, 0.0], [25.0, 0.0], [0.0, 0.0], rotation);
        for degrees in (0..360).step_by(7) {
            let (sin, cos) = math::sin_cos(f64::from(degrees) * TAU / 360.0);
            let s =
                25.0 * if rotation > 0 {
                    f64::from(degrees)
                } else {
                    (360.0 - f64::from(degrees)) % 360.0
                } * TAU
                    / 360.0;
            for radius in [24.9, 25.03] {
                let found = error(&[curve], 0, s, [radius * cos, radius * sin, 0.0]);
                assert!(
                    (found - sign * (25.0 - radius)).abs() < 1e-12,
                    "{rotation} {degrees} {radius}: {found}"
                );
            }
        }
    }
}

#[test]
fn the_crossing_of_a_figure_eight_does_not_attract_the_foot() {
    // Two full circles of radius 10 that touch the origin, run one after the other, crossing there
    // at right angles.
    let first = arc([0.0, 0.0], [0.0, 0.0], [10.0, 0.0], 1);
    let second = arc([0.0, 0.0], [0.0, 0.0], [0.0, 10.0], 1);
    let curves = [first, second];
    let tracker = tracker(&curves);
    let mut foot = FootState::default();
    let mut last = 0.0;
    for step in 0..20_000 {
        // Servo lag of 3 mm along the path and 0.4 mm off to the left, so near the origin the other
        // circle is nearer.
        let command = f64::from(step) * 2.0 * TAU * 10.0 / 20_000.0;
        let lagging = (command - 3.0).max(0.0);
        let place = |at: f64| {
            if at < TAU * 10.0 {
                (0, at)
            } else {
                (1, at - TAU * 10.0)
            }
        };
        let (index, s) = place(lagging);
        let (p, t) = (curves[index].point(s).linear(), curves[index].tangent(s));
        let actual = [p[0] - 0.4 * t[1], p[1] + 0.4 * t[0], 0.0];
        let (segment, at) = place(command);
        let sample = tracker
            .measure(
                &mut foot,
                &input(
                    segment as u64,
                    at,
                    actual,
                    curves[segment].point(at).linear(),
                ),
            )
            .unwrap();
        let on_path = sample.s + if sample.segment == 1 { TAU * 10.0 } else { 0.0 };
        // Inside the corner between the circles the nearest point changes from one leg to the
        // other.
        let joint = (lagging - TAU * 10.0).abs() < 1.5;
        let back = if joint { 1.0 } else { 0.0 };
        assert!(
            on_path >= last - back && on_path <= command + 1e-9,
            "{step}: foot at {on_path} after {last}"
        );
        assert!(
            joint || (sample.error_mm - 0.4).abs() < 1e-9,
            "{step}: {}",
            sample.error_mm
        );
        last = on_path;
    }
}

#[test]
fn corners_have_one_outside() {
    // Left turns of 45, 90 and 170 degrees at the origin: the outside is on the right.
    for turn in [FRAC_PI_2 / 2.0, FRAC_PI_2, 170.0 * TAU / 360.0] {
        let (sin, cos) = math::sin_cos(turn);
        let curves = polyline(&[[-10.0, 0.0], [0.0, 0.0], [10.0 * cos, 10.0 * sin]]);
        for part in [0.0, 0.2, 0.5, 0.8, 1.0] {
            // Between the two outward normals.
            let (y, x) = math::sin_cos(-FRAC_PI_2 + part * turn);
            let found = error(&curves, 0, 10.0, [0.05 * x, 0.05 * y, 0.0]);
            assert!((found + 0.05).abs() < 1e-12, "{turn} {part}: {found}");
        }
        let (y, x) = math::sin_cos(FRAC_PI_2 + 0.5 * turn);
        let inside = error(&curves, 0, 10.0, [0.05 * x, 0.05 * y, 0.0]);
        assert!(
            (inside - 0.05 * math::cos(0.5 * turn)).abs() < 1e-12,
            "{turn}: {inside}"
        );
    }
}

#[test]
fn a_lagging_machine_is_not_lost_around_a_sharp_corner() {
    // 10 degrees between the legs, 4 mm of lag: the actual tip is 2 mm before the corner, the
    // command 2 mm behind it and only 0.35 mm away. The machine is exactly on the path.
    let (sin, cos) = math::sin_cos(170.0 * TAU / 360.0);
    let curves = polyline(&[[-10.0, 0.0], [0.0, 0.0], [10.0 * cos, 10.0 * sin]]);
    let tracker = tracker(&curves);
    let mut foot = FootState::default();
    for step in 0..1900 {
        let command = f64::from(step) * 0.01;
        let (segment, s) = if command < 10.0 {
            (0, command)
        } else {
            (1, command - 10.0)
        };
        let lagging = (command - 4.0).max(0.0);
        let (own, at) = if lagging < 10.0 {
            (0, lagging)
        } else {
            (1, lagging - 10.0)
        };
        let actual = curves[own].point(at).linear();
        let sample = tracker
            .measure(
                &mut foot,
                &input(
                    segment,
                    s,
                    actual,
                    curves[segment as usize].point(s).linear(),
                ),
            )
            .unwrap();
        assert!(sample.distance_mm < 1e-12, "{step}: {}", sample.distance_mm);
    }
}

#[test]
fn overshoot_at_the_end_is_positive_and_normal_errors_too() {
    let curves = polyline(&[[0.0, 0.0], [10.0, 0.0]]);
    for lateral in [-1e-5, 0.0, 1e-5] {
        assert!((error(&curves, 0, 10.0, [10.005, lateral, 0.0]) - 0.005).abs() < 1e-7);
        assert!((error(&curves, 0, 5.0, [5.0, lateral, 0.005]) - 0.005).abs() < 1e-7);
    }
    // Off the plane, the shadow has a side.
    assert!((error(&curves, 0, 5.0, [5.0, -3.0, 4.0]) + 5.0).abs() < 1e-12);
    // Plunging along the normal, nothing is left or right.
    let plunge = Curve::line(Coords::xyz(0.0, 0.0, 5.0), Coords::ZERO);
    assert!((error(&[plunge], 0, 2.0, [-0.3, 0.4, 3.0]) - 0.5).abs() < 1e-12);
}

#[test]
fn rotary_moves_measure_to_the_point_with_the_side_of_their_neighbours() {
    let corner = Coords::xyz(10.0, 0.0, 0.0);
    let mut turned = corner;
    turned.0[3] = 1.0;
    let mut end = Coords::xyz(10.0, 10.0, 0.0);
    end.0[3] = 1.0;
    let curves = [
        Curve::line(Coords::ZERO, corner),
        Curve::line(corner, turned),
        Curve::line(turned, end),
    ];
    let tracker = tracker(&curves);
    let mut tilted = input(1, 20.0, [10.03, -0.04, 0.0], [10.0, 0.0, 0.0]);
    tilted.actual_axis = [0.0, math::sin(1e-5), math::cos(1e-5)];
    let sample = tracker.measure(&mut FootState::default(), &tilted).unwrap();
    assert_eq!(sample.segment, 1);
    assert!((sample.s - 20.0).abs() < 1e-12 && (sample.error_mm + 0.05).abs() < 1e-12);
    assert!((sample.orientation_error_rad - 1e-5).abs() < 1e-15 && sample.near_corner);
    let alone = [Curve::line(corner, turned)];
    assert!((error(&alone, 0, 1.0, [10.0, 0.0, 0.02]) - 0.02).abs() < 1e-15);
}

#[test]
fn the_plane_tells_the_side() {
    // G18 runs from Z to X: moving along +Z, +X is on the left.
    let curve = Curve::line(Coords::ZERO, Coords::xyz(0.0, 0.0, 10.0));
    let mut tracker = ContourTracker::new(ContourConfig::default());
    tracker
        .push(ProgrammedSegment {
            plane: Plane::Zx,
            ..segment(0, curve)
        })
        .unwrap();
    let sample = tracker
        .measure(
            &mut FootState::default(),
            &input(0, 5.0, [0.01, 0.0, 5.0], [0.0, 0.0, 5.0]),
        )
        .unwrap();
    assert!((sample.error_mm - 0.01).abs() < 1e-15);
}

#[test]
fn near_corner_is_said_near_corners_only() {
    let curves = [
        Curve::line(Coords::ZERO, Coords::xyz(20.0, 0.0, 0.0)),
        // Tangent, but the curvature steps by 1/20.
        arc([20.0, 0.0], [40.0, 20.0], [20.0, 20.0], 1),
        Curve::line(Coords::xyz(40.0, 20.0, 0.0), Coords::xyz(40.0, 40.0, 0.0)),
    ];
    let tracker = tracker(&curves);
    let near = |segment: u64, s: f64| {
        let p = curves[segment as usize].point(s).linear();
        tracker
            .measure(&mut FootState::default(), &input(segment, s, p, p))
            .unwrap()
            .near_corner
    };
    assert!(
        !near(0, 5.0)
            && near(0, 19.0)
            && near(1, 1.0)
            && !near(1, 15.0)
            && near(2, 1.9)
            && !near(2, 2.1)
    );
}

#[test]
fn the_past_is_let_go() {
    let mut tracker = ContourTracker::new(ContourConfig {
        max_window_mm: 5.0,
        ..ContourConfig::default()
    });
    let mut foot = FootState::default();
    for index in 0..10_000_u64 {
        let at = |k: u64| Coords::xyz(k as f64 * 0.1, 0.0, 0.0);
        tracker
            .push(segment(index, Curve::line(at(index), at(index + 1))))
            .unwrap();
        let actual = [index as f64 * 0.1 - 0.3, 0.01, 0.0];
        let sample = tracker
            .measure(&mut foot, &input(index, 0.0, actual, at(index).linear()))
            .unwrap();
        assert!(index < 10 || (sample.error_mm - 0.01).abs() < 1e-12);
        let oldest = tracker.release(index, 0.0).unwrap();
        assert!(oldest <= sample.segment && tracker.held() < 60);
    }
    let gone = tracker
        .measure(&mut foot, &input(3, 0.0, [0.0; 3], [0.0; 3]))
        .unwrap_err();
    assert!(
        gone.to_string()
            .contains("segment 3, which is not held (held are 99"),
        "{gone}"
    );
    assert_eq!(
        tracker.push(segment(5, Curve::line(Coords::ZERO, Coords::ZERO))),
        Err(ContourError::Order {
            pushed: 5,
            last: 9999
        })
    );
    assert!(matches!(
        tracker.measure(&mut foot, &input(9999, 0.0, [f64::NAN, 0.0, 0.0], [0.0; 3])),
        Err(ContourError::NotFinite { .. })
    ));
    // Moves without any path are let go by number.
    let mut still = ContourTracker::new(ContourConfig {
        max_segments: 100,
        ..ContourConfig::default()
    });
    for index in 0..1000 {
        still
            .push(segment(index, Curve::line(Coords::ZERO, Coords::ZERO)))
            .unwrap();
        still.release(index, 0.0);
    }
    assert_eq!(still.held(), 101);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn no_sampled_point_of_the_window_is_nearer(
        points in prop::collection::vec(prop::array::uniform2(-4.0..4.0_f64), 3..12), at in 0.0..1.0_f64, off in prop::array::uniform3(-1.5..1.5_f64)
    ) {
        let curves = polyline(&points);
        let lengths: Vec<f64> = curves.iter().map(Curve::length).collect();
        let total: f64 = lengths.iter().sum();
        let locate = |mut place: f64| {
            for (index, length) in lengths.iter().enumerate() {
                if place <= *length || index + 1 == lengths.len() {
                    return (index, place.min(*length));
                }
                place -= length;
            }
            (0, 0.0)
        };
        let command = at * total;
        let (index, s) = locate(command);
        let p = curves[index].point(s).linear();
        let actual = [p[0] + off[0], p[1] + off[1], p[2] + off[2]];
        let sample = tracker(&curves).measure(&mut FootState::default(), &input(index as u64, s, actual, p)).unwrap();
        let margin = (off[0] * off[0] + off[1] * off[1] + off[2] * off[2]).sqrt().max(1.0);
        let (low, high) = ((command - margin).max(0.0), (command + margin).min(total));
        let distance = |q: [f64; 3]| ((q[0] - actual[0]) * (q[0] - actual[0]) + (q[1] - actual[1]) * (q[1] - actual[1]) + (q[2] - actual[2]) * (q[2] - actual[2])).sqrt();
        let mut least = f64::INFINITY;
        for i in 0..=4000 {
            let (index, s) = locate(low + (high - low) * f64::from(i) / 4000.0);
            least = least.min(distance(curves[index].point(s).linear()));
        }
        prop_assert!(sample.distance_mm <= least + 1e-9 && sample.distance_mm >= least - (high - low) / 4000.0);
        prop_assert!((distance(curves[sample.segment as usize].point(sample.s).linear()) - sample.distance_mm).abs() < 1e-9);
        prop_assert!((sample.error_mm.abs() - sample.distance_mm).abs() < 1e-15);
    }
}
