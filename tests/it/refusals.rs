//! Bad input: a clear error with place and values, never a panic, nothing half done.

use crate::common::{machine, program, run};
use lostmotion::sim::{Machine, Program, SimError};

fn refusal(text: &str) -> String {
    match run(&program(text), &machine("vmc3"), &["none"]) {
        Ok(_) => panic!("accepted: {text}"),
        Err(SimError::Program { diagnostics, .. }) => diagnostics
            .kept()
            .iter()
            .map(|d| format!("{d}\n"))
            .collect(),
        Err(error) => error.to_string(),
    }
}

#[test]
fn programs_with_errors_name_place_and_values() {
    for (text, words) in [
        ("", &["moves nothing"][..]),
        ("\u{0}\u{1}\u{2}binary\n", &["line 1"]),
        ("G21 G90\nG1 X10\nM2\n", &["line 2", "feed"]),
        ("G21 F100\nG2 X10 Y0 I4 J0\nM2\n", &["line 2", "4", "6"]),
        (
            "G21 G90\nG0 X5000\nM2\n",
            &[
                "1 move goes",
                "axis X to 4619.000 mm",
                "limit of 0.000 mm",
                "more travel",
            ],
        ),
        ("G21 G90\nG1 A10 F100\nM2\n", &["line 2", "axis A"]),
        ("G21\nG123 X1\nM2\n", &["line 2", "G123"]),
    ] {
        let message = refusal(text);
        for word in words {
            assert!(
                message.contains(word),
                "{text:?} is refused without {word:?}: {message}"
            );
        }
    }
}

#[test]
fn all_errors_of_a_program_come_at_once() {
    let message = refusal("G21 F100\nG1 X\nG99999 X1\nX1 X2\nM2\n");
    for line in ["line 2", "line 3", "line 4"] {
        assert!(message.contains(line), "{line} is missing: {message}");
    }
}

#[test]
fn what_is_not_there_is_said() {
    let missing = Program::from_path("no/such/file.ngc");
    assert!(matches!(
        run(&missing, &machine("vmc3"), &["none"]),
        Err(SimError::Read { .. })
    ));
    let folder = Program::from_path(env!("CARGO_MANIFEST_DIR"));
    assert!(matches!(
        run(&folder, &machine("vmc3"), &["none"]),
        Err(SimError::Read { .. })
    ));
    let error = run(&program("G0 X1\nM2\n"), &machine("vmc3"), &["magic"])
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("magic") && error.contains("published"),
        "{error}"
    );
    assert!(Machine::preset("nonsense").is_err());
}
