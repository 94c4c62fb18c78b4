//! One mistake gives one message; hints that name a change are right; what only looks like a number is
//! named; what LinuxCNC takes is taken, what it refuses is refused (its manual and its interpreter's
//! messages are quoted).

use crate::diagnostics::with_tool_one;
use lostmotion_gcode::{CanonicalOp, Diagnostic, InterpreterConfig, Problem, Program, Severity};

fn findings(text: &[u8]) -> Vec<Diagnostic> {
    let found = Program::new(text, InterpreterConfig::default()).finish();
    found
        .kept()
        .iter()
        .filter(|finding| finding.severity() > Severity::Note)
        .cloned()
        .collect()
}

/// Codes with lines of the findings.
fn told(text: &str) -> Vec<String> {
    findings(text.as_bytes())
        .iter()
        .map(|finding| format!("{} {}", finding.code(), finding.place.span.line))
        .collect()
}

fn errors(text: &str) -> usize {
    findings(text.as_bytes())
        .iter()
        .filter(|finding| finding.severity() == Severity::Error)
        .count()
}

#[test]
fn a_faulty_line_keeps_its_good_words() {
    for (text, expected) in [
        // The feed behind the fault.
        ("G21\nG1 X1O Y5 F100\nX20\nM2\n", "look-alike 2"),
        ("G21\nG1 X1? Y5 F100\nX20\nM2\n", "bad-character 2"),
        ("G21\nG1 X[1 plus 2] Y5 F100\nX20\nM2\n", "unknown-name 2"),
        ("G21\nG1 X[1/0] Y5 F100\nX20\nM2\n", "division-by-zero 2"),
        ("G21\nG1X1OY5F100\nX20\nM2\n", "look-alike 2"),
        ("G21\nG1 X1 H3 F100\nX20\nM2\n", "unused-word 2"),
        // A feed, a speed or a tool that is wrong counts as given.
        ("G21\nG1 X1 F1OO\nX20\nM2\n", "look-alike 2"),
        ("G21 F100\nS1O M3\nG33 Z-1 K1\nM2\n", "look-alike 2"),
        ("T1O\nM6\nM2\n", "look-alike 1"),
        // Modes behind the fault, and the end of the program.
        (
            "G21 F100\nG0 X10\nX? G91\nG2 X10 I5\nM2\n",
            "missing-number 3",
        ),
        (
            "G21 F100\nG0 X10\nX? G18\nG2 Z10 K5\nM2\n",
            "missing-number 3",
        ),
        ("G21\nG0 X1\nX? M30\n", "missing-number 3"),
        // A place that is not known decides nothing.
        (
            "G21 F100\nG1 X1O Y0\nG2 X20 Y0 I5 J0\nG1 X30\nM2\n",
            "look-alike 2",
        ),
        ("G21 F100\nG1 X1O\nG2 X20 R5\nM2\n", "look-alike 2"),
        // Cycles whose words are not known.
        (
            "G21 F100\nG81 X1 Y1 Z-5O R2\nX5\nX9\nG80\nM2\n",
            "look-alike 2",
        ),
        // Parameters that were not set.
        ("#<a>=[1+\nG0 X#<a>\nG0 Y#<a>\nM2\n", "missing-number 1"),
        ("#<a>=[1/0]\nG0 X#<a>\nM2\n", "division-by-zero 1"),
        (
            "#100=SQRT[-1] #101=5\nG0 X#100 Y#101\nM2\n",
            "outside-domain 1",
        ),
        // A mode that may have been set.
        ("G21 F100\nGO1 X5\nX10\nM2\n", "look-alike 2"),
        ("G21 F100\nG2 X10 I5\nGO1 X5\nX10\nM2\n", "look-alike 3"),
        // Codes behind one that fails.
        ("G21\nG41 D7 F100\nG1 X5\nM2\n", "no-such-tool 2"),
    ] {
        let found = Program::new(text.as_bytes(), with_tool_one()).finish();
        let told: Vec<String> = found
            .kept()
            .iter()
            .filter(|finding| finding.severity() > Severity::Note)
            .map(|finding| format!("{} {}", finding.code(), finding.place.span.line))
            .collect();
        assert_eq!(told, [expected], "{text}");
    }
}

