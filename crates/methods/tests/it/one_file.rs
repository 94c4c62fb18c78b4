//! A compensator is one file and one line: the recipe of `docs/adding.md`, followed to the letter
//! in a copy of the crate.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The text of the first fenced block that opens with a line.
fn block<'a>(recipe: &'a str, opening: &str) -> &'a str {
    let (_, rest) = recipe.split_once(opening).unwrap();
    rest.split_once("```").unwrap().0
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// The workspace's manifest with the copy as its only member; other crates come from where they
/// are.
fn manifest(root: &Path) -> String {
    let text = fs::read_to_string(root.join("Cargo.toml")).unwrap();
    let shared = text.split_once("[workspace.package]").unwrap().1;
    let shared = shared.split_once("\n[package]").unwrap().0;
    let here = format!("path = \"{}/crates/", root.display());
    let shared = shared
        .replace("path = \"crates/", &here)
        .replace("path = \".\"", &format!("path = \"{}\"", root.display()));
    format!(
        "[workspace]\nresolver = \"3\"\nmembers = [\"crates/methods\"]\n\n[workspace.package]{shared}"
    )
}

#[test]
fn a_compensator_is_one_file_and_one_line() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let Some(root) = here
        .ancestors()
        .nth(2)
        .filter(|root| root.join("Cargo.lock").exists())
    else {
        return; // a packaged copy stands alone
    };
    let place = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("one-file");
    let crate_copy = place.join("crates/methods");
    let _ = fs::remove_dir_all(&crate_copy);
    copy(&here.join("src"), &crate_copy.join("src"));
    copy(&here.join("docs"), &crate_copy.join("docs"));
    let own = fs::read_to_string(here.join("Cargo.toml")).unwrap();
    let (before, after) = own.split_once("[dev-dependencies]").unwrap();
    let lints = after.split_once("[lints]").unwrap().1;
    fs::write(
        crate_copy.join("Cargo.toml"),
        format!("{before}[lints]{lints}"),
    )
    .unwrap();
    fs::write(place.join("Cargo.toml"), manifest(root)).unwrap();
    fs::copy(root.join("Cargo.lock"), place.join("Cargo.lock")).unwrap();

    let recipe = fs::read_to_string(here.join("docs/adding.md")).unwrap();
    let (file, line) = (
        block(&recipe, "```rust,ignore\n"),
        block(&recipe, "```text\n"),
    );
    fs::write(crate_copy.join("src/step.rs"), file).unwrap();
    let registry = crate_copy.join("src/lib.rs");
    let text = fs::read_to_string(&registry).unwrap();
    let (head, rows) = text.split_once("\nmethods! {\n").unwrap();
    fs::write(&registry, format!("{head}\nmethods! {{\n{line}{rows}")).unwrap();

    let output = Command::new(env!("CARGO"))
        .args(["check", "--offline", "--quiet", "--manifest-path"])
        .arg(crate_copy.join("Cargo.toml"))
        .env("CARGO_TARGET_DIR", place.join("target"))
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}
