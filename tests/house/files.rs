//! A file holds one idea whole, and a package builds from its own files.

use crate::sources::{Package, code_folders, packages, repository, rust_files, shown};
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Lines of the shortest file under `src`; a shorter one belongs into the file that it serves. A
/// crate's or module's root that only lists its parts may be shorter.
const SHORTEST_LINES: usize = 25;

/// Lines of the longest file under `src`.
const LONGEST_LINES: usize = 900;

/// Crates with files outside these bounds. Take a crate out once it is clean.
const STILL_OUTSIDE_BOUNDS: &[&str] = &[];

/// Crates with paths that lead out of their package. Take a crate out once it is clean.
const STILL_LEAVING: &[&str] = &[];

#[test]
fn files_are_neither_crumbs_nor_walls() {
    let mut faults = String::new();
    for package in packages() {
        if STILL_OUTSIDE_BOUNDS.contains(&package.name.as_str()) {
            continue;
        }
        for file in rust_files(&package.root.join("src")) {
            let lines = fs::read_to_string(&file)
                .expect("a source file")
                .lines()
                .count();
            let root = file.ends_with("lib.rs") || file.ends_with("mod.rs");
            let shortest = if root { 1 } else { SHORTEST_LINES };
            if !(shortest..=LONGEST_LINES).contains(&lines) {
                faults += &format!("{}: {lines} lines\n", shown(&file));
            }
        }
    }
    assert!(
        faults.is_empty(),
        "files outside {SHORTEST_LINES} to {LONGEST_LINES} lines:\n{faults}"
    );
}

/// `cargo package` takes the files of one package; `#[path]`, `include!`, `include_str!` and
/// `include_bytes!` of anything else would leave it incomplete.
#[test]
fn no_path_leaves_its_package() {
    let mut faults = String::new();
    for package in packages() {
        if STILL_LEAVING.contains(&package.name.as_str()) {
            continue;
        }
        for file in code_folders(&package)
            .iter()
            .flat_map(|folder| rust_files(folder))
        {
            let text = fs::read_to_string(&file).expect("a source file");
            for named in named_files(&text) {
                let target = plain(&file.parent().expect("a folder").join(&named));
                if !belongs_to(&target, &package) {
                    faults += &format!("{}: \"{named}\"\n", shown(&file));
                }
            }
        }
    }
    assert!(
        faults.is_empty(),
        "paths that leave their package:\n{faults}"
    );
}

/// The literal of each `#[path = ".."]` and `include..!("..")`.
fn named_files(text: &str) -> Vec<String> {
    let starts = [
        "#[path = \"",
        "include!(\"",
        "include_str!(\"",
        "include_bytes!(\"",
    ];
    let mut named = Vec::new();
    for line in text
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
    {
        for start in starts {
            if let Some((_, rest)) = line.split_once(start)
                && let Some((name, _)) = rest.split_once('"')
            {
                named.push(name.to_string());
            }
        }
    }
    named
}

/// Resolves `.` and `..` by the text alone.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                plain.pop();
            }
            other => plain.push(other),
        }
    }
    plain
}

fn belongs_to(target: &Path, package: &Package) -> bool {
    let inside = target.starts_with(&package.root);
    let other_package = ["crates", "fuzz"].map(|folder| repository().join(folder));
    let facade = package.root == repository();
    inside && !(facade && other_package.iter().any(|other| target.starts_with(other)))
}
