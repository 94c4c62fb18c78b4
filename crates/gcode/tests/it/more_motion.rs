//! Probing, threads, saved modes, polar coordinates, and subroutines from files.
use crate::common::ops;
use lostmotion_gcode::{
    CanonicalOp, Feed, InterpreterConfig, MotionFold, MotionItem, Problem, Program, SourcedOp,
};
use std::collections::BTreeMap;
use std::sync::Arc;

fn first_error(text: &str) -> String {
    let diagnostics = Program::new(text.as_bytes(), InterpreterConfig::default()).finish();
    let found = diagnostics
        .kept()
        .first()
        .unwrap_or_else(|| panic!("{text}"));
    format!(
        "{} {}:{}",
        found.code(),
        found.place.span.line,
        found.place.span.column
    )
}

fn traverses(text: &str) -> Vec<[f64; 3]> {
    let place = |op: SourcedOp| {
        if let CanonicalOp::StraightTraverse(end) = op.op {
            Some([end[0], end[1], end[2]])
        } else {
            None
        }
    };
    ops(text).into_iter().filter_map(place).collect()
}

#[test]
fn what_is_wrong_with_a_curve_is_told() {
    for (text, expected) in [
        ("F100 G5.3", "curve 1:6"),
        ("F100 G5.2 X1 Y1\nG5.3", "curve 2:1"),
        ("F100 G5.2 X1\nG5.3", "word-missing 1:6"),
        ("F100 G5.2 X1 Y1 P-1", "word-out-of-range 1:6"),
        ("F100 G5.2 X1 Y1\nG1 X4", "curve 2:1"),
        ("F100 G5.2 X1 Y1", "curve 2:1"),
        ("G5.1 X1 Y1 I1 J1", "no-feed 1:1"),
        ("G93 G5.1 X1 Y1 I1 J1", "no-inverse-time-feed 1:5"),
        ("G93 G5.2 X1 Y1", "curve 1:5"),
        ("G18\nG0 @3", "polar 2:1"),
        ("F100\nG81 X1 A1 Z-1 R1", "cycle 2:1"),
        ("M3\nG95 G1 X1 F1", "no-revolutions 2:5"),
        ("S9 M3\nG95 F1\nG38.2 Z-1", "probe-feed 3:1"),
        ("F100 G18 G5.1 X1 I1 J1", "curve 1:10"),
        ("F100 G5 X1 Y1 I1 P1 Q1", "word-missing 1:6"),
        ("F100 G5 X1 Y1 P1 Q1\nX2 P1 Q1", "axis-without-code 2:1"),
        ("F100 G38.2 Z0", "probe-too-short 1:6"),
        ("G33 Z1 K1", "spindle-stopped 1:1"),
        ("S9 M3 G33 Z1", "word-missing 1:7"),
        ("G18 G76 Z-1 P1 I1 J1 K2", "spindle-stopped 1:5"),
        ("G18 S9 M3\nG76 Z-1 P1 I1 J2 K1", "cycle 2:1"),
        (
            "G18 S9 M3\nG76 Z-1 P1 I1 J0.0000001 K1 R9",
            "cycle-too-long 2:1",
        ),
        ("G0 @1 X1", "polar 1:1"),
        ("G91 G0 @1", "polar 1:5"),
        ("G92 @1", "polar 1:1"),
        ("M72", "nothing-saved 1:1"),
        ("M70\nM71\nM71\nM72", "nothing-saved 4:1"),
        ("M66 P1 E1", "word-missing 1:1"),
        ("M66 P1 L3", "word-missing 1:1"),
        ("M62 P999", "word-out-of-range 1:1"),
        ("M19 R400", "word-out-of-range 1:1"),
        ("G96", "word-missing 1:1"),
    ] {
        assert_eq!(first_error(&format!("{text}\nM2\n")), expected, "{text}");
    }
}

#[test]
fn what_is_not_motion_yet_is_an_error_that_says_so() {
    for text in [
        "G96 S100 M3\nG95 F0.1 G1 X9\nM2\n",
        "G96 S100 M3\nG33 Z-9 K1\nM2\n",
    ] {
        let mut fold = MotionFold::new(InterpreterConfig::default().start);
        let refused = ops(text)
            .iter()
            .filter_map(|op| fold.push(op).err())
            .collect::<Vec<_>>();
        assert!(
            matches!(refused[..], [Problem::NoMotionFor { .. }]),
            "{refused:?}"
        );
    }
}

#[test]
fn a_thread_is_fed_with_the_spindle() {
    let mut fold = MotionFold::new(InterpreterConfig::default().start);
    let items: Vec<_> = ops("G20 S300 M3\nG33 Z-1 K0.05\nM2\n")
        .iter()
        .filter_map(|op| fold.push(op).unwrap())
        .collect();
    let MotionItem::Move(motion) = items[0] else {
        panic!("{items:?}")
    };
    let Feed::MmPerMin(feed) = motion.feed else {
        panic!("{motion:?}")
    };
    assert!((feed - 0.05 * 25.4 * 300.0).abs() < 1e-9);
}

