//! Cutter compensation against the definition: the tool's centre stays one radius away from what is
//! programmed.
use crate::tool_path::{self, Point, sampled};
use lostmotion_gcode::{Diagnostic, InterpreterConfig, Motion, Program};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

/// Moves, and the codes of what was found.
fn run(text: &str) -> (Vec<Motion>, Vec<&'static str>) {
    let (moves, found) = tool_path::run(text);
    (moves, found.kept().iter().map(Diagnostic::code).collect())
}

fn to_segment(p: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let share = (((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    (p[0] - a[0] - share * dx).hypot(p[1] - a[1] - share * dy)
}

/// Corners of a convex polygon, counter-clockwise on a circle of 50 mm.
fn polygon() -> impl Strategy<Value = Vec<Point>> {
    prop::collection::vec(0.3..1.0_f64, 3..9).prop_map(|gaps| {
        let total: f64 = gaps.iter().sum();
        let mut angle = 0.0;
        gaps.iter()
            .map(|gap| {
                angle += gap / total * TAU;
                [
                    (5e4 * angle.cos()).round() / 1000.0,
                    (5e4 * angle.sin()).round() / 1000.0,
                ]
            })
            .collect()
    })
}

/// Once round a polygon, entered and left along its first side.
fn round(code: &str, diameter: f64, corners: &[Point]) -> String {
    let [a, b] = [corners[0], corners[1]];
    let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    let mut text = format!(
        "G21 F100\nG0 X{:.9} Y{:.9}\n{code} D{diameter}\n",
        a[0], a[1]
    );
    text += &format!("G1 X{:.9} Y{:.9}\n", middle[0], middle[1]);
    for corner in corners.iter().skip(1).chain([&a, &middle]) {
        text += &format!("X{:.9} Y{:.9}\n", corner[0], corner[1]);
    }
    text + "G40 G0 X200 Y200\nM2\n"
}

/// Largest and smallest distance of the compensated moves from the polygon.
fn distances(moves: &[Motion], corners: &[Point]) -> (f64, f64) {
    let cut = moves
        .iter()
        .skip(2)
        .take(moves.len() - 3)
        .flat_map(|motion| sampled(motion, 20));
    let away = cut.map(|p| {
        (0..corners.len())
            .map(|i| to_segment(p, corners[i], corners[(i + 1) % corners.len()]))
            .fold(f64::MAX, f64::min)
    });
    away.fold((0.0, f64::MAX), |(most, least), d| {
        (f64::max(most, d), f64::min(least, d))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn outside_of_a_polygon_the_tool_is_one_radius_away(corners in polygon(), radius in 0.5..12.0_f64) {
        // The move of entry, half of the first side, has to be longer than the radius.
        prop_assume!((corners[1][0] - corners[0][0]).hypot(corners[1][1] - corners[0][1]) > 2.1 * radius);
        // Counter-clockwise round the part with the part on the left: the tool is on the right.
        let (moves, found) = run(&round("G42.1", 2.0 * radius, &corners));
        prop_assert!(found.is_empty(), "{found:?}");
        let (most, least) = distances(&moves, &corners);
        prop_assert!((most - radius).abs() < 1e-7 && (least - radius).abs() < 1e-7, "{most} {least} {radius}");
        let arcs = moves.iter().filter(|motion| motion.circle.is_some()).count();
        prop_assert_eq!(arcs, corners.len());
    }

    #[test]
    fn inside_of_a_polygon_the_tool_is_one_radius_away(corners in polygon(), radius in 0.1..1.0_f64) {
        let (moves, found) = run(&round("G41.1", 2.0 * radius, &corners));
        prop_assert!(found.is_empty(), "{found:?}");
        let (most, least) = distances(&moves, &corners);
        prop_assert!((most - radius).abs() < 1e-7 && (least - radius).abs() < 1e-7, "{most} {least} {radius}");
    }

    #[test]
    fn no_radius_means_no_change(corners in polygon()) {
        let (with, found) = run(&round("G41.1", 0.0, &corners));
        let (without, _) = run(&round("(off)", 0.0, &corners).replace(" D0", ""));
        prop_assert!(found.is_empty());
        prop_assert_eq!(with.len(), without.len());
        for (a, b) in with.iter().zip(&without) {
            prop_assert_eq!((a.start, a.end, a.circle), (b.start, b.end, b.circle));
        }
    }

    #[test]
    fn arcs_keep_their_centre_and_change_their_radius(radius in 0.1..4.9_f64, inside in any::<bool>()) {
        let code = if inside { "G41.1" } else { "G42.1" };
        let text = format!("F100 G0 X0 Y-5\n{code} D{}\nG1 X5 Y-5\nX10\nG3 X15 Y0 I0 J5\nG1 Y10\nG40 G0 X30\nM2\n", 2.0 * radius);
        let (moves, found) = run(&text);
        prop_assert!(found.is_empty());
        let arc = moves.iter().find(|motion| motion.circle.is_some()).unwrap();
        let expected = if inside { 5.0 - radius } else { 5.0 + radius };
        for point in sampled(arc, 20) {
            prop_assert!(((point[0] - 10.0).hypot(point[1]) - expected).abs() < 1e-9);
        }
    }
}

#[test]
fn a_tool_that_does_not_fit_is_refused() {
    for (text, line) in [
        // A groove of 4 mm for a tool of 6 mm.
        (
            "F100 G0 X-20\nG42.1 D6\nG1 X0\nY10\nX4\nY0\nX20\nG40 G0 Y9\nM2\n",
            6,
        ),
        // An arc of 2 mm from inside.
        (
            "F100 G0 X-20\nG41.1 D6\nG1 X0\nG3 X0 Y4 I0 J2\nG40 G1 X-20\nM2\n",
            4,
        ),
        (
            "F100 G0 X-20\nG41.1 D6\nG1 X-18\nG1 X10\nG40 G1 X-20\nM2\n",
            3,
        ),
        (
            "F100 G0 X-20\nG41.1 D6\nG1 X0\nX10\nG40\nG3 X20 I5\nM2\n",
            6,
        ),
        ("F100 G0 X-20\nG41.1 D6\nG41.1 D6\nG40\nM2\n", 3),
        ("F100 G19\nG41.1 D6\nM2\n", 2),
        ("F100 G41.1 D6\nG1 X10\nG28\nM2\n", 3),
        ("F100 G41.1 D6\nG1 X10\nG55\nG49\nM2\n", 3),
        ("F100 G41.1 D6\nG1 X10\nG81 Z-1 R1\nM2\n", 3),
    ] {
        let diagnostics = Program::new(text.as_bytes(), InterpreterConfig::default()).finish();
        let first = diagnostics.kept().first().unwrap();
        assert_eq!(
            (first.code(), first.place.span.line),
            ("compensation", line),
            "{text}: {first}"
        );
    }
}

#[test]
fn the_order_of_other_actions_is_kept() {
    let text = "F100 G0 X-20\nG42.1 D6\nG1 X0\nM8\nG1 Z-1\nG4 P1\nG1 Y10\nG40 G0 Y30\nM2\n";
    let ops: Vec<String> = Program::new(text.as_bytes(), InterpreterConfig::default())
        .skip(4)
        .map(|op| op.op.to_string())
        .collect();
    let kinds: Vec<&str> = ops
        .iter()
        .map(|op| op.split('(').next().unwrap())
        .take(9)
        .collect();
    assert_eq!(
        kinds,
        [
            "SET_FEED_RATE",
            "STRAIGHT_TRAVERSE",
            "STRAIGHT_FEED",
            "FLOOD_ON",
            "STRAIGHT_FEED",
            "DWELL",
            "ARC_FEED",
            "STRAIGHT_FEED",
            "STRAIGHT_TRAVERSE"
        ]
    );
    assert!(
        ops[6].starts_with("ARC_FEED(3.0000, 0.0000, 0.0000, 0.0000, 1, -1.0000"),
        "{}",
        ops[6]
    );
}

#[test]
fn a_corner_arc_sweeps_the_angle_of_the_corner() {
    let (moves, _) = run("F100 G0 X-20\nG42.1 D6\nG1 X0\nX10 Y10\nG40 G0 Y30\nM2\n");
    let arc = moves.iter().find(|motion| motion.circle.is_some()).unwrap();
    let sweep = sampled(arc, 20)
        .collect::<Vec<_>>()
        .windows(2)
        .map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]))
        .sum::<f64>()
        / 3.0;
    assert!((sweep - PI / 4.0).abs() < 1e-3, "{sweep}");
}
