//! What a line is said to do.
use lostmotion_gcode::{Dialect, InterpreterConfig, Program};
use lostmotion_gcode_tools::explain::{Explanation, explain};

fn explained(text: &str, line: u32) -> Option<Explanation> {
    explain(
        &mut Program::new(text.as_bytes(), InterpreterConfig::default()),
        line,
    )
}

fn parts(explanation: &Explanation) -> Vec<String> {
    explanation
        .parts
        .iter()
        .map(|part| format!("{} = {}", part.text, part.meaning))
        .collect()
}

#[test]
fn words_are_said_in_plain_language() {
    let text = "G21 G90 G17 F100\n#1 = 4\n/N7 G2 X[2*#1] I4 J0 F250 (half) #1=[#1+1]\nM2\n";
    let explanation = explained(text, 3).unwrap();
    assert_eq!(
        parts(&explanation),
        [
            "/ = skipped if block delete is on",
            "N7 = line number",
            "G2 = arc or helix, clockwise (motion mode)",
            "X[2*#1] = X to 8 mm",
            "I4 = centre 4 from the start in X",
            "J0 = centre 0 from the start in Y",
            "F250 = feed rate 250 mm/min",
            "half = comment",
            "#1=[#1+1] = parameter #1 becomes 5",
        ]
    );
    let first = explanation.first.unwrap();
    assert_eq!(
        first.actions[1..],
        [
            "feed rate 250",
            "clockwise arc about X4 Y0 of radius 4.0000 mm to X8 (from 0)"
        ]
    );
    assert_eq!(
        (first.before.position[0], first.after.position[0]),
        (0.0, 8.0)
    );
    assert!(explanation.last.is_none() && !first.refused);
}

#[test]
fn words_of_cycles_and_computed_words_are_known_by_their_code() {
    let explanation = explained("G21 G91 F100\nG81 Z[-1-1] R3 P1\nM2\n", 2).unwrap();
    assert_eq!(
        parts(&explanation)[1..],
        [
            "Z[-1-1] = Z by -2 mm",
            "R3 = R of G81: 3",
            "P1 = P of G81: 1"
        ]
    );
    let explanation = explained("G4 P0.5\nM2\n", 1).unwrap();
    assert_eq!(
        parts(&explanation),
        [
            "G4 = dwell for P seconds (action of the line)",
            "P0.5 = P of G4: 0.5"
        ]
    );
    assert_eq!(explanation.first.unwrap().actions, ["wait for 0.5 s"]);
}

#[test]
fn blocks_in_loops_and_subroutines_have_their_count_and_calls() {
    let text = "o<hole> sub\n  o1 repeat [3]\n    G91 G0 X#1\n  o1 endrepeat\no<hole> endsub\no<hole> call [2]\no<hole> call [5]\nM2\n";
    let explanation = explained(text, 3).unwrap();
    assert_eq!((explanation.executions, explanation.passed_over), (6, 1));
    let (first, last) = (explanation.first.unwrap(), explanation.last.unwrap());
    assert_eq!(
        (first.before.position[0], last.after.position[0]),
        (0.0, 21.0)
    );
    assert_eq!(
        (
            first.calls[0].sub.as_str(),
            first.calls[0].line,
            last.calls[0].line
        ),
        ("hole", 6, 7)
    );
    assert_eq!(first.actions, ["rapid to X2 (from 0), 2.0000 mm"]);
}

#[test]
fn moves_that_compensation_holds_back_belong_to_their_line() {
    let explanation = explained("G21 F100 G41.1 D2\nG1 X20\nY20\nX0\nG40 Y50\nM2\n", 3).unwrap();
    let actions = explanation.first.unwrap().actions;
    assert_eq!(actions.len(), 1);
    assert!(actions[0].starts_with("feed to"), "{actions:?}");
}

#[test]
fn lines_that_never_run_say_why() {
    let text = "o1 if [0]\nG0 X1\no1 endif\nM2\nG0 X2\n";
    assert_eq!(
        explained(text, 2).unwrap().never,
        Some("it was only passed over: its branch is not taken, or its subroutine is not called")
    );
    let after = explained(text, 5).unwrap();
    assert_eq!(
        (after.never, after.text.as_str(), after.executions),
        (Some("the program ends before it"), "G0 X2", 0)
    );
    assert_eq!(parts(&after)[1], "X2 = X 2");
    assert!(explained(text, 6).is_none());
    assert!(explained("G1 X1\nM2\n", 1).unwrap().first.unwrap().refused);
}

#[test]
fn the_text_shows_what_changes() {
    let text = explained("G21 G90 G54\nG0 X1 Y2\nM3 S500\nM2\n", 3)
        .unwrap()
        .to_string();
    assert!(
        text.starts_with("line 3: M3 S500\n  M3    spindle on, clockwise (spindle)\n  S500  spindle speed 500\n\ncarried out once\n"),
        "{text}"
    );
    assert!(
        text.contains(
            "  * spindle             stopped (M5), S0 rev/min  ->  clockwise (M3), S500 rev/min\n"
        ),
        "{text}"
    );
    assert!(
        text.contains("    position            X1.0000 Y2.0000 Z0.0000\n"),
        "{text}"
    );
}

#[test]
fn a_mode_that_the_line_does_not_say_is_said() {
    let text =
        "G21 G90 F100\nG1 X5\nX10\nN7 G91 Y2\nG92 X0\nF200\nG2 X4 I2\nI2\nG81 Z-1 R1\nX9\nM2\n";
    assert_eq!(
        parts(&explained(text, 3).unwrap()),
        [
            "(G1) = not on the line: the motion mode in force, feed in a straight line",
            "X10 = X to 10 mm"
        ]
    );
    // After the number of the line, before its own codes.
    assert_eq!(
        parts(&explained(text, 4).unwrap())[..2],
        [
            "N7 = line number",
            "(G1) = not on the line: the motion mode in force, feed in a straight line"
        ]
    );
    let first = |line: u32| parts(&explained(text, line).unwrap())[0].clone();
    assert!(first(8).starts_with("(G2) = "), "{}", first(8));
    assert!(first(10).starts_with("(G81) = "), "{}", first(10));
    // Lines that say their motion, take their words otherwise, or do not move.
    for line in [2, 5, 6, 7, 9] {
        assert!(!first(line).starts_with('('), "{}", first(line));
    }
}

/// The systems beyond G59.3 have the name that the control has for them.
#[test]
fn work_systems_have_their_names() {
    let named = |text: &str, dialect: Dialect| {
        let config = InterpreterConfig::default().with_dialect(dialect);
        let mut program = Program::new(text.as_bytes(), config);
        let explanation = explain(&mut program, 2).unwrap();
        let modes = explanation.first.unwrap().after.modes;
        let mode = modes.iter().find(|mode| mode.name == "work offset");
        mode.unwrap().value.clone()
    };
    for (text, dialect, name) in [
        ("G21\nG59.3\nM2\n", Dialect::LinuxCnc, "G59.3: none"),
        ("G21\nG54.1 P7\nM30\n", Dialect::Fanuc, "G54.1 P7: none"),
        ("G21\nG54.1 P300\nM30\n", Dialect::Fanuc, "G54.1 P300: none"),
        ("G21\nG154 P99\nM30\n", Dialect::Haas, "G154 P99: none"),
        ("G21\nG110\nM30\n", Dialect::Haas, "G154 P1: none"),
    ] {
        assert_eq!(named(text, dialect), name, "{text}");
    }
}
