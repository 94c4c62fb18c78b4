//! Five-axis words of other controls: where they lead, and where they are refused.
use crate::common::{codes, config, moves_with};
use lostmotion_base::math;
use lostmotion_base::units::rad;
use lostmotion_gcode::Dialect;

/// Ends of the moves in machine coordinates, mm.
fn ends(text: &str) -> Vec<[f64; 3]> {
    let moves = moves_with(text, config(Dialect::Fanuc));
    moves.iter().map(|motion| motion.end.linear()).collect()
}

fn near(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9)
}

#[test]
fn turned_coordinates_turn_lines_and_arcs_and_are_left_without_moving() {
    let turned =
        ends("G0 X5 Y5\nG68 X5 Y5 R90\nG1 X15 F200\nG3 X20 Y10 I0 J5\nG69\nG0 X0 Y0\nM30\n");
    assert!(
        near(turned[1], [5.0, 15.0, 0.0])
            && near(turned[2], [0.0, 20.0, 0.0])
            && near(turned[3], [0.0; 3]),
        "{turned:?}"
    );
}

#[test]
fn a_tilted_plane_tilts_everything_in_it() {
    let tilted = ends("G68.2 X10 Y0 Z20 I0 J90 K0\nG1 X1 Y2 Z3 F200\nG69\nG0 X0\nM30\n");
    assert!(
        near(tilted[0], [11.0, -3.0, 22.0]) && near(tilted[1], [0.0, -3.0, 22.0]),
        "{tilted:?}"
    );
    // A full circle in a plane that leans over stays in it, and at its radius.
    let text = "G68.2 X0 Y0 Z0 I20 J35 K10\nG0 X8 Y0 Z1\nG3 X8 Y0 I-8 J0 F200\nG69\nM30\n";
    let circle = ends(text);
    let ((tilt, upright), (sin, cos)) = (math::sin_cos(rad(35.0)), math::sin_cos(rad(20.0)));
    let normal = [tilt * sin, -tilt * cos, upright];
    assert!(circle.len() > 100);
    for place in &circle {
        let height: f64 = (0..3).map(|i| place[i] * normal[i]).sum();
        let square: f64 = place.iter().map(|v| v * v).sum();
        assert!((height - 1.0).abs() < 1e-9 && (square - 65.0).abs() < 1e-9);
    }
    assert!(near(circle[0], circle[circle.len() - 1]));
    for pair in circle[1..].windows(2) {
        let half: f64 = 0.5
            * (0..3)
                .map(|i| (pair[0][i] - pair[1][i]) * (pair[0][i] - pair[1][i]))
                .sum::<f64>()
                .sqrt();
        assert!(8.0 - (64.0 - half * half).sqrt() <= 0.001);
    }
}

#[test]
fn five_axis_words_are_refused_where_they_cannot_be() {
    for (text, code) in [
        ("G68 X0 Y0 R10\nG68 X0 Y0 R10\nM30\n", "five-axis-use"),
        ("G18 G68 X0 R10\nM30\n", "five-axis-use"),
        ("G43.4 H1\nG68.2 J30\nM30\n", "five-axis-use"),
        ("G53.1\nM30\n", "five-axis-use"),
        ("G41.1 D1\nG68 X0 Y0 R10\nM30\n", "compensation"),
        ("G41.1 D1\nG43.4 H1\nM30\n", "compensation"),
        ("G43.5 H1\nG1 X1 I0 J0 K0 F9\nM30\n", "five-axis-use"),
        ("G43.4 H1\nG1 X1 I1 F9\nM30\n", "unused-word"),
    ] {
        assert!(
            codes(text, config(Dialect::Fanuc)).contains(&code),
            "{text}: {:?}",
            codes(text, config(Dialect::Fanuc))
        );
        assert!(
            codes(text, config(Dialect::LinuxCnc)).contains(&"unsupported-code"),
            "{text}"
        );
    }
}