#[test]
fn other_mistakes_are_still_told() {
    for (text, expected) in [
        // X is given anew, so that the arc is judged again.
        (
            "G21 F100\nG1 X1O Y0\nG1 X10 Y0\nG2 X20 Y0 I4 J0\nM2\n",
            &["look-alike 2", "arc-radii 4"][..],
        ),
        // Relative words do not depend on the place that is not known.
        (
            "G21 F100\nG1 X1O\nG91 G2 X10 I4\nM2\n",
            &["look-alike 2", "arc-radii 3"],
        ),
        ("G1 X1O\nX5\nM2\n", &["look-alike 1", "no-feed 2"]),
        (
            "#<a>=[1+\nG0 X#<b>\nM2\n",
            &["missing-number 1", "unknown-parameter 2"],
        ),
    ] {
        assert_eq!(told(text), expected, "{text}");
    }
}

/// The text of the only error, with its hint.
fn only(text: &str) -> (String, Option<String>) {
    let found = findings(text.as_bytes());
    assert_eq!(found.len(), 1, "{text}: {found:?}");
    (found[0].to_string(), found[0].hint())
}

#[test]
fn what_only_looks_like_a_number_is_named_with_what_to_write() {
    for (line, says, hint) in [
        ("G0 X1,5", "a decimal comma in X1,5", "write X1.5"),
        (
            "G0 X1,500 Y2",
            "a decimal comma in X1,500",
            "write X1.500, or X1500 if the comma groups thousands",
        ),
        ("G0 X1O", "the letter O in X1O", "write X10"),
        ("GO X1", "the letter O in GO", "write G0"),
        ("G0X-1OY2", "the letter O in X-1O", "write X-10"),
        ("G0 X[1,5+2]", "a decimal comma in 1,5", "write 1.5"),
        ("#1=2,5", "a decimal comma in 2,5", "write 2.5"),
        (
            "G0 X\u{2212}5",
            "a dash of typesetting in X\u{2212}5",
            "write X-5",
        ),
        (
            "G0 X\u{2013}5.5",
            "a dash of typesetting in X\u{2013}5.5",
            "write X-5.5",
        ),
        (
            "G0 X\u{ff11}\u{ff12}",
            "a full-width character in X\u{ff11}\u{ff12}",
            "write X12",
        ),
    ] {
        let (message, found) = only(&format!("{line}\nM2\n"));
        assert!(message.contains(says), "{line}: {message}");
        assert_eq!(found.as_deref(), Some(hint), "{line}");
        // What the hint says to write is read without an error.
        if let (Some(wrong), Some(right)) = (says.split(" in ").nth(1), hint.strip_prefix("write "))
        {
            let right = right.split(',').next().unwrap();
            assert_eq!(
                errors(&format!("{}\nM2\n", line.replace(wrong, right))),
                0,
                "{line}"
            );
        }
    }
    // What looks like nothing else keeps its own message.
    assert_eq!(told("G0 X1 ,R2\nM2\n"), ["bad-character 1"]);
    assert_eq!(told("G0 X1 O5 sub\nM2\n"), ["flow 1"]);
    assert_eq!(told("G0 X1 \u{20ac}\nM2\n"), ["bad-character 1"]);
    assert!(
        only("G0 X1 \u{20ac}\nM2\n")
            .0
            .contains("'\u{20ac}' (U+20AC)")
    );
}

#[test]
fn utf_16_is_named_once() {
    let text = "G21 G90\nG0 X10\nG1 Y5 F100\nM2\n";
    let units: Vec<u16> = text.encode_utf16().collect();
    let little: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
    let big: Vec<u8> = units.iter().flat_map(|unit| unit.to_be_bytes()).collect();
    for (mark, bytes) in [
        (&b"\xff\xfe"[..], &little),
        (b"\xfe\xff", &big),
        (b"", &little),
        (b"", &big),
    ] {
        let found = findings(&[mark, bytes].concat());
        let codes: Vec<_> = found.iter().map(Diagnostic::code).collect();
        assert_eq!(codes, ["utf-16"], "{found:?}");
        assert!(found[0].hint().unwrap().contains("UTF-8"));
    }
}

#[test]
fn arcs_say_where_they_lead() {
    let found = findings(b"G21 F100 G0 X1 Y2\nG2 X11.06 Y2 I5\nM2\n");
    let text = found[0].to_string();
    assert!(
        text.contains(
            "radius to start 5.0000 mm, to end 5.0600 mm, which differ by 0.0600: from X1 Y2 to \
             X11.06 Y2 about X6 Y2"
        ),
        "{text}"
    );
    let found = findings(b"G21 F100 G0 X1 Y2\nG2 X11 Y2 R4\nM2\n");
    let text = found[0].to_string();
    assert!(text.contains("from X1 Y2 to X11 Y2"), "{text}");
    let found = findings(b"G21 F100 G18 G0 X1 Z2\nG2 X11 Z2 I4\nM2\n");
    let text = found[0].to_string();
    assert!(text.contains("from Z2 X1 to Z2 X11 about Z2 X5"), "{text}");
}

