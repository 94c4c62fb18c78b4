//! Machine coordinates of motion against closed forms.
use crate::common::moves_with;
use lostmotion_base::units::rad;
use lostmotion_base::{AxisId, Coords, math};
use lostmotion_gcode::{
    Dialect, Feed, InterpreterConfig, Motion, MotionFold, MotionItem, PathMode, Plane, Program,
    Tool, ToolTable, Units,
};
use std::f64::consts::PI;

fn moves(text: &str) -> Vec<Motion> {
    moves_with(text, InterpreterConfig::default())
}

#[track_caller]
fn close(actual: Coords, expected: Coords) {
    for (a, e) in actual.0.iter().zip(expected.0) {
        assert!(
            (a - e).abs() < 1e-12 * e.abs().max(1.0),
            "{actual:?} is not {expected:?}"
        );
    }
}

#[test]
fn work_offsets_come_from_the_machine_in_mm() {
    let config = InterpreterConfig::default().with_work_offset(2, Coords::xyz(100.0, 20.0, -30.0));
    for text in ["G21 G55 G0 X25.4 Y0 Z50.8\nM2", "G20 G55 G0 X1 Y0 Z2\nM2"] {
        close(
            moves_with(text, config.clone())[0].end,
            Coords::xyz(125.4, 20.0, 20.8),
        );
    }
}

#[test]
fn inch_machines_take_the_same_offset_in_mm() {
    let config = InterpreterConfig {
        machine_units: Units::Inch,
        ..InterpreterConfig::default()
    };
    let config = config.with_work_offset(1, Coords::xyz(50.8, 0.0, 0.0));
    close(
        moves_with("G21 G0 X1\nM2", config)[0].end,
        Coords::xyz(51.8, 0.0, 0.0),
    );
}

#[test]
fn a_g92_offset_moves_the_coordinates_and_not_the_machine() {
    let all = moves("G0 X10 Y5\nG92 X0 Y0\nG0 X1 Y1\nG92.1\nG0 X1 Y1\nM2");
    close(all[1].start, Coords::xyz(10.0, 5.0, 0.0));
    close(all[1].end, Coords::xyz(11.0, 6.0, 0.0));
    close(all[2].end, Coords::xyz(1.0, 1.0, 0.0));
}

#[test]
fn rotated_coordinates_turn_ends_and_centres() {
    let config = InterpreterConfig {
        parameters: vec![(5221, 10.0), (5230, 90.0)],
        ..InterpreterConfig::default()
    };
    let all = moves_with("F100 G0 X1 Y0\nG2 X3 Y0 I1 J0\nM2", config);
    close(all[0].end, Coords::xyz(10.0, 1.0, 0.0));
    close(all[1].end, Coords::xyz(10.0, 3.0, 0.0));
    let circle = all[1].circle.unwrap();
    assert_eq!((circle.plane, circle.turns), (Plane::Xy, -1));
    assert!(
        (circle.center_mm[0] - 10.0).abs() < 1e-12 && (circle.center_mm[1] - 2.0).abs() < 1e-12
    );
}

/// Full circles about an axis that is none of the machine's: lines that stay on them.
#[test]
fn arcs_of_a_rotated_plane_lie_in_it() {
    let (sin, cos) = math::sin_cos(rad(60.0));
    for (plane, center, along) in [
        ("G18", "I-4 K3", [cos, sin]),
        ("G19", "J-4 K3", [-sin, cos]),
    ] {
        let start = if plane == "G18" {
            "X7 Y0 Z1"
        } else {
            "X0 Y7 Z1"
        };
        let text = format!("F100 G10 L2 P1 X2 Y1 R60\n{plane} G0 {start}\nG2 {center}\nM2");
        let all = moves(&text);
        assert!(
            all.len() > 50 && all.iter().all(|motion| motion.circle.is_none()),
            "{}",
            all.len()
        );
        let mut length = 0.0;
        for motion in &all[1..] {
            let [x, y, z] = motion.end.linear();
            let (out, aside) = (
                (x - 2.0) * along[0] + (y - 1.0) * along[1],
                (y - 1.0) * along[0] - (x - 2.0) * along[1],
            );
            assert!(
                (math::hypot(out - 3.0, z - 4.0) - 5.0).abs() < 1e-9 && aside.abs() < 1e-9,
                "{plane} {motion:?}"
            );
            length += (0..3)
                .map(|i| {
                    (motion.end.0[i] - motion.start.0[i]) * (motion.end.0[i] - motion.start.0[i])
                })
                .sum::<f64>()
                .sqrt();
        }
        close(all[all.len() - 1].end, all[0].end);
        assert!(
            (length / (10.0 * std::f64::consts::PI) - 1.0).abs() < 1e-3,
            "{length}"
        );
    }
}

