//! The changes that the book shows for people who add something apply to today's sources, and what
//! they make of them compiles.

use crate::sources::repository;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A change of one file: its path, and for each hunk the lines of `diff` with their first character.
struct Change<'a> {
    /// `None` for a new file.
    before: Option<&'a str>,
    after: &'a str,
    hunks: Vec<Vec<&'a str>>,
}

/// The changes in the `diff` blocks of a page.
fn changes(page: &str) -> Vec<Change<'_>> {
    let mut changes: Vec<Change<'_>> = Vec::new();
    let mut inside = false;
    let mut before = None;
    for line in page.lines() {
        if line.starts_with("```") {
            inside = line.starts_with("```diff");
        } else if !inside {
        } else if let Some(path) = line.strip_prefix("--- ") {
            before = path.strip_prefix("a/");
        } else if let Some(path) = line.strip_prefix("+++ b/") {
            changes.push(Change {
                before,
                after: path,
                hunks: Vec::new(),
            });
        } else if line.starts_with("@@") {
            changes.last_mut().expect("a file").hunks.push(Vec::new());
        } else {
            let hunks = &mut changes.last_mut().expect("a file").hunks;
            hunks.last_mut().expect("a hunk").push(line);
        }
    }
    changes
}

/// Whether lines stand in a text one after the other.
fn stand_in(text: &str, wanted: &[&str]) -> bool {
    let lines: Vec<&str> = text.lines().collect();
    lines.windows(wanted.len()).any(|window| window == wanted)
}

/// Crates that recipes change, and those that lie between them: no crate may come from two places.
/// They are copied side by side, changed, and compiled in one go; all other crates come from where
/// they are.
const COPIED: [&str; 5] = ["gcode", "gcode-tools", "kinematics", "plan", "sim"];

/// Copies the files of a folder and of those below it.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("an entry");
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).expect("a copy");
        }
    }
}

/// The manifest of a workspace whose members are the copies.
fn manifest(root: &Path) -> String {
    let text = fs::read_to_string(root.join("Cargo.toml")).expect("a manifest");
    let (_, shared) = text.split_once("[workspace.package]").expect("a workspace");
    let (shared, _) = shared.split_once("\n[package]").expect("a package");
    let mut shared = shared
        .replace("\"crates/", &format!("\"{}/crates/", root.display()))
        .replace("\".\"", &format!("\"{}\"", root.display()));
    let mut members = String::new();
    for name in COPIED {
        let here = format!("crates/{name}\"");
        shared = shared.replace(&format!("{}/{here}", root.display()), &here);
        members += &format!("\"{here}, ");
    }
    format!("[workspace]\nresolver = \"3\"\nmembers = [{members}]\n\n[workspace.package]{shared}")
}

/// A crate's manifest without what only its tests and benches need.
fn without_tests(manifest: &str) -> String {
    let (before, after) = manifest.split_once("[dev-dependencies]").expect("a table");
    let (_, lints) = after.split_once("[lints]").expect("a table");
    format!("{before}[lints]{lints}")
}

/// A text with the lines of a hunk in place of those that it replaces.
fn patched(text: &str, hunk: &[&str]) -> String {
    let side = |gone: char| -> String {
        let kept = hunk.iter().filter(|line| !line.starts_with(gone));
        kept.map(|line| line.get(1..).unwrap_or_default().to_owned() + "\n")
            .collect()
    };
    text.replacen(&side('+'), &side('-'), 1)
}

#[test]
fn recipes_compile() {
    let root = repository().canonicalize().expect("the repository");
    let page = fs::read_to_string(root.join("docs/book/src/hacking/adding.md")).expect("the page");
    let temporary = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let place = temporary.join("recipes");
    for name in COPIED {
        let (from, to) = (
            root.join("crates").join(name),
            place.join("crates").join(name),
        );
        let _ = fs::remove_dir_all(&to);
        // The machines that come with sim are part of its sources.
        for part in ["src", "presets"] {
            if from.join(part).is_dir() {
                copy(&from.join(part), &to.join(part));
            }
        }
        let own = fs::read_to_string(from.join("Cargo.toml")).expect("a manifest");
        fs::write(to.join("Cargo.toml"), without_tests(&own)).expect("a file");
    }
    fs::write(place.join("Cargo.toml"), manifest(&root)).expect("a file");
    fs::copy(root.join("Cargo.lock"), place.join("Cargo.lock")).expect("a copy");

    let mut applied = 0;
    for change in changes(&page) {
        let is_in = |name: &&str| change.after.starts_with(&format!("crates/{name}/src/"));
        if !COPIED.iter().any(is_in) {
            continue;
        }
        let path = place.join(change.after);
        let mut text = match change.before {
            Some(_) => fs::read_to_string(&path).expect("a file"),
            None => String::new(),
        };
        for hunk in &change.hunks {
            text = patched(&text, hunk);
        }
        fs::write(&path, text).expect("a file");
        applied += 1;
    }
    assert!(
        applied >= 10,
        "a kinematics, a lint, a diagnostic, a G-code and a format are {applied} changes"
    );

    // the dependencies are compiled once for this test and for that of a compensator
    let output = Command::new(env!("CARGO"))
        .args(["check", "--offline", "--quiet", "--manifest-path"])
        .arg(place.join("Cargo.toml"))
        .env("CARGO_TARGET_DIR", temporary.join("one-file/target"))
        .output()
        .expect("cargo");
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success() && !told.contains("warning"),
        "{told}"
    );
}

#[test]
fn recipes_apply_to_the_sources() {
    let root = repository();
    let page = fs::read_to_string(root.join("docs/book/src/hacking/adding.md")).expect("the page");
    let changes = changes(&page);
    assert!(!changes.is_empty(), "the page has changes");
    let mut faults = String::new();
    for change in changes {
        let Some(path) = change.before else {
            let folder = root.join(change.after);
            if folder.exists() || !folder.parent().is_some_and(std::path::Path::is_dir) {
                faults += &format!("{}: is no new file of a folder\n", change.after);
            }
            continue;
        };
        let Ok(text) = fs::read_to_string(root.join(path)) else {
            faults += &format!("{path}: does not exist\n");
            continue;
        };
        for hunk in change.hunks {
            let old: Vec<&str> = hunk
                .iter()
                .filter(|line| !line.starts_with('+'))
                .map(|line| line.get(1..).unwrap_or_default())
                .collect();
            if !stand_in(&text, &old) {
                faults += &format!("{path}: does not have\n{}\n", old.join("\n"));
            }
        }
    }
    assert!(faults.is_empty(), "recipes that do not apply:\n{faults}");
}