/// A block with an arc that is wrong, what the hint has to be, and the block with that change.
const ARCS: [(&str, &str, &str); 8] = [
    (
        "G0 X10\nG2 X20 I15 J0",
        "G90.1, absolute",
        "G0 X10\nG90.1 G2 X20 I15 J0",
    ),
    (
        "G0 X10\nG90.1 G2 X20 I5 J0",
        "G91.1, centres relative",
        "G0 X10\nG91.1 G2 X20 I5 J0",
    ),
    ("G2 X10 I-5", "did you mean I5?", "G2 X10 I5"),
    (
        "G0 X3 Y4\nG3 X-5 Y0 I-3 J4",
        "did you mean J-4?",
        "G0 X3 Y4\nG3 X-5 Y0 I-3 J-4",
    ),
    (
        "G0 X10\nG2 X24 I12",
        "G91, incremental",
        "G0 X10\nG91 G2 X24 I12",
    ),
    (
        "G0 X10\nG91 G2 X20 I5",
        "G90, absolute",
        "G0 X10\nG90 G2 X20 I5",
    ),
    (
        "G0 X50\nG2 X10 R5",
        "G91, incremental",
        "G0 X50\nG91 G2 X10 R5",
    ),
    ("G2 X10.06 I5", "is I5.03 J0", "G2 X10.06 I5.03 J0"),
];

#[test]
fn a_hint_that_names_a_change_is_right() {
    for (wrong, hint, right) in ARCS {
        let (text, found) = only(&format!("G21 F100\n{wrong}\nM2\n"));
        assert!(
            found.is_some_and(|found| found.contains(hint)),
            "{wrong}: {text}"
        );
        assert_eq!(errors(&format!("G21 F100\n{right}\nM2\n")), 0, "{right}");
    }
    // An E that goes on with a number would be an exponent with its sign.
    let exponent = |line: &str| only(&format!("F100\n{line}\nM2\n")).1.unwrap_or_default();
    assert!(exponent("G1 X1E3").contains("an exponent needs its sign (1E+3)"));
    assert_eq!(errors("F100\nG1 X1E+3\nM2\n"), 0);
    assert!(!exponent("G1 X1 E3").contains("exponent"));
    // Where no change makes the arc right, none is named: in G90.1, J would be missing.
    for block in [
        "G2 X20 I4",
        "G2 X20 Y7 I-40 J31",
        "G90.1 G0 X3 Y4\nG2 X20 Y1 I90 J40",
    ] {
        let (text, hint) = only(&format!("G21 F100\n{block}\nM2\n"));
        assert_eq!(hint, None, "{text}");
    }
}

/// "J word given for arc in XZ plane" (LinuxCNC, interp_convert.cc): with a zero, too. CAM systems
/// write three words of which the one along the normal is zero; one of the plane and that one are the
/// pair of another plane.
#[test]
fn a_forgotten_plane_is_told() {
    let (text, hint) = only("G21 F100\nG18\nG2 X10 I5 J0\nM2\n");
    assert!(text.contains("arc-off-plane") && text.contains("J in an arc of the XZ plane"));
    assert_eq!(hint.as_deref(), Some("did you mean G17, the XY plane?"));
    assert_eq!(errors("G21 F100\nG17\nG2 X10 I5 J0\nM2\n"), 0);
    assert_eq!(only("G21 F100\nG19\nG2 X10 K5 I0 Z0\nM2\n").1, None);
    let (_, hint) = only("G21 F100\nG19\nG2 X10 K0 I5\nM2\n");
    assert_eq!(hint.as_deref(), Some("did you mean G18, the XZ plane?"));
    // All three words, or the plane that programs begin in: the normal's zero says nothing.
    assert_eq!(
        told("G21 F100\nG18\nG2 Z10 I0 K5 J0\nM2\n"),
        ["off-plane-zero 3"]
    );
    assert_eq!(told("G21 F100\nG2 X10 I5 K0\nM2\n"), ["off-plane-zero 2"]);
    assert_eq!(
        told("G21 F100\nG2 X10 I5 J0 K0\nM2\n"),
        ["off-plane-zero 2"]
    );
    // No plane makes this an arc.
    assert_eq!(only("G21 F100\nG18\nG2 X10 I4 J1\nM2\n").1, None);
}

