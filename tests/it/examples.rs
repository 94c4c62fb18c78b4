//! The examples are run as a reader would run them, and print what they say at their end.

use std::path::Path;
use std::process::Command;

const EXAMPLES: &[&str] = &[
    "contour_error",
    "fit_gap",
    "kinematics",
    "one_axis",
    "own_compensator",
    "own_machine",
    "parse",
    "path",
    "plan",
    "report",
    "simulate",
];

/// Begins the lines at the end of an example that say what it prints.
const PRINTS: &str = "// Prints:\n";

/// What an example says that it prints.
fn promised(source: &str) -> String {
    let (_, lines) = source
        .split_once(PRINTS)
        .expect("every example ends with what it prints");
    let text = |line: &str| {
        line.trim_start_matches("//")
            .trim_start_matches(' ')
            .to_owned()
    };
    lines.lines().map(|line| text(line) + "\n").collect()
}

/// Runs cargo in the repository and gives what it prints.
fn cargo(args: &[&str]) -> String {
    let output = Command::new(env!("CARGO"))
        .args(args)
        .args(["--quiet", "--offline", "--features", "fit,report"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    assert!(
        output.status.success(),
        "{args:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).expect("text")
}

#[test]
fn examples_print_what_they_say() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    // All of them, so that one run tells every example whose figures have moved.
    let mut wrong = Vec::new();
    for name in EXAMPLES {
        let path = folder.join(format!("{name}.rs"));
        let source = std::fs::read_to_string(&path).expect("an example");
        let printed: String = cargo(&["run", "--example", name])
            .lines()
            .map(|line| format!("{}\n", line.trim_start_matches(' ')))
            .collect();
        let promised = promised(&source);
        if printed != promised {
            wrong.push(format!("{name} prints\n{printed}and promises\n{promised}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Examples that run for hours: compiled with the others, not run.
const SWEEPS: [&str; 1] = ["stop_margins"];

#[test]
fn every_example_is_listed() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let mut found: Vec<String> = std::fs::read_dir(folder)
        .expect("examples")
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|kind| kind == "rs"))
        .filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()))
        .collect();
    found.retain(|name| !SWEEPS.contains(&name.as_str()));
    found.sort();
    assert_eq!(found, EXAMPLES);
}
