//! Splines: what they are read as, and how they are moved.
use crate::common::{moves_with, ops};
use lostmotion_base::{AxisId, math};
use lostmotion_gcode::{
    CanonicalOp, Dialect, Feed, InterpreterConfig, Motion, NurbsFeed, SourcedOp,
};

fn curves(text: &str) -> Vec<NurbsFeed> {
    let curve = |op: SourcedOp| {
        if let CanonicalOp::NurbsFeed(curve) = op.op {
            Some(*curve)
        } else {
            None
        }
    };
    ops(text).into_iter().filter_map(curve).collect()
}

#[test]
fn splines_keep_their_control_points() {
    let all =
        curves("F100 G0 X1 Y1\nG5 X3 Y3 I0 J3 P1 Q-3\nG5 X5 Y5 P0 Q-3\nG5.1 X7 Y5 I1 J2\nM2\n");
    let points = |curve: &NurbsFeed| {
        curve
            .points
            .iter()
            .map(|point| point.at)
            .collect::<Vec<_>>()
    };
    assert_eq!(
        points(&all[0]),
        [[1.0, 1.0], [1.0, 4.0], [4.0, 0.0], [3.0, 3.0]]
    );
    // The second goes on in the direction in which the first ended.
    assert_eq!(
        points(&all[1]),
        [[3.0, 3.0], [2.0, 6.0], [5.0, 2.0], [5.0, 5.0]]
    );
    assert_eq!(points(&all[2]), [[5.0, 5.0], [6.0, 7.0], [7.0, 5.0]]);
    assert_eq!(
        all.iter().map(|curve| curve.order).collect::<Vec<_>>(),
        [4, 4, 3]
    );
}

/// As recorded: the motion mode is the one before the spline.
#[test]
fn a_spline_leaves_the_motion_mode() {
    for (mode, spline) in [
        ("G0", "G5 X3 Y3 I0 J3 P1 Q-3"),
        ("G1", "G5 X3 Y3 I0 J3 P1 Q-3"),
        ("G0", "G5.1 X7 Y5 I1 J2"),
    ] {
        let ops = ops(&format!("F100 {mode} X1\n{spline}\nX9\nM2\n"));
        let moves: Vec<_> = ops
            .iter()
            .filter(|op| matches!(op.op, CanonicalOp::StraightTraverse(_)))
            .collect();
        assert_eq!(
            moves.len(),
            if mode == "G0" { 2 } else { 0 },
            "{mode} {spline}"
        );
    }
    // A move between two splines ends the series.
    let all = curves("F100 G1 X0\nG5 X3 Y3 I0 J3 P1 Q-3\nX5\nG5 X6 Y6 P1 Q1\nM2\n");
    assert_eq!(all[1].points[0].at, all[1].points[1].at);
}

#[test]
fn a_nurbs_has_weights_and_an_order() {
    let all = curves("F100 G5.2 P2 L4\nX1 Y1 P3\nX2 Y0 P1\nX3 Y0 P1\nG5.3\nM2\n");
    assert_eq!((all.len(), all[0].order, all[0].end[0]), (1, 4, 3.0));
    assert_eq!(
        all[0]
            .points
            .iter()
            .map(|point| point.weight)
            .collect::<Vec<_>>(),
        [2.0, 3.0, 1.0, 1.0]
    );
}

/// The moves of a program, folded.
fn moves(text: &str) -> Vec<Motion> {
    moves_with(text, InterpreterConfig::default())
}