/// LinuxCNC's manual, "Messages": `(ABORT, ...)` aborts with the message, in which parameters are
/// filled in; its convert_comment returns an error.
#[test]
fn abort_stops_the_program_with_its_message() {
    let text = "#1=3\no1 if [#1 GT 2]\n(abort, too deep: #1 mm)\no1 endif\nG0 X5\nM2\n";
    let mut program = Program::new(text.as_bytes(), InterpreterConfig::default());
    let moves = program
        .by_ref()
        .filter(|sourced| matches!(sourced.op, CanonicalOp::StraightTraverse(_)))
        .count();
    let found = program.diagnostics().kept();
    assert_eq!((moves, found.len()), (0, 1), "{found:?}");
    assert_eq!(
        found[0].problem,
        Problem::Abort {
            message: "too deep: 3.000000 mm".to_owned()
        }
    );
    assert_eq!(found[0].place.span.line, 3);
    assert!(told("o1 if [0]\n(ABORT,no)\no1 endif\nG0 X5\nM2\n").is_empty());
    assert_eq!(
        told("o<a> sub\no<a> endsub (abort, end)\no<a> call\nM2\n"),
        ["abort 2"]
    );
}

/// LinuxCNC's convert_control_functions goes on through a label alone ("continue executing into
/// Fanuc-style programs w/o skipping").
#[test]
fn a_program_number_after_a_block_is_taken() {
    assert_eq!(told("G21 G90\nO0001\nG0 X5\nM2\n"), ["runs-into-sub 2"]);
    assert!(told("O0001\nG21 G90\nG0 X5\nM2\n").is_empty());
    assert_eq!(
        told("G0 X1\nM98 P5\nM2\nO5\nG0 X2\nO6\nG0 X3\nM99\n"),
        Vec::<String>::new()
    );
}

/// LinuxCNC's read_o reads comments between the arguments of a call, and those of no other keyword.
#[test]
fn comments_stand_between_the_arguments_of_a_call() {
    let text = "o<a> sub\nG0 X#1 Y#2\no<a> endsub\no<a> call (x) [1] (y) [2] (done)\nM2\n";
    let mut program = Program::new(text.as_bytes(), InterpreterConfig::default());
    let ends: Vec<[f64; 2]> = program
        .by_ref()
        .filter_map(|sourced| match sourced.op {
            CanonicalOp::StraightTraverse(end) => Some([end[0], end[1]]),
            _ => None,
        })
        .collect();
    assert_eq!(ends, [[1.0, 2.0]]);
    assert_eq!(program.diagnostics().errors(), 0);
    assert_eq!(errors("o1 if (x) [1]\no1 endif\nM2\n"), 1);
    assert_eq!(errors("o<a> call [1] (x [2]\nM2\n"), 1);
}

/// "R not allowed in G10 L20" (LinuxCNC, convert_setup).
#[test]
fn a_rotation_with_g10_l20_is_refused() {
    assert_eq!(told("G10 L20 P1 X5 R30\nM2\n"), ["unused-word 1"]);
    assert!(told("G10 L2 P1 X5 R30\nM2\n").is_empty());
    assert!(told("G10 L20 P1 X5\nM2\n").is_empty());
}

/// "'O.... sub' subroutine must be called with 'O.... call'" and "Fanuc 'O....' subroutine must be
/// called with 'M98'" (LinuxCNC, convert_control_functions).
#[test]
fn subroutines_are_called_in_their_own_style() {
    assert_eq!(told("o5 sub\nG0 X1\no5 endsub\nM98 P5\nM2\n"), ["flow 4"]);
    assert_eq!(told("o5 call\nM2\no5\nG0 X1\nM99\n"), ["flow 1"]);
    assert!(told("o5 sub\nG0 X1\no5 endsub\no5 call\nM98 P6\nM2\no6\nG0 X1\nM99\n").is_empty());
}

#[test]
fn near_names_are_proposed_and_far_ones_are_not() {
    let hint = |text: &str| only(text).1;
    let subs = "o<pocket> sub\nG0 X1\no<pocket> endsub\n";
    assert_eq!(
        hint(&format!("{subs}o<pokcet> call\nM2\n")).as_deref(),
        Some("did you mean o<pocket>?")
    );
    assert!(
        hint(&format!("{subs}o<drill> call\nM2\n"))
            .is_some_and(|hint| hint.contains("--subroutines"))
    );
    assert_eq!(
        hint("#<feed>=200\nG1 X1 F#<feeed>\nM2\n").as_deref(),
        Some("did you mean #<feed>?")
    );
    assert_eq!(hint("#<feed>=200\nG0 X#<depth>\nM2\n"), None);
    // Names of another subroutine cannot be read here, and are not proposed.
    assert_eq!(
        hint("o<a> sub\n#<feed>=1\no<a> endsub\no<a> call\nG0 X#<feeed>\nM2\n"),
        None
    );
}