#[test]
fn the_last_pass_of_a_thread_is_at_full_depth() {
    let text = "G18 S300 M3\nG0 X12 Z3\nG76 Z-20 P1.5 I-2 J0.2 K0.9 R2\nM2\n";
    let feeds = ops(text).into_iter().filter_map(|op| {
        if let CanonicalOp::StraightFeed(end) = op.op {
            Some(end[0])
        } else {
            None
        }
    });
    let depths: Vec<f64> = feeds.map(|x| 10.0 - x).collect();
    // Equal area: the depth grows with the root of the number of passes.
    assert_eq!(depths.len(), 21);
    for (index, depth) in depths.iter().enumerate().take(20) {
        assert!((depth - 0.2 * (index as f64 + 1.0).sqrt()).abs() < 1e-12);
    }
    assert!((depths[20] - 0.9).abs() < 1e-12);
}

/// As recorded: once a series of holes has begun, a higher R is reached on the way to its hole.
#[test]
fn a_higher_clearance_in_a_series_is_reached_on_the_way() {
    let ends = traverses("F9 G0 Z3\nG99 G81 X1 Y1 Z-1 R1\nX2 R2\nG80\nM2\n");
    assert_eq!(
        ends[1..],
        [
            [1.0, 1.0, 3.0],
            [1.0, 1.0, 1.0],
            [1.0, 1.0, 1.0],
            [2.0, 1.0, 2.0],
            [2.0, 1.0, 2.0]
        ]
    );
    // From below the first one, straight up.
    assert_eq!(
        traverses("F9\nG99 G81 X1 Y1 Z-1 R1\nM2\n")[..2],
        [[0.0, 0.0, 1.0], [1.0, 1.0, 1.0]]
    );
}

#[test]
fn polar_coordinates_turn_about_the_origin() {
    let places = traverses("G0 @10 ^90\nG0 ^0\nG91 G0 ^60 Z1\nG0 @10\nM2\n");
    let root = 3.0_f64.sqrt() / 2.0;
    for (place, expected) in places.iter().zip([
        [0.0, 10.0, 0.0],
        [10.0, 0.0, 0.0],
        [5.0, 10.0 * root, 1.0],
        [10.0, 20.0 * root, 1.0],
    ]) {
        assert!(
            (0..3).all(|i| (place[i] - expected[i]).abs() < 1e-12),
            "{place:?} {expected:?}"
        );
    }
    assert_eq!(places.len(), 4);
}

#[test]
fn a_diameter_is_halved() {
    assert_eq!(
        traverses("G7 G0 X10\nG91 X4\nG8 X1\nM2\n"),
        [[5.0, 0.0, 0.0], [7.0, 0.0, 0.0], [8.0, 0.0, 0.0]]
    );
}

#[test]
fn subroutines_come_from_files_and_know_their_callers() {
    let files = BTreeMap::from([
        (
            "outer".to_owned(),
            b"o<outer> sub\no<inner> call [#1]\no<outer> endsub\nM2\n".to_vec(),
        ),
        (
            "inner".to_owned(),
            b"(a file)\no<inner> sub\nG0 X#1\no<inner> endsub\n".to_vec(),
        ),
        ("77".to_owned(), b"G0 Y1\nM99\n".to_vec()),
    ]);
    let text = "o<outer> call [5]\no<outer> call [6]\nM98 P77\nM2\n";
    let mut program =
        Program::new(text.as_bytes(), InterpreterConfig::default()).with_loader(Arc::new(files));
    let moves: Vec<SourcedOp> = program
        .by_ref()
        .filter(|op| matches!(op.op, CanonicalOp::StraightTraverse(_)))
        .collect();
    assert_eq!(
        program.diagnostics().errors(),
        0,
        "{:?}",
        program.diagnostics().kept()
    );
    assert_eq!(moves.len(), 3);
    let interpreter = program.interpreter();
    let trace = |index: usize| {
        let sites = interpreter
            .call_stacks()
            .trace(moves[index].block.call_stack);
        sites
            .map(|site| format!("{} {}:{}", site.name, site.call.file, site.call.line))
            .collect::<Vec<_>>()
    };
    assert_eq!(trace(0), ["inner 1:2", "outer 0:1"]);
    assert_eq!(trace(1), ["inner 1:2", "outer 0:2"]);
    assert_eq!(trace(2), ["77 0:3"]);
    assert_eq!((moves[0].block.span.file, moves[0].block.span.line), (2, 3));
    assert_eq!(interpreter.file_name(2), Some("inner.ngc"));
    assert_eq!(interpreter.file_name(0), None);
}

#[test]
fn a_line_that_calls_further_on_runs_once() {
    assert_eq!(
        traverses("#1=1\n#1=[#1+1] M98 P5\nG0 X#1\nM2\no5\nG0 Y#1\nM99\n"),
        [[0.0, 2.0, 0.0], [2.0, 2.0, 0.0]]
    );
}

#[test]
fn a_missing_file_is_told_once() {
    let mut program = Program::new(&b"o<nowhere> call\nM2\n"[..], InterpreterConfig::default())
        .with_loader(Arc::new(BTreeMap::new()));
    for _ in program.by_ref() {}
    let found: Vec<_> = program
        .diagnostics()
        .kept()
        .iter()
        .map(lostmotion_gcode::Diagnostic::code)
        .collect();
    assert_eq!(found, ["no-such-sub"]);
}

#[test]
fn a_main_program_that_starts_over_ends() {
    let mut program = Program::new(&b"G0 X1\nM99\n"[..], InterpreterConfig::default());
    let last = program.by_ref().last().unwrap();
    assert_eq!(last.op, CanonicalOp::ProgramEnd);
    assert_eq!(
        (
            program.diagnostics().errors(),
            program.diagnostics().warnings()
        ),
        (0, 1)
    );
}
