//! Programs with several spindles.
use crate::common::ops;
use lostmotion_gcode::{InterpreterConfig, Program};

#[test]
fn a_dollar_sign_names_the_spindle() {
    let text = "S500 $1\nS300\nM3 $1\nG96 D2000 S80 $2\nG97 S90 $2\nG33 Z-1 K1 $1\nM2\n";
    let ops = spindle_ops(text);
    let expected = [
        "SET_SPINDLE_SPEED(1, 500.0000)",
        "SET_SPINDLE_SPEED(0, 300.0000)",
        "START_SPINDLE_CLOCKWISE(1)",
        "SET_SPINDLE_MODE(2 2000.0000)",
        "SET_SPINDLE_SPEED(2, 80.0000)",
        "SET_SPINDLE_MODE(2 0.0000)",
        "SET_SPINDLE_SPEED(2, 90.0000)",
    ];
    assert_eq!(ops[..expected.len()], expected);
    assert!(
        ops.contains(&"STOP_SPINDLE_TURNING(1)".to_owned()),
        "{ops:?}"
    );
    for wrong in [
        "S100 $9\nM2\n",
        "G0 X1 $1\nM2\n",
        "M3 $1\nG33 Z-1 K1 F100\nM2\n",
    ] {
        assert!(
            Program::new(wrong.as_bytes(), InterpreterConfig::default())
                .finish()
                .errors()
                > 0,
            "{wrong}"
        );
    }
}

/// Operations of spindles in a program, in the words of the canonical interface.
fn spindle_ops(source: &str) -> Vec<String> {
    let texts = ops(source)
        .into_iter()
        .map(|sourced| sourced.op.to_string());
    texts.filter(|op| op.contains("SPINDLE")).collect()
}

#[test]
fn all_spindles_are_those_that_the_program_has_used() {
    let one_by_one = "S100 $0\nS200 $2\nM3 $0\nM3 $2\nM19 R90 $0\nM19 R90 $2\nM5 $0\nM5 $2\nM2\n";
    let all = "S100\nS200 $2\nM3 $-1\nM19 R90 $-1\nM5 $-1\nM2\n";
    assert_eq!(spindle_ops(all), spindle_ops(one_by_one));
    let diagnostics =
        Program::new(&b"G33 Z-1 K1 $-1\nM2\n"[..], InterpreterConfig::default()).finish();
    assert_eq!(diagnostics.kept()[0].code(), "word-out-of-range");
}

/// As recorded: M19 takes back M3 and M4.
#[test]
fn an_oriented_spindle_does_not_turn() {
    for (code, told) in [
        ("G33 Z-1 K1", "spindle-stopped"),
        ("G84 X1 Z-1 R1", "cycle"),
    ] {
        for orient in ["M19 R90", "M19 Q1"] {
            let text = format!("F100 S100 M3\n{orient}\n{code}\nM2\n");
            let diagnostics = Program::new(text.as_bytes(), InterpreterConfig::default()).finish();
            assert_eq!(
                diagnostics
                    .kept()
                    .first()
                    .map(lostmotion_gcode::Diagnostic::code),
                Some(told),
                "{text}"
            );
            assert_eq!(
                Program::new(
                    text.replace(orient, "M3").as_bytes(),
                    InterpreterConfig::default()
                )
                .finish()
                .errors(),
                0
            );
        }
    }
}

#[test]
fn a_tap_turns_the_spindle_that_it_names() {
    for (code, on) in [("G84", "M3"), ("G74", "M4")] {
        let text = format!("F100\nS100 $1\n{on} $1\n{code} X1 Z-9 R1 $1\nX2\nM2\n");
        let (first, named) = (spindle_ops(&text.replace(" $1", "")), spindle_ops(&text));
        let shifted: Vec<String> = first.iter().map(|op| op.replace("(0", "(1")).collect();
        // The end of the program stops the first spindle besides.
        assert_eq!(named[..10], shifted[..10], "{code}");
        let wrong = Program::new(
            text.replace("R1 $1", "R1").as_bytes(),
            InterpreterConfig::default(),
        )
        .finish();
        assert_eq!(wrong.kept()[0].code(), "cycle", "{code}");
    }
}
