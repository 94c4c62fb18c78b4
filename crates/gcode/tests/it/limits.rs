//! Every limit does what it says: a program below it passes, one above it has the limit's own
//! error, and a higher limit lets it through.
use lostmotion_gcode::{Diagnostics, InterpreterConfig, Limits, Program, Severity};
use std::collections::BTreeSet;

fn run(program: &str, name: &str, value: &str) -> Diagnostics {
    let mut limits = Limits::default();
    limits.set(name, value).unwrap();
    Program::new(
        program.as_bytes(),
        InterpreterConfig {
            limits,
            ..InterpreterConfig::default()
        },
    )
    .finish()
}

/// Structures that lie in one another.
fn nested(levels: usize) -> String {
    let open: String = (1..=levels)
        .map(|level| format!("o{level} if [1]\n"))
        .collect();
    let close: String = (1..=levels)
        .rev()
        .map(|level| format!("o{level} endif\n"))
        .collect();
    format!("{open}{close}M2\n")
}

/// Subroutines of which each calls the one before.
fn chain(levels: usize) -> String {
    let subs: String = (1..=levels)
        .map(|level| {
            let call = if level > 1 {
                format!("o{} call\n", level - 1)
            } else {
                String::new()
            };
            format!("o{level} sub\n{call}o{level} endsub\n")
        })
        .collect();
    format!("{subs}o{levels} call\nM2\n")
}

fn repeated(line: &str, times: usize) -> String {
    format!("o1 repeat [{times}]\n{line}\no1 endrepeat\nM2\n")
}

fn lines(line: &str, times: usize) -> String {
    format!("{}M2\n", format!("{line}\n").repeat(times))
}

fn curve(points: usize) -> String {
    let middle: String = (0..points)
        .map(|point| format!("X{} Y{} P1\n", point + 1, point % 2))
        .collect();
    format!("F100\nG5.2 P1 L2\n{middle}G5.3\nM2\n")
}

/// Limit with its value, a program below it and one above, and the code of the error.
fn cases() -> Vec<(&'static str, &'static str, String, String, &'static str)> {
    let both = |below: &str, above: &str| (format!("{below}\nM2\n"), format!("{above}\nM2\n"));
    let rows: [(&str, &str, (String, String), &str); 18] = [
        (
            "line_bytes",
            "20",
            both("G0 X1 (a comment...)", "G0 X1 (a comment....)"),
            "line-too-long",
        ),
        (
            "source_bytes",
            "14",
            (lines("G0 X1", 2), lines("G0 X1", 3)),
            "source-too-long",
        ),
        (
            "words",
            "3",
            both("G0 X1 Y1", "G0 X1 Y1 Z1"),
            "too-many-words",
        ),
        (
            "expression_depth",
            "3",
            both("G0 X[[[1]]]", "G0 X[[[[1]]]]"),
            "too-deep",
        ),
        (
            "executed_blocks",
            "4",
            (lines("G0 X1", 3), lines("G0 X1", 4)),
            "too-many-blocks",
        ),
        (
            "looped_blocks",
            "5",
            (repeated("G0 X1", 3), repeated("G0 X1", 4)),
            "too-many-looped-blocks",
        ),
        (
            "looped_operations",
            "5",
            (repeated("G0 X1", 6), repeated("G0 X1", 7)),
            "too-many-operations",
        ),
        (
            "idle_blocks",
            "5",
            (repeated("#1=1", 3), repeated("#1=1", 4)),
            "idle-loop",
        ),
        ("call_depth", "3", (chain(3), chain(4)), "calls-too-deep"),
        (
            "open_structures",
            "3",
            (nested(3), nested(4)),
            "too-many-open",
        ),
        (
            "held_bytes",
            "100",
            both(
                "o1 sub\nG0 X1\no1 endsub",
                "o1 sub\nG0 X1\nG0 X2\nG0 X3\nG0 X4\no1 endsub",
            ),
            "too-much-held",
        ),
        (
            "coordinate",
            "10",
            both("G0 X-10", "G0 X-10.001"),
            "coordinate-too-large",
        ),
        (
            "radius_mm",
            "10",
            both("F100 G2 I10", "F100 G2 I10.001"),
            "radius-too-large",
        ),
        ("feed", "100", both("F100", "F100.001"), "feed-too-large"),
        ("dwell_s", "5", both("G4 P5", "G4 P5.001"), "dwell-too-long"),
        (
            "cycle_moves",
            "10",
            both("F100 G83 Z-2 R0 Q1", "F100 G83 Z-3 R0 Q1"),
            "cycle-too-long",
        ),
        ("curve_points", "4", (curve(3), curve(9)), "curve-too-long"),
        (
            "named_parameters",
            "2",
            both("#<a>=1\n#<b>=2", "#<a>=1\n#<b>=2\n#<c>=3"),
            "too-many-parameters",
        ),
    ];
    rows.into_iter()
        .map(|(name, value, (below, above), code)| (name, value, below, above, code))
        .collect()
}

#[test]
fn each_limit_has_its_own_error_and_can_be_raised() {
    let mut seen = BTreeSet::from(["diagnostics"]);
    for (name, value, below, above, code) in cases() {
        assert_eq!(
            run(&below, name, value).errors(),
            0,
            "{name}, below: {:?}",
            run(&below, name, value).kept()
        );
        let found = run(&above, name, value);
        let own = found
            .kept()
            .iter()
            .find(|one| one.code() == code)
            .unwrap_or_else(|| panic!("{name}: {:?}", found.kept()));
        assert_eq!(
            (own.problem.limit(), own.severity()),
            (Some(name), Severity::Error)
        );
        assert!(own.problem.to_string().contains(value), "{name}: {own}");
        assert!(
            own.hint().unwrap().contains(&format!("--limit {name}=")),
            "{own}"
        );
        let raised = run(&above, name, "1000000");
        assert_eq!(raised.errors(), 0, "{name}, raised: {:?}", raised.kept());
        assert!(seen.insert(name), "{name} twice");
    }
    let all: BTreeSet<&str> = Limits::rows().iter().map(|row| row.name).collect();
    assert_eq!(seen, all);
}

#[test]
fn diagnostics_beyond_the_limit_are_counted() {
    let found = run("G1 X?\nG1 Y?\nG1 Z?\nM2\n", "diagnostics", "2");
    assert_eq!(
        (found.errors(), found.kept().len(), found.dropped()),
        (3, 2, 1)
    );
    assert_eq!(run("G1 X?\nG1 Y?\nM2\n", "diagnostics", "2").dropped(), 0);
}
