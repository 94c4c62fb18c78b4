//! What is wrong is named by code, line and column, all of it in one run.
use lostmotion_gcode::{InterpreterConfig, Leniency, Program, Severity, Tool, ToolTable};

/// The usual settings, with a table that has tool 1 alone.
pub(crate) fn with_tool_one() -> InterpreterConfig {
    let mut tools = ToolTable::default();
    tools.insert(Tool {
        number: 1,
        ..Tool::default()
    });
    InterpreterConfig {
        tool_table: Some(tools),
        ..InterpreterConfig::default()
    }
}

/// Codes with line and column of everything but notes found in a program, after a head line that
/// sets units and feed.
fn found(body: &str) -> Vec<String> {
    let config = with_tool_one();
    let source = format!("G21 F100\n{body}\nM2\n");
    let diagnostics = Program::new(source.as_bytes(), config).finish();
    let told = diagnostics
        .kept()
        .iter()
        .filter(|d| d.severity() > Severity::Note);
    told.map(|d| format!("{} {}:{}", d.code(), d.place.span.line, d.place.span.column))
        .collect()
}

#[test]
fn each_mistake_has_its_code_and_place() {
    for (body, expected) in [
        ("G1 X10 Y", "missing-number 2:9"),
        ("G1 X1.2.3", "bad-number 2:5"),
        ("G1 X1 ? Y2", "bad-character 2:7"),
        ("G1 X1\0", "nul-byte 2:6"),
        ("G1 X1 (oops", "unclosed-comment 2:7"),
        ("G1 X1 (a (b)", "nested-comment 2:10"),
        ("G1 X[1+2", "syntax 2:9"),
        ("G1 X[1 plus 2]", "unknown-name 2:8"),
        ("G1 X[1/0]", "division-by-zero 2:4"),
        ("G1 X[SQRT[-1]]", "outside-domain 2:4"),
        ("G1 X[10**400]", "not-finite 2:4"),
        ("G1 X#<foo>", "unknown-parameter 2:4"),
        ("G0 X1 #99999=3", "parameter-range 2:7"),
        ("#5420=1", "read-only-parameter 2:1"),
        ("#<_x>=1", "read-only-parameter 2:1"),
        ("G0 X1 N5", "misplaced-line-number 2:7"),
        ("G0 X1 X2", "repeated-word 2:7"),
        ("G0 X1 H3", "unused-word 2:7"),
        ("G1 X1e3", "unused-word 2:6"),
        ("G0 G1 X1", "modal-conflict 2:4"),
        ("M3 M4", "modal-conflict 2:4"),
        ("G39 X1", "unsupported-code 2:1"),
        ("M777", "unsupported-code 2:1"),
        ("G-1", "not-a-code 2:1"),
        ("G1.23", "not-a-code 2:1"),
        ("G2 G28 Z0", "two-axis-users 2:1"),
        ("G80 X1", "axes-not-allowed 2:1"),
        ("X1", "axis-without-code 2:1"),
        ("G92", "axes-missing 2:1"),
        ("G4", "word-missing 2:1"),
        ("G2 X10 I5 P0", "word-out-of-range 2:1"),
        ("G2 X10 I4", "arc-radii 2:1"),
        ("G2 X10 R4.99", "arc-radius-short 2:1"),
        ("G2 R5", "arc-same-point 2:1"),
        ("G2 X10", "arc-without-center 2:1"),
        ("G2 X10 R5 I5", "arc-two-formats 2:1"),
        ("G2 X10 I5 K1", "arc-off-plane 2:1"),
        ("G90.1 G2 X10 I5", "arc-center-word 2:7"),
        ("G2 X0.001 I0.0005", "arc-too-small 2:1"),
        ("G53 G2 X10 I5", "g53-without-motion 2:1"),
        ("G91 G53 G0 X1", "g53-incremental 2:5"),
        ("G43 H7", "no-such-tool 2:1"),
        ("T7", "no-such-tool 2:1"),
        ("M6", "no-tool-selected 2:1"),
        ("G0 X1e", "missing-number 2:7"),
        ("G0 X99999999999", "coordinate-too-large 2:1"),
        ("G4 P1234567890", "dwell-too-long 2:1"),
        ("o<x> call", "no-such-sub 2:1"),
        ("o1 endif", "flow 2:1"),
        ("o1 if [0]", "flow 2:1"),
        ("G93 G1 X1", "no-inverse-time-feed 2:5"),
        ("%", "text-before-percent 2:1"),
    ] {
        let found = found(body);
        assert_eq!(
            found.first().map(String::as_str),
            Some(expected),
            "{body}: {found:?}"
        );
    }
}

