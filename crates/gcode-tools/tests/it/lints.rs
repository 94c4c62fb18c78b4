//! Every lint on a program that it is for, and on one that it must leave alone.

use lostmotion_gcode::{InterpreterConfig, Program};
use lostmotion_gcode_tools::lint::{Level, Levels, lint, rules};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// A first line that sets every mode.
const HEAD: &str = "G21 G90 G17 G94 G54 G40 G49 G80\n";

/// Codes with lines of what the lints say.
fn linted(source: &str, levels: Levels) -> Vec<String> {
    let mut program = Program::new(source.as_bytes(), InterpreterConfig::default());
    let found = lint(&mut program, levels);
    found
        .kept()
        .iter()
        .map(|finding| format!("{} {}", finding.rule.code, finding.place.span.line))
        .collect()
}

/// Programs after the head: the lint that is expected with its line, and the same without the
/// mistake.
const CASES: &[(&str, &str, &str)] = &[
    ("dwell-endless 2", "G4 P5000\nM2", "G4 P50\nM2"),
    ("dwell-milliseconds 2", "G4 P500\nM2", "G4 P0.5\nM2"),
    (
        "dwell-milliseconds 3",
        "M3 S100\nG82 Z1 R2 P250 F100\nM2",
        "M3 S100\nG82 Z1 R2 P0.25 F100\nM2",
    ),
    ("rapid-plunge 3", "G0 X5 Z5\nZ-2\nM2", "G0 X5 Z5\nZ0\nM2"),
    (
        "rapid-plunge 3",
        "G0 Z5\nX1 Z-0.5\nM2",
        "G18\nG0 Z5\nX1 Z-0.5\nM2",
    ),
    (
        "rapid-plunge 6",
        "M3 S9 F100\nG1 Z-1\nG0 Z5\nX9\nZ-0.9\nM2",
        "M3 S9 F100\nG1 Z-1\nG0 Z5\nZ-0.9\nG1 Z-2\nG0 Z1\nG53 G0 Z-10\nG83 X5 Z-3 R1 Q1\nM2",
    ),
    (
        "rapid-below-surface 4",
        "M3 S9 F100\nG1 Z-1\nG0 X5\nM2",
        "M3 S9 F100\nG1 Z-1\nG0 Z1\nX5\nM2",
    ),
    (
        "rapid-below-surface 6",
        "G43.1 Z50\nG53 G0 Z0\nG1 Z-2 F100 M3 S9\nG0 Z-1\nX5\nM2",
        "G43.1 Z50\nG53 G0 Z0\nX5\nG28 Z5\nX0 Y0\nG30\nX5\nM2",
    ),
    (
        "arc-nearly-full 3",
        "F100 G0 X10\nG2 X10.0001 Y0.0000 I-10 J0\nM2",
        "F100 G0 X10\nG2 X10 Y0 I-10 J0\nG2 I-10\nG3 X-10 I-10\nM2",
    ),
    (
        "arc-nearly-full 3",
        "F100 G0 X10\nG3 X10 Y-0.01 I-10 J0\nM2",
        "F100 G0 X10\nG3 X9.998 Y-0.100 I-10.000 J0\nM2",
    ),
    (
        "arc-nearly-full 3",
        "F100 G0 X10\nG3 X10 Y-0.01 I-10.00 J0\nM2",
        "F100 G0 X10\nG3 X10 Y0.01 I-10.00 J0\nG2 X11 Y0 I100 J0\nM2",
    ),
    (
        "arc-nearly-half 2",
        "F100 G2 X7.071 Y7.071 R5.001\nM2",
        "F100 G2 X10 Y0 R5\nG2 X20 R9\nM2",
    ),
    (
        "arc-centers-mixed 3",
        "F100 G2 X10 I5\nG90.1 G2 X20 I15 J0\nM2",
        "F100 G2 X10 I5\nG2 X20 R5\nG90.1\nM2",
    ),
    ("feed-units 2", "G1 X1 F0.2\nM2", "G1 X1 F20\nM2"),
    (
        "feed-units 3",
        "G20 G1 X1 F1\nF2000\nM2",
        "G20\nG1 X1 F20\nM2",
    ),
    (
        "feed-units 3",
        "M3 S100\nG95 G1 X1 F200\nM2",
        "M3 S100\nG95 G1 X1 F0.2\nM2",
    ),
    (
        "spindle-off 4",
        "T1 M3 S100\nM6\nG1 X5 Z-1 F100 G43\nM2",
        "T1 M6\nG43\nM3 S100\nG1 X5 Z-1 F100\nM5\nG1 Z5\nM2",
    ),
    (
        "spindle-never-started 2",
        "G1 Z-1 F100\nM2",
        "G1 Z1 F100\nM2",
    ),
    ("spindle-no-speed 2", "M3\nM2", "S100\nM3\nM2"),
    (
        "tap-feed 3",
        "M3 S500 F680\nG84 X1 Z-9 R1\nM2",
        "M3 S500 F625\nG84 X1 Z-9 R1\nF635\nX2\nM2",
    ),
    ("units-changed 3", "G0 X1\nG20\nM2", "G20\nG0 X1\nM2"),
    (
        "line-number-twice 4",
        "N10 G0 X1\nN20 X2\nN10 X3\nN20 X4\nM2",
        "N10 G0 X1\nN9990 X2\nN10 X3\nM2",
    ),
    (
        "tool-length-missing 3",
        "T3 M6\nG0 Z5\nM2",
        "T3 M6\nG43 H3\nG0 Z5\nM2",
    ),
    (
        "tool-length-missing 5",
        "T3 M6\nG43 G0 Z5\nT4 M6\nG0 Z9\nM2",
        "T3 M6\nG0 X5\nG53 G0 Z0\nG43.1 Z10 G0 Z5\nM2",
    ),
    (
        "tool-length-other 3",
        "T3 M6\nG43 H4\nM2",
        "T3 M6\nG43 H3\nM2",
    ),
    (
        "tool-change-low 3",
        "M3 S9 F100 G1 Z-1\nT1 M6\nM2",
        "M3 S9 F100 G1 Z-1\nG0 Z1\nT1 M6\nM2",
    ),
    (
        "home-absolute 3",
        "G0 Z50\nG28 Z0\nM2",
        "G0 Z50\nG91 G28 Z0\nG90 G28 Z80\nG30\nM2",
    ),
    (
        "home-absolute 4",
        "M3 S9 F100\nG1 Z-1\nG28 X0 Y5\nM2",
        "G0 Z50\nG28 X0 Y5\nM2",
    ),
    (
        "compensation-left-on 5",
        "F100 G41.1 D2\nG1 X20\nY20\nM2",
        "F100 G41.1 D2\nG1 X20\nY20\nG40 X30\nM2",
    ),
    ("spindle-left-on 3", "M3 S100\nG0 X1", "M3 S100\nG0 X1\nM30"),
    ("coolant-left-on 3", "M8\nG0 X1", "M8\nG0 X1\nM9"),
    ("offset-left-on 3", "G92 X5\nM2", "G92 X5\nG92.1\nM2"),
    ("offset-left-on 3", "G52 X5\nM2", "G52 X5\nG52 X0\nM2"),
    (
        "unused-parameter 2",
        "#<depht> = 5\nG0 Z3\nM2",
        "#<depth> = 5\nG0 Z#<depth>\nM2",
    ),
    (
        "unused-parameter 2",
        "#101 = 5\nG0 Z3\nM2",
        "#101 = 5\n#1 = 101\n(debug, #2 #<a>)\n#2 = 1\n#<a> = 3\nG0 Z##1\nM2",
    ),
    (
        "unreachable-sub 2",
        "o<a> sub\nG0 X1\no<a> endsub\nG0 X0\nM2",
        "o<a> sub\nG0 X1\no<a> endsub\no<a> call\nM2",
    ),
    (
        "unreachable-sub 3",
        "M2\no200\nG0 X1\nM99",
        "M98 P200\nM2\no200\nG0 X1\nM99",
    ),
    (
        "code-after-end 3",
        "M2\nG0 X1",
        "M98 P7\nM2\n(done)\no7\nG0 X1\nM99",
    ),
    (
        "unreachable-sub 3",
        "M2\nO9\nG0 X1\nM99",
        "G0 X0\nO9\nG0 X1\nM2",
    ),
];