#[test]
fn a_spline_is_moved_as_a_curve_with_its_tangents_and_curvatures() {
    let moves = moves("G20\nF10 G0 X1\nG5 X3 Y1 I1 J0 P0 Q-1\nM2\n");
    let (first, last) = (moves[1], moves[moves.len() - 1]);
    assert!((2..12).contains(&moves.len()), "{}", moves.len());
    assert_eq!(
        (first.start[AxisId::X], first.start[AxisId::Y]),
        (25.4, 0.0)
    );
    assert!((last.end[AxisId::X] - 76.2).abs() < 1e-9 && (last.end[AxisId::Y] - 25.4).abs() < 1e-9);
    // It sets out along X and straight, as its first three control points lie on a line.
    let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|axis| (a[axis] - b[axis]).abs() < 1e-12);
    let bend = first.bend.unwrap();
    assert!(
        near(bend.tangents[0], [1.0, 0.0, 0.0]) && near(bend.curvatures_per_mm[0], [0.0; 3]),
        "{bend:?}"
    );
    // It comes in along Y, bent to the left by 2/3 of an inch's inverse: (n - 1)/n of a triangle's
    // height over the square of its base.
    let bend = last.bend.unwrap();
    assert!(
        near(bend.tangents[1], [0.0, 1.0, 0.0])
            && near(bend.curvatures_per_mm[1], [-2.0 / 3.0 / 25.4, 0.0, 0.0]),
        "{bend:?}"
    );
    // Its length is that of many chords of Bernstein's form.
    let point = |t: f64| {
        let (s, x, y) = (1.0 - t, [1.0, 2.0, 3.0, 3.0], [0.0, 0.0, 0.0, 1.0]);
        let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
        [x, y].map(|axis| 25.4 * axis.iter().zip(weights).map(|(p, w)| p * w).sum::<f64>())
    };
    let chord = |k: u32| {
        let [a, b] = [k, k + 1].map(|k| point(f64::from(k) / 20_000.0));
        ((b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1])).sqrt()
    };
    let length: f64 = moves[1..]
        .iter()
        .map(|motion| motion.bend.unwrap().length_mm)
        .sum();
    assert!(
        (length - (0..20_000).map(chord).sum::<f64>()).abs() < 1e-5,
        "{length}"
    );
    assert!(
        moves[1..]
            .iter()
            .all(|motion| motion.feed == Feed::MmPerMin(254.0) && motion.circle.is_none())
    );
}

/// Turned by a quarter about X, the plane's Y is the machine's Z; turned about Z by a half,
/// everything is mirrored.
#[test]
fn a_spline_turns_with_its_coordinates() {
    const SPLINE: &str = "F100 G1 X1 Y2 Z3\nG5 X11 Y7 I4 J1 P2 Q-3\nM2\n";
    let flat = moves(SPLINE);
    let config = InterpreterConfig::default().with_dialect(Dialect::Fanuc);
    let tilted = moves_with(&format!("G68.2 X0 Y0 Z0 I0 J90 K0\n{SPLINE}"), config);
    let turned = moves(&format!("G10 L2 P1 R180\n{SPLINE}"));
    assert_eq!((flat.len(), flat.len()), (tilted.len(), turned.len()));
    let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|axis| (a[axis] - b[axis]).abs() < 1e-9);
    for ((flat, tilted), turned) in flat.iter().zip(&tilted).zip(&turned).skip(1) {
        let vectors = |motion: &Motion| {
            let bend = motion.bend.unwrap();
            let ([t0, t1], [k0, k1]) = (bend.tangents, bend.curvatures_per_mm);
            [motion.start.linear(), motion.end.linear(), t0, t1, k0, k1]
        };
        for ((flat, tilted), turned) in vectors(flat)
            .into_iter()
            .zip(vectors(tilted))
            .zip(vectors(turned))
        {
            let [x, y, z] = flat;
            assert!(near(tilted, [x, -z, y]), "{flat:?} {tilted:?}");
            assert!(near(turned, [-x, -y, z]), "{flat:?} {turned:?}");
        }
    }
}

/// A parabola two wide and half as high: sqrt(2) + arsinh(1) long.
#[test]
fn a_spline_in_inverse_time_takes_the_time_that_f_says() {
    let text = "G93 G1 X0 F1\nG5.1 X2 Y0 I1 J1 F2\nM2\n";
    let rates = ops(text).into_iter().filter_map(|op| {
        if let CanonicalOp::SetFeedRate { rate, .. } = op.op {
            Some(rate)
        } else {
            None
        }
    });
    let rate = rates.into_iter().find(|rate| *rate > 1.0).unwrap();
    assert!(
        (rate / 2.0 - (2.0_f64.sqrt() + math::asinh(1.0))).abs() < 1e-9,
        "{rate}"
    );
    let time: f64 = moves(text)
        .iter()
        .filter(|motion| motion.bend.is_some())
        .map(|motion| motion.duration_s.unwrap())
        .sum();
    assert!((time - 30.0).abs() < 1e-9, "{time}");
}
