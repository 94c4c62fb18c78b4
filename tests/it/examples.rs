//! The examples print what they say at their end.

use std::env::consts::EXE_EXTENSION;
use std::path::{Path, PathBuf};
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

/// The folder of the compiled examples.
///
/// They are compiled together with those of the whole workspace, as `cargo test --workspace` has done: for
/// one package alone the features of its dependencies are others, and all would be compiled once more.
fn compiled() -> PathBuf {
    let test = std::env::current_exe().expect("the path of this test");
    let folder = test.ancestors().nth(2).expect("deps below a profile");
    let target = folder.parent().expect("profiles below the target");
    let mut cargo = Command::new(env!("CARGO"));
    cargo
        .args(["build", "--workspace", "--examples", "--quiet", "--offline"])
        .arg("--target-dir")
        .arg(target)
        .current_dir(env!("CARGO_MANIFEST_DIR"));
    if folder.ends_with("release") {
        cargo.arg("--release");
    }
    let output = cargo.output().expect("cargo runs");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    folder.join("examples")
}

/// Runs an example in the repository and gives what it prints.
fn printed(example: &Path) -> String {
    let output = Command::new(example)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("the example runs");
    assert!(
        output.status.success(),
        "{}: {}",
        example.display(),
        String::from_utf8_lossy(&output.stderr)
    );
    let text = String::from_utf8(output.stdout).expect("text");
    text.lines()
        .map(|line| format!("{}\n", line.trim_start_matches(' ')))
        .collect()
}

#[test]
fn examples_print_what_they_say() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let compiled = compiled();
    // All of them, so that one run tells every example whose figures have moved.
    let mut wrong = Vec::new();
    for name in EXAMPLES {
        let path = folder.join(format!("{name}.rs"));
        let source = std::fs::read_to_string(&path).expect("an example");
        let printed = printed(&compiled.join(name).with_extension(EXE_EXTENSION));
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