#[test]
fn each_lint_finds_its_mistake_and_no_other() {
    let mut failed = Vec::new();
    for (expected, wrong, right) in CASES {
        let found = linted(&format!("{HEAD}{wrong}\n"), Levels::default());
        if found != [*expected] {
            failed.push(format!("{wrong}: {found:?} instead of {expected}"));
        }
        let found = linted(&format!("{HEAD}{right}\n"), Levels::default());
        if !found.is_empty() {
            failed.push(format!("{right}: {found:?} instead of nothing"));
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n\n"));
}

#[test]
fn modes_that_are_relied_on_are_told_where_they_first_matter() {
    let found = linted(
        "G0 Z5\nM3 S100\nG1 X1 F100\nG2 X3 I1\nM2\n",
        Levels::default(),
    );
    assert_eq!(
        found,
        [
            "unset-units 1",
            "unset-distance 1",
            "unset-work-offset 1",
            "unset-feed-mode 3",
            "unset-plane 4"
        ]
    );
    assert!(
        linted(
            "G21 G90 G54\nG0 X1\nG94 G17\nG1 X2 F100\nG2 X3 R2\nM2\n",
            Levels::default()
        )
        .is_empty()
    );
    assert!(linted("(nothing moves)\nM2\n", Levels::default()).is_empty());
}

#[test]
fn every_lint_has_a_case() {
    let mut tried: BTreeSet<&str> = CASES
        .iter()
        .filter_map(|(expected, ..)| expected.split(' ').next())
        .collect();
    tried.extend([
        "unset-units",
        "unset-distance",
        "unset-work-offset",
        "unset-feed-mode",
        "unset-plane",
    ]);
    // Lints of the machine are tried where machines are: in the command line's tests.
    tried.insert("outside-travel");
    assert_eq!(tried, rules::all().map(|rule| rule.code).collect());
}

#[test]
fn levels_switch_lints_off_and_make_them_errors() {
    let source = format!("{HEAD}G4 P500\n#1=2\nM2\n");
    let mut levels = Levels::default();
    levels.set("dwell-milliseconds", Level::Allow);
    assert_eq!(linted(&source, levels.clone()), ["unused-parameter 3"]);
    levels.set("all", Level::Deny);
    levels.set("unused-parameter", Level::Warn);
    let mut program = Program::new(source.as_bytes(), InterpreterConfig::default());
    let found = lint(&mut program, levels);
    assert_eq!((found.warned(), found.denied()), (1, 1));
}

#[test]
fn findings_are_bounded_and_counted() {
    let body: String = (0..1000).map(|n| format!("G0 X{n} Z1\nZ-1\n")).collect();
    let mut program = Program::new(body.as_bytes(), InterpreterConfig::default());
    let mut levels = Levels::default();
    levels.set("all", Level::Allow);
    levels.set("rapid-plunge", Level::Warn);
    let found = lint(&mut program, levels);
    assert_eq!((found.warned(), found.kept().len()), (1000, 20));
    // A loop says it once.
    let source = format!("{HEAD}o1 repeat [50]\nG0 Z5\nG0 Z-1\no1 endrepeat\nM2\n");
    assert_eq!(linted(&source, Levels::default()), ["rapid-plunge 4"]);
}

#[test]
fn programs_that_hold_much_are_watched_all_the_same() {
    let held = "F100 G41.1 D2\no1 repeat [20000]\nG4 P0\no1 endrepeat\nG1 X5\nX9\nM2\n".to_owned();
    let curve = format!(
        "F100\n{}G5.3\nM2\n",
        "G5.2 X1 Y1 P1\nG5.2 X2 Y1 P1\n".repeat(10_000)
    );
    for source in [held, curve] {
        let mut levels = Levels::default();
        levels.set("all", Level::Allow);
        let mut program = Program::new(source.as_bytes(), InterpreterConfig::default());
        assert!(lint(&mut program, levels).kept().is_empty());
        assert_eq!(
            program.diagnostics().errors(),
            0,
            "{:?}",
            program.diagnostics().kept()
        );
        assert!(program.interpreter().state().ended);
    }
}

#[test]
fn all_lints_are_in_the_list() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lint");
    let list = fs::read_to_string(folder.join("mod.rs")).unwrap();
    let mut lints = 0;
    for entry in fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        let file = path.file_stem().unwrap().to_str().unwrap();
        let text = fs::read_to_string(&path).unwrap();
        for line in text.lines() {
            let Some(rest) = line.strip_prefix("pub(super) const ") else {
                continue;
            };
            if let Some(name) = rest.strip_suffix(": Lint = Lint {") {
                assert!(list.contains(&format!("    {file}::{name},\n")), "{file}");
                lints += 1;
            }
        }
    }
    assert!(lints > 10);
}
