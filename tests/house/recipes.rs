//! The changes that the book shows for people who add something apply to today's sources.

use crate::sources::repository;
use std::fs;

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