#[test]
fn all_mistakes_are_told_in_one_run_without_cascades() {
    let body = "G1 X10 Y\nG39 X5\nG1 X[1/0] Y[SQRT[-1]]\nX20\nG2 X30 I4\nG2 X40 I5\nG0 X0";
    assert_eq!(
        found(body),
        [
            "missing-number 2:9",
            "unsupported-code 3:1",
            "division-by-zero 4:4",
            "outside-domain 4:11",
            "arc-radii 6:1"
        ]
    );
}

#[test]
fn a_missing_feed_is_told_once() {
    let diagnostics = Program::new(
        &b"G1 X1\nX2\nG2 X4 I1\nF10\nX6 I1\nM2\n"[..],
        InterpreterConfig::default(),
    )
    .finish();
    assert_eq!(
        (diagnostics.errors(), diagnostics.kept()[0].code()),
        (1, "no-feed")
    );
}

#[test]
fn an_arc_says_its_radii_and_what_may_be_meant() {
    let diagnostics = Program::new(
        &b"F100\nG2 X10.06 I5\nM2\n"[..],
        InterpreterConfig::default(),
    )
    .finish();
    let text = diagnostics.kept()[0].to_string();
    assert_eq!(
        text,
        "error[arc-radii]: line 2, column 1: radius to start 5.0000 mm, to end 5.0600 mm, which differ by 0.0600: from X0 Y0 to X10.06 Y0 about X5 Y0 (the nearest centre with equal radii is I5.03 J0)"
    );
}

#[test]
fn what_users_write_is_accepted() {
    for source in [
        &b"\xef\xbb\xbfG21\nG0X1\nM2"[..],
        b"g21\r\ng0x1\r\nm2\r\n",
        b"G21\rG0X1\rM2",
        b"G0 X1\n",
        b"%\nG0 X1\n",
        b"%\nG0 X1\n%\nthis is not read",
        b"o1234\n(a program number)\ng0 x+0. 12 34 y --3\nm30",
        b"n10 /g0 x1\nm2",
        b"/n10 g0 x1\nm2",
        b"",
    ] {
        let diagnostics = Program::new(source, InterpreterConfig::default()).finish();
        let is_accepted = diagnostics.errors() == 0;
        assert_eq!(
            is_accepted,
            !source.starts_with(b"n10 /"),
            "{:?}",
            diagnostics.kept()
        );
    }
}

#[test]
fn block_delete_can_be_switched() {
    let source = &b"G0 X1\n/G0 X2\n / G0 X3\nM2\n"[..];
    let count = |block_delete| {
        let config = InterpreterConfig {
            block_delete,
            ..InterpreterConfig::default()
        };
        Program::new(source, config)
            .filter(|op| op.op.to_string().starts_with("STRAIGHT"))
            .count()
    };
    assert_eq!((count(false), count(true)), (3, 1));
}

#[test]
fn habits_are_told_once_with_their_count_and_refuse_nothing() {
    let source = "g21 g90\r\no<a> sub\r\n  g1x1f100\r\no<a> endsub\r\no<a> call\r\no<a> call\r\nG1 W2 U3\r\nM2\r\n";
    let told = |source: &str, config: InterpreterConfig| {
        let diagnostics = Program::new(source.as_bytes(), config).finish();
        let notes: Vec<String> = diagnostics
            .kept()
            .iter()
            .map(|d| format!("{} {}: {}", d.code(), d.place.span.line, d.problem))
            .collect();
        (
            (
                diagnostics.errors(),
                diagnostics.warnings(),
                diagnostics.notes(),
            ),
            notes,
        )
    };
    let (counts, notes) = told(source, InterpreterConfig::default());
    assert_eq!(counts, (0, 0, 4));
    assert_eq!(
        notes,
        [
            "lower-case 1: letters of words in lower case (3 times)",
            "crlf 1: lines that end with CR LF (7 times)",
            "no-blanks 3: words without blanks between them (2 times)",
            "uvw-axes 7: axes U, V and W, which most machines do not have",
        ]
    );
    let plain = source
        .replace('\r', "")
        .replace("g21 g90", "G21 G90")
        .replace("g1x1f100", "G1 X1 F100")
        .replace("W2 U3", "Y2 Z3");
    assert_eq!(
        told(&plain, InterpreterConfig::default()),
        ((0, 0, 0), Vec::new())
    );
    for leniency in [
        Leniency::LowerCase,
        Leniency::CrLf,
        Leniency::NoBlanks,
        Leniency::SecondaryAxes,
    ] {
        let usual = InterpreterConfig::default();
        let refusing = InterpreterConfig {
            leniencies: usual.leniencies.without(leniency),
            ..usual
        };
        let ((errors, ..), notes) = told(source, refusing);
        assert!(
            errors == 1 && notes.iter().any(|note| note.contains("not allowed")),
            "{leniency:?}: {notes:?}"
        );
    }
}