#[test]
fn a_tool_offset_lifts_the_spindle_and_leaves_the_program_alone() {
    let mut table = ToolTable::default();
    table.insert(Tool {
        number: 3,
        offset: [0.0, 0.0, 80.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        ..Tool::default()
    });
    let config = InterpreterConfig {
        tool_table: Some(table),
        ..InterpreterConfig::default()
    };
    let all = moves_with("T3 M6\nG0 Z100\nG43\nG1 F100 Z5\nM2", config);
    // The spindle stays at 100 when the offset comes, so the tip is then at 20.
    close(all[1].start, Coords::xyz(0.0, 0.0, 20.0));
    close(all[1].end, Coords::xyz(0.0, 0.0, 5.0));
    assert_eq!(all[1].tool_offset.0[2], 80.0);
}

/// As recorded: H0 and D0 are the tool in the spindle. For Fanuc they are no tool.
#[test]
fn zero_names_the_tool_in_the_spindle() {
    let mut table = ToolTable::default();
    table.insert(Tool {
        number: 3,
        offset: [0.0, 0.0, 80.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        diameter: 4.0,
        ..Tool::default()
    });
    let config = InterpreterConfig {
        tool_table: Some(table),
        ..InterpreterConfig::default()
    };
    let ends = |text: &str, config: InterpreterConfig| {
        moves_with(text, config)
            .last()
            .map(|motion| motion.end)
            .unwrap()
    };
    for (text, z) in [
        ("T3 M6\nG0 Z100\nG43 H0\nG0 X1\nM2", 20.0),
        ("G0 Z100\nG43 H0\nG0 X1\nM2", 100.0),
    ] {
        close(ends(text, config.clone()), Coords::xyz(1.0, 0.0, z));
    }
    let round = "T3 M6\nF100 G41 D0\nG1 X10 Y-10\nX20\nM2";
    close(ends(round, config.clone()), Coords::xyz(20.0, -8.0, 0.0));
    let fanuc = config.with_dialect(Dialect::Fanuc);
    close(
        ends("T3 M6\nG0 Z100\nG43 H0\nG0 X1\nM30", fanuc.clone()),
        Coords::xyz(1.0, 0.0, 100.0),
    );
    close(
        ends(&round.replace("M2", "M30"), fanuc),
        Coords::xyz(20.0, -10.0, 0.0),
    );
}

#[test]
fn each_move_begins_where_the_last_one_ended() {
    let all = moves(
        "G21 F100 G0 X0.1 Y0.3\nG1 X7.7 A45\nG2 X9.7 I1 J0 Z-0.3\nG20 G91 G1 X0.1 Y0.1 C-10\nM2",
    );
    for pair in all.windows(2) {
        assert_eq!(pair[0].end, pair[1].start);
    }
}

#[test]
fn feeds_are_in_mm_and_rad_per_minute() {
    let all = moves("G20\nF10 G1 X1\nG1 A90\nG93 G1 X2 F4\nG1 A0 F2\nG95 F0.1 S600 M3\nG1 X3\nM2");
    assert_eq!(all[0].feed, Feed::MmPerMin(254.0));
    match all[1].feed {
        Feed::RadPerMin(rate) => assert!((rate - PI / 18.0).abs() < 1e-15),
        other => panic!("{other:?}"),
    }
    // 1 in in a quarter of a minute; 90 degrees in half a minute.
    assert_eq!(
        (all[2].feed, all[2].duration_s),
        (Feed::MmPerMin(4.0 * 25.4), Some(15.0))
    );
    match all[3].feed {
        Feed::RadPerMin(rate) => assert!((rate - PI).abs() < 1e-12, "{rate}"),
        other => panic!("{other:?}"),
    }
    assert_eq!(all[4].duration_s, None);
    match all[4].feed {
        Feed::MmPerMin(rate) => assert!((rate - 0.1 * 25.4 * 600.0).abs() < 1e-9),
        other => panic!("{other:?}"),
    }
}

#[test]
fn path_control_is_in_mm() {
    let all = moves("G20 G64 P0.01 Q0.002\nG0 X1\nG64\nG0 X2\nG61.1 G0 X3\nM2");
    assert_eq!(
        all[0].path,
        PathMode::Continuous {
            tolerance_mm: Some(0.01 * 25.4),
            merge_mm: 0.002 * 25.4
        }
    );
    assert_eq!(
        all[1].path,
        PathMode::Continuous {
            tolerance_mm: None,
            merge_mm: 0.0
        }
    );
    assert_eq!(all[2].path, PathMode::ExactStop);
}

#[test]
fn arcs_of_the_zx_plane_keep_its_order() {
    let all = moves("F100 G18 G0 X0 Z0\nG3 X10 Z0 I5 K0 Y2\nM2");
    let circle = all[1].circle.unwrap();
    assert_eq!(
        (circle.plane, circle.center_mm, circle.turns),
        (Plane::Zx, [0.0, 5.0], 1)
    );
    close(all[1].end, Coords::xyz(10.0, 2.0, 0.0));
}

#[test]
fn stops_and_dwells_stay_in_order() {
    let text = "T1 M6\nG4 P0.5\nM1\nM0\nM2\n";
    let mut fold = MotionFold::new(Coords::ZERO);
    let items: Vec<_> = Program::new(text.as_bytes(), InterpreterConfig::default())
        .filter_map(|op| fold.push(&op).unwrap())
        .collect();
    assert!(matches!(
        items[..],
        [
            MotionItem::ToolChange { tool: 1, .. },
            MotionItem::Dwell { .. },
            MotionItem::Stop { optional: true, .. },
            MotionItem::Stop {
                optional: false,
                ..
            },
            MotionItem::End { .. }
        ]
    ));
}

#[test]
fn rigid_tapping_goes_down_and_comes_back_at_the_speed_of_the_spindle() {
    let moves = moves("S600 M3\nG0 X5 Z2\nG33.1 Z-10 K0.5\nM2\n");
    assert_eq!(moves.len(), 3);
    assert_eq!(moves[1].end[AxisId::Z], -10.0);
    assert_eq!(moves[2].end, moves[1].start);
    for motion in &moves[1..] {
        assert_eq!(
            (motion.feed, motion.path),
            (Feed::MmPerMin(300.0), PathMode::ExactStop)
        );
    }
}
